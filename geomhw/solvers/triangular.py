"""Triangular solves with many right-hand sides, in place, as compiled loops.

L is in compressed columns, U in compressed rows, with ascending indices, so the diagonal is the first entry of each.
Right-hand sides are the columns of a C-contiguous array: each entry of a factor is read once for all of them. Columns
of L with the same nonzero rows below (supernodes) are treated four at once, so that x is read once for four, and rows
of U likewise.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.compiled import compiled

#: Columns of a supernode treated at once.
WIDTH = 4


@compiled
def solve_lower(indptr: Ints, indices: Ints, data: NDArray[Any], x: NDArray[Any]) -> None:
    """Solve L x = b for L with a unit diagonal, in columns; x, (n, k), is b on entry."""
    n, k = x.shape
    j = 0
    while j < n:
        if _supernode(indptr, indices, j):
            for t in range(WIDTH - 1):
                for p in range(1, WIDTH - t):
                    entry = data[indptr[j + t] + p]
                    for c in range(k):
                        x[j + t + p, c] -= entry * x[j + t, c]
            p0, p1, p2, p3 = indptr[j] + 4, indptr[j + 1] + 3, indptr[j + 2] + 2, indptr[j + 3] + 1
            for p in range(indptr[j + 4] - p3):
                i = np.uintp(indices[p0 + p])
                a0, a1, a2, a3 = data[p0 + p], data[p1 + p], data[p2 + p], data[p3 + p]
                for c in range(k):
                    x[i, c] -= a0 * x[j, c] + a1 * x[j + 1, c] + a2 * x[j + 2, c] + a3 * x[j + 3, c]
            j += WIDTH
        else:
            for p in range(indptr[j] + 1, indptr[j + 1]):
                i, entry = np.uintp(indices[p]), data[p]
                for c in range(k):
                    x[i, c] -= entry * x[j, c]
            j += 1


@compiled
def solve_upper(indptr: Ints, indices: Ints, data: NDArray[Any], x: NDArray[Any]) -> None:
    """Solve U x = b for U in rows; x, (n, k), is b on entry."""
    n, k = x.shape
    j = n
    while j > 0:
        if j >= WIDTH and _supernode(indptr, indices, j - WIDTH):
            j -= WIDTH
            p0, p1, p2, p3 = indptr[j] + 4, indptr[j + 1] + 3, indptr[j + 2] + 2, indptr[j + 3] + 1
            for p in range(indptr[j + 4] - p3):
                i = np.uintp(indices[p0 + p])
                a0, a1, a2, a3 = data[p0 + p], data[p1 + p], data[p2 + p], data[p3 + p]
                for c in range(k):
                    x[j, c] -= a0 * x[i, c]
                    x[j + 1, c] -= a1 * x[i, c]
                    x[j + 2, c] -= a2 * x[i, c]
                    x[j + 3, c] -= a3 * x[i, c]
            for t in range(WIDTH - 1, -1, -1):
                first = indptr[j + t]
                for p in range(1, WIDTH - t):
                    entry = data[first + p]
                    for c in range(k):
                        x[j + t, c] -= entry * x[j + t + p, c]
                for c in range(k):
                    x[j + t, c] /= data[first]
        else:
            j -= 1
            for p in range(indptr[j] + 1, indptr[j + 1]):
                i, entry = np.uintp(indices[p]), data[p]
                for c in range(k):
                    x[j, c] -= entry * x[i, c]
            for c in range(k):
                x[j, c] /= data[indptr[j]]


@compiled
def _supernode(indptr: Ints, indices: Ints, j: int) -> bool:
    """Whether the columns j to j + 3 have the same nonzero rows from j + 3 on, and each those between."""
    if j + WIDTH >= len(indptr):
        return False
    count = indptr[j + WIDTH] - indptr[j + WIDTH - 1]
    for t in range(WIDTH - 1):
        first, extra = indptr[j + t], WIDTH - 1 - t
        if indptr[j + t + 1] - first != count + extra:
            return False
        for p in range(1, extra + 1):
            if indices[first + p] != j + t + p:
                return False
    for p in range(1, count):
        i = indices[indptr[j + WIDTH - 1] + p]
        for t in range(WIDTH - 1):
            if indices[indptr[j + t] + WIDTH - 1 - t + p] != i:
                return False
    return True
