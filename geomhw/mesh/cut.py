"""Cutting a mesh open at pinched vertices, where several fans of faces meet."""

import numpy as np

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
    fans, vertex_of = corner_fans(mesh.faces, mesh.edge_table)
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
