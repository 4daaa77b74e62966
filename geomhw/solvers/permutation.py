"""Matrices of unknowns in another order."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Ints


def permuted(matrix: sp.csr_array, order: Ints) -> sp.csr_array:
    """A[order][:, order], (n, n), in half of the time; entries of a row stay in the order that they had."""
    rows = matrix[order]
    place = np.empty(len(order), dtype=rows.indices.dtype)
    place[order] = np.arange(len(order))
    return sp.csr_array((rows.data, place[rows.indices], rows.indptr), shape=rows.shape)
