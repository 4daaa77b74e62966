"""Closest point of a triangle mesh to a point in space."""

import math

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.mesh.surface_points import SurfacePoints, bounding_box, face_point
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Distance, in diagonals of the bounding box, from which no point of the surface is the nearest up to rounding.
FARTHEST = 1e6


def nearest_point(mesh: TriangleMesh, point: ArrayLike) -> SurfacePoints:
    """Find the point of the surface closest to a point in space, (3,); of equally close faces, the lowest.

    Raises
    ------
    ArgumentError
        If ``point`` does not have three finite coordinates, or is a million diagonals of the bounding box away.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> nearest_point(grid(1, 1), [0.75, 0.25, 9.0]).positions(grid(1, 1))
    array([[0.75, 0.25, 0.  ]])
    """
    place = np.asarray(point, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ArgumentError(f"a point in space has three finite coordinates, not {place.tolist()}")
    low, high = bounding_box(mesh)
    distance, diagonal = math.dist(place.tolist(), ((low + high) / 2).tolist()), math.dist(low.tolist(), high.tolist())
    if distance > FARTHEST * diagonal > 0:
        raise ArgumentError(
            f"the point {', '.join(f'{x:g}' for x in place)} is {distance:.3g} away from the mesh, whose bounding box "
            f"has a diagonal of {diagonal:.3g}; give a point near the surface"
        )
    return face_point(mesh, *nearest_on_surface(mesh, place))


def nearest_on_surface(mesh: TriangleMesh, point: Floats) -> tuple[int, Floats]:
    """Return the face and the barycentric coordinates, (3,), of the closest point; the lowest face on a tie.

    The closest point of a face is the foot of the perpendicular if that lies inside, else the closest point of an edge.
    """
    corners = mesh.vertices[mesh.faces] - np.asarray(point, dtype=float)
    share, to_edge = _on_edges(corners)
    weights, to_plane = _on_planes(corners, mesh.face_normals)
    best = np.minimum(to_edge.min(axis=1), to_plane)
    face = int(best.argmin())
    if to_plane[face] <= best[face]:
        return face, weights[face] / weights[face].sum()
    edge = int(to_edge[face].argmin())
    on_edge = np.zeros(3)
    on_edge[[edge, (edge + 1) % 3]] = 1 - share[face, edge], share[face, edge]
    return face, on_edge


def _on_edges(corners: Floats) -> tuple[Floats, Floats]:
    """Return, for each edge from corner k to k+1, (m, 3), the parameter in [0, 1] of its point closest to the origin,
    and the squared distance."""
    along = np.roll(corners, -1, axis=1) - corners
    length = np.einsum("fkx,fkx->fk", along, along)
    ahead = -np.einsum("fkx,fkx->fk", corners, along)
    share = np.clip(np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 0), 0, 1)
    nearest = corners + share[..., None] * along
    return share, np.einsum("fkx,fkx->fk", nearest, nearest)


def _on_planes(corners: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Return twice the barycentric areas, (m, 3), of the origin's projection to each plane, and its squared distance,
    (m,): inf if the projection lies outside the face or the face has zero area."""
    opposite = np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))
    areas = np.einsum("fkx,fx->fk", opposite, normals)
    inside = (areas >= 0).all(axis=1) & (areas.sum(axis=1) > 0)
    return areas, np.where(inside, np.einsum("fx,fx->f", corners[:, 0], normals) ** 2, np.inf)
