"""Assembly of symmetric and Hermitian matrices with one entry per edge."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, scatter_add


def edge_matrix(edges: Ints, values: NDArray[Any], diagonal: Floats) -> sp.csr_array:
    """Assemble a Hermitian matrix, (n, n), from values at edges and a diagonal.

    Parameters
    ----------
    edges : (e, 2) integer array of rows and columns (i, j). Values of edges between the same vertices add up.
    values : (e,) array; its conjugates are the entries (j, i).
    diagonal : (n,) array.
    """
    n = len(diagonal)
    vertices = np.arange(n, dtype=edges.dtype)
    places = np.concatenate([vertices, edges[:, 0]]), np.concatenate([vertices, edges[:, 1]])
    half = sp.coo_array((np.concatenate([diagonal / 2, values]), places), shape=(n, n)).tocsr()
    return half + half.conj(copy=False).T.tocsr()


def weight_sums(edges: Ints, weights: Floats, size: int) -> Floats:
    """Return the sum of the weights, (e,), of the edges at each vertex, (size,)."""
    i, j = edges.T
    return scatter_add(weights, i, size) + scatter_add(weights, j, size)
