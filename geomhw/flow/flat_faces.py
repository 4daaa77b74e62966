"""Faces of a mesh laid flat, each in a plane of its own."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_inline
from geomhw.mesh.topology import inner_pairs
from geomhw.mesh.triangle_mesh import TriangleMesh

#: ``totals`` of vertices at the boundary.
BOUNDARY = -1.0


class FlatFaces(NamedTuple):
    """Faces of a mesh laid flat. Edges of faces are numbered 3f + k, opposite corner k, from corner k + 1 to k + 2.

    corners: (m, 3), vertices. across: (3m,), the number of each edge in the other face, -1 at the boundary. places:
    (m, 3, 2), corners in the plane. feet, rises: (3m,), the place of corner k over edge 3f + k, as shares of its length
    along it and away from it. angles: (3m,), of the corners. totals: (n,), the angle at each vertex, or `BOUNDARY`.
    """

    corners: Ints
    across: Ints
    places: Floats
    feet: Floats
    rises: Floats
    angles: Floats
    totals: Floats


def flat_faces(mesh: TriangleMesh) -> FlatFaces:
    """Lay the faces of an edge-manifold mesh flat."""
    one, other, _ = inner_pairs(mesh.edge_table)
    across = np.full(3 * mesh.n_faces, -1)
    across[one], across[other] = other, one
    corner = mesh.vertices[mesh.faces]
    edge = np.roll(corner, -2, axis=1) - np.roll(corner, -1, axis=1)
    side = corner - np.roll(corner, -1, axis=1)
    squares = np.einsum("fkx,fkx->fk", edge, edge)
    feet = np.einsum("fkx,fkx->fk", side, edge) / squares
    rises = 2 * mesh.face_areas[:, None] / squares
    places, base = np.zeros((mesh.n_faces, 3, 2)), np.sqrt(squares[:, 0])
    places[:, 2, 0], places[:, 0, 0], places[:, 0, 1] = base, feet[:, 0] * base, rises[:, 0] * base
    totals: Floats = np.bincount(mesh.faces.ravel(), mesh.angles.ravel(), mesh.n_vertices).astype(float)
    totals[mesh.boundary_vertices] = BOUNDARY
    return FlatFaces(
        np.array(mesh.faces, dtype=np.int64, order="C"),
        across,
        places,
        feet.ravel(),
        rises.ravel(),
        np.array(mesh.angles.ravel()),
        totals,
    )


@compiled_inline
def corner_distance(flat: FlatFaces, face: int, i: int, j: int) -> float:
    """Return the distance of two corners of a face."""
    dx = flat.places[face, i, 0] - flat.places[face, j, 0]
    return sqrt(dx**2 + (flat.places[face, i, 1] - flat.places[face, j, 1]) ** 2)
