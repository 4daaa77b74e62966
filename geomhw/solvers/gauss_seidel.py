"""Gauss-Seidel sweeps, compiled."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.compiled import compiled


def diagonal_first(A: sp.csr_array) -> None:
    """Order the entries of each row in place, the diagonal before all others, as `sweep` needs them."""
    rows = np.repeat(np.arange(A.shape[0], dtype=A.indices.dtype), np.diff(A.indptr))
    on = A.indices == rows
    A.indices[on] = -1
    A.has_sorted_indices = False
    A.sort_indices()
    A.indices[A.indptr[rows[on]]] = rows[on]
    A.has_sorted_indices = False


def sweep(A: sp.csr_array, x: NDArray[Any], b: NDArray[Any], first: int, last: int, step: int = 1) -> None:
    """Solve the equations of A x = b for their own unknown, one after the other, in place.

    first, last, step: the rows, as in ``range``. Each row of A has its diagonal first, and it is not zero.
    """
    _sweep(A.indptr, A.indices, A.data, x, b, first, last, step)


@compiled
def _sweep(
    indptr: Ints, indices: Ints, data: NDArray[Any], x: NDArray[Any], b: NDArray[Any], first: int, last: int, step: int
) -> None:
    for i in range(first, last, step):
        # Unsigned indices: numba need not look whether they count from the end, and sweeps take half of the time.
        start, end, total = np.uintp(indptr[i]), np.uintp(indptr[i + 1]), b[i]
        for p in range(start + np.uintp(1), end):
            total -= data[p] * x[np.uintp(indices[p])]
        x[i] = total / data[start]
