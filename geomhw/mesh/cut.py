"""Cutting a mesh open: at pinched vertices, where several fans of faces meet, and along edges."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Ints
from geomhw.mesh.topology import corner_fans
from geomhw.mesh.triangle_mesh import TriangleMesh


def cut_at_pinched_vertices(mesh: TriangleMesh) -> tuple[TriangleMesh, Ints]:
    """Give each fan of faces at a vertex its own copy of the vertex.

    Parameters
    ----------
    mesh : any mesh. Faces that share an edge at the vertex belong to one fan, also at edges of more than two faces.

    Returns
    -------
    cut : TriangleMesh
        The same faces in the same order, with n' vertices: the n given ones, of which a pinched one serves the fan of
        its first corner, then the copies. ``mesh`` itself if no vertex is pinched.
    original : (n',) integer array
        The vertex of ``mesh`` that each vertex is a copy of.

    Examples
    --------
    Two triangles that touch in vertex 0 come apart.

    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    >>> cut, original = cut_at_pinched_vertices(TriangleMesh(points, [[0, 1, 2], [0, 3, 4]]))
    >>> cut.faces.tolist(), original.tolist()
    ([[0, 1, 2], [5, 3, 4]], [0, 1, 2, 3, 4, 0])
    """
    return _separated(mesh, *corner_fans(mesh.faces, mesh.edge_table))


def cut_into_sheets(mesh: TriangleMesh) -> tuple[TriangleMesh, Ints]:
    """Cut a mesh open at pinched vertices and at edges of more than two faces; see `cut_at_pinched_vertices`.

    Duplicate faces stay together and count as one.

    Examples
    --------
    Three triangles at one edge come apart.

    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]
    >>> cut_into_sheets(TriangleMesh(points, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]))[0].n_vertices
    9
    """
    table = mesh.edge_table
    single = np.delete(table.of_faces, mesh.duplicate_faces[:, 0], axis=0)
    counts = np.bincount(single.ravel(), minlength=mesh.n_edges)
    return _separated(mesh, *corner_fans(mesh.faces, replace(table, face_counts=counts), most=2))


def means_of_copies(cut: TriangleMesh, original: Ints) -> sp.csr_array:
    """Assemble the means over the copies of each vertex, (n, n'), by their areas."""
    n = int(original.max(initial=-1)) + 1
    area = cut.vertex_areas
    total = np.bincount(original, area, minlength=n)[original]
    share = np.divide(area, total, out=np.ones_like(total), where=total > 0)
    return sp.csr_array((share, (original, np.arange(len(original)))), shape=(n, len(original)))


def cut_along_edges(mesh: TriangleMesh, edges: Ints) -> tuple[TriangleMesh, Ints]:
    """Separate the faces at edges from each other.

    Parameters
    ----------
    mesh : TriangleMesh
    edges : (k,) indices into ``mesh.edges``.

    Returns
    -------
    cut : TriangleMesh
        The same faces in the same order, with the vertices of ``mesh``, then copies of those at the edges.
    original : (n',) integer array
        The vertex of ``mesh`` that each vertex is a copy of.

    Examples
    --------
    >>> square = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> cut_along_edges(square, np.flatnonzero(square.edge_table.face_counts == 2))[0].faces.tolist()
    [[0, 1, 2], [4, 5, 3]]
    """
    table, counts = mesh.edge_table, np.ones(mesh.n_edges, dtype=np.int64)
    counts[edges] = 3
    open_there = replace(table, face_counts=np.where(counts == 3, 3, np.minimum(table.face_counts, 2)))
    fans, vertex_of = corner_fans(mesh.faces, open_there, most=2)
    ends = np.zeros(mesh.n_vertices, dtype=bool)
    ends[mesh.edges[edges]] = True
    # Elsewhere a vertex keeps its fans.
    numbers = np.arange(len(vertex_of))
    numbers[~ends[vertex_of]] = np.searchsorted(vertex_of, vertex_of[~ends[vertex_of]])
    names, compact = np.unique(numbers, return_inverse=True)
    return _separated(mesh, compact.ravel()[fans], vertex_of[names])


def _separated(mesh: TriangleMesh, fans: Ints, vertex_of: Ints) -> tuple[TriangleMesh, Ints]:
    """Return the mesh with a vertex for each fan of corners, (m, 3), of the given vertices, ascending."""
    n = mesh.n_vertices
    first = np.unique(vertex_of, return_index=True)[1]
    if len(first) == len(vertex_of):
        return mesh, np.arange(n)
    # Label the fan of the first corner of each vertex first.
    lowest = np.full(len(vertex_of), mesh.faces.size)
    np.minimum.at(lowest, fans.ravel(), np.arange(mesh.faces.size))
    order = np.lexsort((lowest, vertex_of))
    further = np.ones(len(order), dtype=bool)
    further[first] = False
    name = np.empty(len(order), dtype=mesh.faces.dtype)
    name[order] = np.where(further, n + np.cumsum(further) - 1, vertex_of)
    original = np.concatenate([np.arange(n), vertex_of[further]])
    return TriangleMesh(mesh.vertices[original], name[fans]), original
