"""Array types, and array functions that numpy lacks: read-only arrays, scatter-add, ranges, pieces."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[Any]
Complexes = NDArray[np.complex128]
#: Number of faces, edges or rows in a piece.
PIECE = 1 << 14
#: Raises the threshold of glibc's malloc: until a large block has been freed, glibc returns freed arrays to the kernel,
#: and every new one costs page faults. Afterwards it keeps up to twice the size of that block. This block is never
#: touched, so it costs nothing; a larger one costs memory and saves no time.
np.empty((16 << 20) - (64 << 10), dtype=np.uint8)


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only and return it."""
    array.flags.writeable = False
    return array


def scatter_add(values: NDArray[Any], places: Ints, size: int) -> NDArray[Any]:
    """Sum the values, (k,), at each of their places, (k,), in order; return (size,).

    The same as ``bincount`` with weights, for complex values too, and faster: it does not convert the places.
    """
    from scipy.sparse import csc_array

    # A sparse column with repeated row indices, times 1.
    return csc_array((values, places, np.array([0, len(values)])), shape=(size, 1)) @ np.ones(1)


def ranges(begins: Ints, counts: Ints, step: int = 1) -> Ints:
    """Concatenate the ranges ``begins[i], begins[i] + step, ...`` of ``counts[i]`` numbers each.

    >>> ranges(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    counts = np.asarray(counts, dtype=np.int64)
    ends = np.cumsum(counts)
    found = np.repeat(begins - step * (ends - counts), counts)
    found += np.arange(0, step * len(found), step)
    return found


def pieces(count: int) -> Iterator[slice]:
    """Yield slices that divide ``count`` rows into pieces whose intermediate arrays fit into the cache."""
    for start in range(0, count, PIECE):
        yield slice(start, min(start + PIECE, count))


def dot(a: Floats, b: Floats) -> float:
    """Compute Σ a_i b_i without BLAS, whose result depends on the number of its threads."""
    return float(np.einsum("i,i->", a, b))
