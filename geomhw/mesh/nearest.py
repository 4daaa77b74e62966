"""The point of a surface nearest to a point in space."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh


def nearest_on_surface(mesh: TriangleMesh, point: Floats) -> tuple[int, Floats]:
    """Face and barycentric weights, (3,), of the nearest point of the mesh; of equally near faces the first.

    In each face that is the foot of the perpendicular, where it lies inside, or else the nearest point of an edge.
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
    """Of each edge, from corner k to k+1: how far along it is nearest to the origin, 0..1, and that distance squared,
    (m, 3) each."""
    along = np.roll(corners, -1, axis=1) - corners
    length = np.einsum("fkx,fkx->fk", along, along)
    ahead = -np.einsum("fkx,fkx->fk", corners, along)
    share = np.clip(np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 0), 0, 1)
    nearest = corners + share[..., None] * along
    return share, np.einsum("fkx,fkx->fk", nearest, nearest)


def _on_planes(corners: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Doubled areas opposite each corner of the origin's foot, (m, 3), and its distance squared, (m,): inf where it
    lies outside of the face or the face has no area."""
    opposite = np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))
    areas = np.einsum("fkx,fx->fk", opposite, normals)
    inside = (areas >= 0).all(axis=1) & (areas.sum(axis=1) > 0)
    return areas, np.where(inside, np.einsum("fx,fx->f", corners[:, 0], normals) ** 2, np.inf)
