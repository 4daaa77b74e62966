"""Triangular solves with many right-hand sides, in place, as compiled loops.

Factors are in compressed columns with ascending row indices, as SuperLU stores them. Right-hand sides are the columns
of a C-contiguous array, so that each entry of a factor is read once for all of them.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.compiled import compiled


@compiled
def solve_lower(indptr: Ints, indices: Ints, data: NDArray[Any], x: NDArray[Any]) -> None:
    """Solve L x = b for L with a unit diagonal, stored first in each column; x, (n, k), is b on entry."""
    n, k = x.shape
    for j in range(n):
        for p in range(indptr[j] + 1, indptr[j + 1]):
            i, entry = np.uintp(indices[p]), data[p]
            for c in range(k):
                x[i, c] -= entry * x[j, c]


@compiled
def solve_upper(indptr: Ints, indices: Ints, data: NDArray[Any], x: NDArray[Any]) -> None:
    """Solve U x = b for U with its diagonal last in each column; x, (n, k), is b on entry."""
    n, k = x.shape
    for j in range(n - 1, -1, -1):
        last = indptr[j + 1] - 1
        for c in range(k):
            x[j, c] /= data[last]
        for p in range(indptr[j], last):
            i, entry = np.uintp(indices[p]), data[p]
            for c in range(k):
                x[i, c] -= entry * x[j, c]
