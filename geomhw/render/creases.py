"""Points and normals for smooth shading that stays sharp along creases. Plain numpy."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.geometry import corner_sum, lengths, rows, unit
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
    one, other, alike = _smooth_pairs(mesh, cosine)
    flat = mesh.faces.ravel()
    folded = _folded(mesh, one, cosine)
    plain = np.flatnonzero(np.bincount(flat[~folded[flat]], minlength=mesh.n_vertices))
    places = np.empty(mesh.n_vertices, dtype=np.int64)
    places[plain] = np.arange(len(plain))
    point = places[flat]
    # Elsewhere, corners (3f + k) at the same vertex, on either side of a smooth edge, are linked.
    corners = np.flatnonzero(folded[flat])
    number = np.empty(flat.size, dtype=np.int64)
    number[corners] = np.arange(len(corners))
    ends = [_next(one, 1), _next(one, 2)]
    partners = [np.where(alike, _next(other, 3 - step), _next(other, step)) for step in (1, 2)]
    links = [number[np.concatenate(side)[folded[flat[np.concatenate(ends)]]]] for side in (ends, partners)]
    graph = coo_array((np.ones(len(links[0]), dtype=np.int8), tuple(links)), shape=2 * (len(corners),))
    count, label = connected_components(graph, directed=False)
    point[corners] = len(plain) + label
    size = len(plain) + count
    origin = np.empty(size, dtype=np.int64)
    origin[point] = flat
    sums = [corner_sum(column, point.reshape(-1, 3), size) for column in mesh.area_vectors.T]
    return Shell(origin, point.reshape(-1, 3), unit(np.stack(sums).T))


def _smooth_pairs(mesh: TriangleMesh, cosine: float) -> tuple[Ints, Ints, NDArray[np.bool_]]:
    """Both sides (3f + k) of each inner edge that is no crease, and whether these run along it in opposite directions,
    as in oriented meshes."""
    one, other, against = inner_pairs(mesh.edge_table)
    normals = [rows(mesh.face_normals, side // 3) for side in (one, other)]
    smooth = np.einsum("ex,ex->e", *normals) > cosine
    return one[smooth], other[smooth], ~against[smooth]


def _folded(mesh: TriangleMesh, smooth: Ints, cosine: float) -> NDArray[np.bool_]:
    """Vertices, (n,), at the end of an edge that is not one of those sides, or where normals cancel: there, corners may
    be several points."""
    folds = np.ones(mesh.n_edges, dtype=bool)
    folds[mesh.edge_table.of_faces.ravel()[smooth]] = False
    folded = np.zeros(mesh.n_vertices, dtype=bool)
    folded[mesh.edges[folds].ravel()] = True
    sums = np.stack([corner_sum(column, mesh.faces, mesh.n_vertices) for column in mesh.area_vectors.T]).T
    whole = corner_sum(2 * mesh.face_areas, mesh.faces, mesh.n_vertices)
    return np.asarray(folded | (lengths(sums) < cosine * whole))


def _next(corner: Ints, steps: int) -> Ints:
    """The corner so many steps further round its face."""
    return np.asarray(corner // 3 * 3 + (corner + steps) % 3)
