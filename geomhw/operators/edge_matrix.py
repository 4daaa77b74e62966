"""Matrices with an entry for each edge."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, scatter_add


def edge_matrix(edges: Ints, values: NDArray[Any], diagonal: Floats) -> sp.csr_array:
    """Hermitian matrix, (n, n), with the values, (e,), at edges (i, j), conjugates at (j, i), and a diagonal, (n,).

    Where two edges join the same vertices, or one a vertex to itself, entries are sums.
    """
    n = len(diagonal)
    every = np.arange(n, dtype=edges.dtype)
    places = np.concatenate([every, edges[:, 0]]), np.concatenate([every, edges[:, 1]])
    upper = sp.coo_array((np.concatenate([diagonal / 2, values]), places), shape=(n, n)).tocsr()
    return upper + upper.conj(copy=False).T.tocsr()


def weight_sums(edges: Ints, weights: Floats, size: int) -> Floats:
    """Sum of the weights of edges, (e,), at both of their ends, (size,)."""
    i, j = edges.T
    return scatter_add(weights, i, size) + scatter_add(weights, j, size)
