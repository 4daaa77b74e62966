"""Vertex normals for smooth shading with sharp creases."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import corner_sum, lengths, rows, unit, vector_sum
from geomhw.mesh.topology import inner_pairs
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Dihedral angle, in degrees, above which an edge is a crease.
CREASE = 55.0


@dataclass(frozen=True)
class Shell:
    """A mesh with duplicated vertices along creases.

    origin: (p,), the vertex that each point copies. faces: (m, 3) point indices, in the order of the mesh. normals:
    (p, 3), unit. Unreferenced vertices have no point.
    """

    origin: Ints
    faces: Ints
    normals: Floats


def shell(mesh: TriangleMesh, crease: float = CREASE) -> Shell:
    """Split vertices along creases: corners at a vertex share a point if a path without a crease joins their faces."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    cosine = np.cos(np.radians(crease))
    first, second, smooth = _smooth_links(mesh, cosine)
    folded, flat = _folded(mesh, smooth, cosine), mesh.faces.ravel()
    plain = np.flatnonzero(np.bincount(flat[~folded[flat]], minlength=mesh.n_vertices))
    place = np.empty(mesh.n_vertices, dtype=np.int64)
    place[plain] = np.arange(len(plain))
    point = place[flat]
    # Corners at vertices on creases, and the links between them.
    corners = np.flatnonzero(folded[flat])
    number = np.empty(flat.size, dtype=np.int64)
    number[corners] = np.arange(len(corners))
    links = np.flatnonzero(folded[flat[first]])
    ends = number[first[links]], number[second[links]]
    graph = coo_array((np.ones(len(links), dtype=np.int8), ends), shape=(len(corners), len(corners)))
    count, label = connected_components(graph, directed=False)
    point[corners] = len(plain) + label
    origin = np.empty(len(plain) + count, dtype=np.int64)
    origin[point] = flat
    faces = point.reshape(-1, 3)
    return Shell(origin, faces, unit(vector_sum(mesh.area_vectors, faces, len(origin))))


def _smooth_links(mesh: TriangleMesh, cosine: float) -> tuple[Ints, Ints, Ints]:
    """Return pairs of corners 3f+k at the same vertex across inner edges without a crease, and a halfedge per edge."""
    one, other, against = inner_pairs(mesh.edge_table)
    normals = [rows(mesh.face_normals, side // 3) for side in (one, other)]
    smooth = np.einsum("ex,ex->e", *normals) > cosine
    one, other, against = one[smooth], other[smooth], against[smooth]
    # The two halfedges run in opposite directions if the faces are consistently oriented, else in the same.
    partners = [np.where(against, _next(other, step), _next(other, 3 - step)) for step in (1, 2)]
    return np.concatenate([_next(one, 1), _next(one, 2)]), np.concatenate(partners), one


def _folded(mesh: TriangleMesh, smooth: Ints, cosine: float) -> NDArray[np.bool_]:
    """Return the mask, (n,), of vertices that may need several points: on a crease, or with canceling normals."""
    folds = np.ones(mesh.n_edges, dtype=bool)
    folds[mesh.edge_table.of_faces.ravel()[smooth]] = False
    folded = np.zeros(mesh.n_vertices, dtype=bool)
    folded[mesh.edges[folds].ravel()] = True
    sums = vector_sum(mesh.area_vectors, mesh.faces, mesh.n_vertices)
    whole = corner_sum(2 * mesh.face_areas, mesh.faces, mesh.n_vertices)
    return np.asarray(folded | (lengths(sums) < cosine * whole))


def _next(corner: Ints, steps: int) -> Ints:
    """Return the corner that many steps further around its face."""
    return np.asarray(corner // 3 * 3 + (corner + steps) % 3)
