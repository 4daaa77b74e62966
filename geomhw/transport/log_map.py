"""Logarithmic map: polar coordinates around a source, by the directions in which exact shortest paths start."""

from math import inf

import numpy as np

from geomhw.errors import ArgumentError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.start_directions import start_directions
from geomhw.geodesic.vertex_fans import VertexFan, vertex_fan
from geomhw.mesh.inserted_points import insert_points
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result


class LogarithmicMap:
    """Logarithmic map on one mesh: the inverse of the exponential map, within the cut locus.

    Parameters
    ----------
    mesh : any triangle mesh.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> result = LogarithmicMap(grid(2, 2)).from_source(vertex_points(grid(2, 2), [4]))
    >>> result["radius"].round(3).tolist()
    [0.707, 0.5, 0.707, 0.5, 0.0, 0.5, 0.707, 0.5, 0.707]
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self._solver: ExactDistance | None = None

    def from_source(self, source: SurfacePoints, radius: float = inf) -> Result:
        """Return polar coordinates around a vertex or a point within a face.

        Parameters
        ----------
        source : SurfacePoints
            One point.
        radius : float
            Largest distance. Time is spent within it only.

        Returns
        -------
        Result with fields per vertex: ``radius``, the exact distance (inf where no path leads, or beyond the given
        one); ``angle``, radians in (-π, π], counterclockwise from the first edge of the vertex's first face, or of the
        face that contains the point; ``log``, (n, 2), radius times the cosine and sine of the angle. Angles around an
        inner vertex are scaled to sum to 2π. Where a shortest path turns, the angle is that of its start. ``angle`` and
        ``log`` are NaN where ``radius`` is inf, and where a path leaves the source along an edge of length zero. At the
        source all are 0.

        Raises
        ------
        ArgumentError
            If there is not one point, the radius is negative, or the vertex is not manifold.
        FieldError
            If the point lies inside a face of zero area.
        """
        if len(source) != 1:
            raise ArgumentError(f"a logarithmic map has one source, not {len(source)}")
        if not radius >= 0:
            raise ArgumentError(f"a radius is at least 0, not {radius}")
        if len(source.within_faces):
            inserted = insert_points(self.mesh, source)
            solver, v = ExactDistance(inserted.mesh), int(inserted.vertices[0])
            fan = vertex_fan(solver.surface, v)
            turn = _angle_from_first_edge(self.mesh, source, solver, fan)
        else:
            self._solver = self._solver or ExactDistance(self.mesh)
            solver, v, turn = self._solver, int(source.vertices[0]), 0.0
            fan = vertex_fan(solver.surface, v)
        fan.require_angles()
        arrivals = solver.arrivals(vertex_points(solver.mesh, [v]), limit=radius)
        n = self.mesh.n_vertices
        angles = turn + np.radians(fan.scale) * start_directions(solver, arrivals, fan)[:n]
        distance = arrivals.distance[:n]
        angles = np.pi - (np.pi - angles) % (2 * np.pi)
        angles[distance == 0] = 0.0
        angles[np.isinf(distance)] = np.nan
        length = np.where(np.isinf(distance), np.nan, distance)
        log = np.stack([length * np.cos(angles), length * np.sin(angles)], axis=1)
        reached = np.isfinite(distance)
        missing = n - len(self.mesh.unreferenced_vertices) - int(reached.sum())
        report = {
            "sources": source.report(),
            "total_angle": fan.total,
            "largest_radius": float(distance[reached].max()),
            "vertices": int(reached.sum()),
            "beyond": 0 if radius == inf else missing,
            "undefined_angles": int(np.isnan(angles[reached]).sum()),
            "unreachable_vertices": missing if radius == inf else 0,
        }
        fields = [Field("radius", "vertex", distance), Field("angle", "vertex", angles), Field("log", "vertex", log)]
        return Result(self.mesh, fields, report, source)


def _angle_from_first_edge(mesh: TriangleMesh, source: SurfacePoints, solver: ExactDistance, fan: VertexFan) -> float:
    """Return the angle of the first edge of the fan of an inserted point from the first edge of its face, radians."""
    face = source.faces[0]
    a, b, _ = mesh.vertices[mesh.faces[face]]
    along, normal = b - a, mesh.face_normals[face]
    edge = solver.mesh.vertices[fan.first_ends(solver.surface)[fan.begins.index(0.0)]] - source.positions(mesh)[0]
    return float(np.arctan2(np.cross(along, edge) @ normal, along @ edge))
