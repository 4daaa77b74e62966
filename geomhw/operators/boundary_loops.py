"""Functions that are constant on each boundary loop: stream functions of flows tangent to the boundary."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


def loop_representatives(mesh: TriangleMesh) -> Ints:
    """Return a representative vertex of each vertex: one per boundary loop, the vertex itself inside.

    Loops that share a vertex have one representative.

    Returns
    -------
    (n,) integer array: u is constant on each loop if ``u == u[loop_representatives(mesh)]``.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> loop_representatives(grid(2, 2)).tolist()
    [0, 0, 0, 0, 4, 0, 0, 0, 0]
    """
    from scipy.sparse.csgraph import connected_components

    boundary = mesh.edges[mesh.edge_table.face_counts == 1]
    n = mesh.n_vertices
    links = sp.coo_array((np.ones(len(boundary)), (boundary[:, 0], boundary[:, 1])), shape=(n, n))
    labels = connected_components(links, directed=False)[1]
    first = np.unique(labels, return_index=True)[1]
    return np.asarray(first[labels])


def loop_constant_basis(mesh: TriangleMesh) -> tuple[sp.csr_array, Ints]:
    """Assemble a basis of the functions that are constant on each boundary loop.

    Returns
    -------
    E : (n, k) sparse array of zeros and ones
        One column per inner vertex and per boundary loop; ``E @ x`` are values at vertices.
    representatives : (k,) integer array
        The vertex of each column, as in `loop_representatives`.
    """
    representatives, column = np.unique(loop_representatives(mesh), return_inverse=True)
    n = mesh.n_vertices
    return sp.csr_array((np.ones(n), (np.arange(n), column)), shape=(n, len(representatives))), representatives
