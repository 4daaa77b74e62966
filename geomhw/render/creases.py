"""Points and normals for smooth shading that stays sharp along creases. Plain numpy."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import corner_sum, lengths, rows, unit, vector_sum
from geomhw.mesh.topology import inner_pairs
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Faces that meet at a larger angle are shaded as an edge, degrees.
CREASE = 55.0


@dataclass(frozen=True)
class Shell:
    """A mesh with its vertices doubled along creases.

    origin: the vertex that each point is a copy of, (p,); faces: (m, 3), of points, in the mesh's order.
    normals: (p, 3), unit. Vertices without a face have no point.
    """

    origin: Ints
    faces: Ints
    normals: Floats


def shell(mesh: TriangleMesh, crease: float = CREASE) -> Shell:
    """Corners at a vertex become one point where one can walk between their faces without crossing a crease."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    cosine = np.cos(np.radians(crease))
    first, second, smooth = _smooth_links(mesh, cosine)
    folded, flat = _folded(mesh, smooth, cosine), mesh.faces.ravel()
    plain = np.flatnonzero(np.bincount(flat[~folded[flat]], minlength=mesh.n_vertices))
    place = np.empty(mesh.n_vertices, dtype=np.int64)
    place[plain] = np.arange(len(plain))
    point = place[flat]
    # Corners at the other vertices, and the links between these.
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
    """Pairs of corners (3f + k) at the same vertex, on either side of an inner edge that is no crease, and one side of
    each of these edges."""
    one, other, against = inner_pairs(mesh.edge_table)
    normals = [rows(mesh.face_normals, side // 3) for side in (one, other)]
    smooth = np.einsum("ex,ex->e", *normals) > cosine
    one, other, against = one[smooth], other[smooth], against[smooth]
    # Both sides run along the edge in opposite directions, as in oriented meshes; else both run the same way.
    partners = [np.where(against, _next(other, step), _next(other, 3 - step)) for step in (1, 2)]
    return np.concatenate([_next(one, 1), _next(one, 2)]), np.concatenate(partners), one


def _folded(mesh: TriangleMesh, smooth: Ints, cosine: float) -> NDArray[np.bool_]:
    """Vertices, (n,), at the end of an edge that is not one of those sides, or where normals cancel: there, corners may
    be several points."""
    folds = np.ones(mesh.n_edges, dtype=bool)
    folds[mesh.edge_table.of_faces.ravel()[smooth]] = False
    folded = np.zeros(mesh.n_vertices, dtype=bool)
    folded[mesh.edges[folds].ravel()] = True
    sums = vector_sum(mesh.area_vectors, mesh.faces, mesh.n_vertices)
    whole = corner_sum(2 * mesh.face_areas, mesh.faces, mesh.n_vertices)
    return np.asarray(folded | (lengths(sums) < cosine * whole))


def _next(corner: Ints, steps: int) -> Ints:
    """The corner so many steps further round its face."""
    return np.asarray(corner // 3 * 3 + (corner + steps) % 3)
