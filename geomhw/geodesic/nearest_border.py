"""Points of filled regions at which the shortest paths from there to vertices start."""

from contextlib import suppress

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.exact import Arrivals
from geomhw.geodesic.straightest import StraightestGeodesics
from geomhw.geodesic.unfolded_faces import Surface, triangle
from geomhw.mesh.triangle_mesh import TriangleMesh


def nearest_starts(mesh: TriangleMesh, arrivals: Arrivals, targets: Ints) -> tuple[Ints, Floats]:
    """Return faces, (k,), and barycentric coordinates, (k, 3), of the starts of the shortest paths to vertices, (k,).

    arrivals: with finite distances of the targets.
    """
    lines = StraightestGeodesics(mesh)
    faces, weights = np.empty(len(targets), dtype=np.int64), np.empty((len(targets), 3))
    for i, v in enumerate(targets.tolist()):
        while arrivals.distance[v] > 0 and (before := _turn(lines.surface, arrivals, v)) is not None:
            v = before
        if arrivals.distance[v] > 0:
            faces[i], weights[i] = _start_on_edge(lines, arrivals, v, -1 - int(arrivals.origin[v]))
        else:
            faces[i], corner = divmod(int(lines.surface.corners[lines.surface.starts[v]]), 3)
            weights[i] = np.eye(3)[corner]
    return faces, weights


def _turn(surface: Surface, arrivals: Arrivals, v: int) -> int | None:
    """Return the vertex at which the last straight line to v starts; None if it starts on an edge."""
    if arrivals.halfedge[v] >= 0 and (end := arrivals.along_edge(surface, v)) is not None:
        return end
    return int(arrivals.origin[v]) if arrivals.origin[v] >= 0 else None


def _start_on_edge(lines: StraightestGeodesics, arrivals: Arrivals, v: int, h: int) -> tuple[int, Floats]:
    """Return face and barycentric coordinates at which the line to a vertex leaves an edge, as a right angle."""
    surface, entered = lines.surface, int(arrivals.halfedge[v])
    edge, end = triangle(surface, h), surface.points[v]
    if entered >= 0:
        crossed = triangle(surface, entered)
        p, q = surface.points[crossed.low], surface.points[crossed.high]
        back = p + (q - p) * (arrivals.entry[v] / crossed.base) - end
        with suppress(ArgumentError):  # where the line is too short for a direction
            end = lines.from_corner(entered, back, float(arrivals.distance[v])).positions[-1]
    low, high = surface.points[edge.low], surface.points[edge.high]
    share = min(max(float((end - low) @ (high - low)) / edge.base**2, 0.0), 1.0)
    corners = surface.faces[h // 3]
    return h // 3, (corners == edge.low) * (1 - share) + (corners == edge.high) * share
