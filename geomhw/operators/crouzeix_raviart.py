"""Functions on edge midpoints (Crouzeix-Raviart): the stream functions of face fields.

With one value a vertex for the potential and one an edge for the stream function, gradients and turned gradients are
orthogonal and fill the face fields up to 2g harmonic ones [Polthier, Preuss 2003; Wardetzky, PhD thesis, 2006].
"""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import hat_gradients


def edge_gradient(mesh: TriangleMesh) -> sp.csr_array:
    """Gradient of functions linear on faces and continuous at edge midpoints, (3m, e), units 1/length, per face."""
    m = mesh.n_faces
    values = -2 * hat_gradients(mesh).transpose(0, 2, 1)  # the function of the edge opposite corner k is 1 - 2 φ_k
    columns = np.broadcast_to(mesh.edge_table.of_faces[:, None, :], (m, 3, 3))
    starts = np.arange(0, 9 * m + 1, 3)
    return sp.csr_array((values.ravel(), columns.ravel(), starts), shape=(3 * m, mesh.n_edges))


def edge_components(mesh: TriangleMesh) -> Ints:
    """Labels of edges, (e,), the same where one can be reached from the other over faces; vertices join nothing."""
    from scipy.sparse.csgraph import connected_components

    table = mesh.edge_table.of_faces
    pairs = np.concatenate([table[:, :2], table[:, 1:]])
    links = sp.coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(mesh.n_edges,) * 2)
    return np.asarray(connected_components(links, directed=False)[1])


def loop_edges(mesh: TriangleMesh) -> list[Ints]:
    """Edges of each boundary loop, as indices into ``mesh.edges``."""
    keys = mesh.edges[:, 0].astype(np.int64) * mesh.n_vertices + mesh.edges[:, 1]
    found = []
    for loop in mesh.boundary_loops:
        ends = np.roll(loop, -1)
        wanted = np.minimum(loop, ends).astype(np.int64) * mesh.n_vertices + np.maximum(loop, ends)
        found.append(np.searchsorted(keys, wanted))
    return found


def edges_to_vertices(mesh: TriangleMesh, values: Floats) -> Floats:
    """Mean over the edges round each vertex, (n,); zero on a vertex without edges."""
    ends = mesh.edges.ravel()
    counts = np.bincount(ends, minlength=mesh.n_vertices)
    sums = np.bincount(ends, weights=np.repeat(values, 2), minlength=mesh.n_vertices)
    return np.asarray(sums / np.maximum(counts, 1))
