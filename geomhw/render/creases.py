"""Points and normals for smooth shading that stays sharp along creases. Plain numpy."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.geometry import unit
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

    first, second = _smooth_links(mesh, np.cos(np.radians(crease)))
    size = 3 * mesh.n_faces
    links = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(size, size))
    count, point = connected_components(links, directed=False)
    origin = np.empty(count, dtype=np.int64)
    origin[point] = mesh.faces.ravel()
    weighted = np.repeat(mesh.face_normals * mesh.face_areas[:, None], 3, axis=0)
    normals = np.stack([np.bincount(point, weights=column, minlength=count) for column in weighted.T], axis=1)
    return Shell(origin, point.reshape(-1, 3), unit(normals.astype(np.float64)))


def _smooth_links(mesh: TriangleMesh, cosine: float) -> tuple[Ints, Ints]:
    """Pairs of corners (3f + k) at the same vertex, on either side of an inner edge that is no crease."""
    table = mesh.edge_table
    order = _in_groups(table.of_faces.ravel())
    starts = np.cumsum(table.face_counts) - table.face_counts
    a, b = (order[starts[table.face_counts == 2] + k] for k in (0, 1))  # halfedges, named by the corner they face
    normals = mesh.face_normals
    smooth = np.einsum("ex,ex->e", normals[a // 3], normals[b // 3]) > cosine
    a, b = a[smooth], b[smooth]
    a_start, a_end, b_start, b_end = _next(a, 1), _next(a, 2), _next(b, 1), _next(b, 2)
    corners: NDArray[np.int32] = mesh.faces.ravel()
    opposed = corners[a_start] == corners[b_end]  # as in oriented meshes; else both run the same way
    partners = np.where(opposed, b_end, b_start), np.where(opposed, b_start, b_end)
    return np.concatenate([a_start, a_end]), np.concatenate(partners)


def _in_groups(labels: Ints) -> Ints:
    """Where the 0s are, where the 1s are, ...: a stable sort, by counting."""
    from scipy.sparse import coo_array

    places = np.arange(len(labels))
    return np.asarray(coo_array((places, (labels, places))).tocsr().indices)


def _next(corner: Ints, steps: int) -> Ints:
    """The corner so many steps further round its face."""
    return np.asarray(corner // 3 * 3 + (corner + steps) % 3)
