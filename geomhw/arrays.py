"""The array types that everything agrees on, and what numpy lacks: arrays read-only, in pieces, summed in order."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[Any]
Complexes = NDArray[np.complex128]
#: Faces, edges or rows in a piece.
PIECE = 1 << 14
#: glibc gives what is freed back to the kernel, page by page, until an array of some size has been freed: from then on
#: it keeps up to twice that, and hands it out again. This one costs nothing, as it is never touched; a larger one would
#: cost memory and gain no time.
np.empty((16 << 20) - (64 << 10), dtype=np.uint8)


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """The same array, made read-only."""
    array.flags.writeable = False
    return array


def scatter_add(values: NDArray[Any], places: Ints, size: int) -> NDArray[Any]:
    """Sum of the values, (k,), at each place 0 to size - 1, (size,), in their order; places: (k,).

    As ``bincount`` with weights, but faster: places are taken as they are.
    """
    from scipy.sparse import csc_array

    # Entries of one column, some of them in the same row.
    return csc_array((values, places, np.array([0, len(values)])), shape=(size, 1)) @ np.ones(1)


def pieces(count: int) -> Iterator[slice]:
    """Parts of so many faces, edges or rows, best worked on one by one: what arises on the way fits into a cache."""
    for start in range(0, count, PIECE):
        yield slice(start, min(start + PIECE, count))


def dot(a: Floats, b: Floats) -> float:
    """Σ a_i b_i. Not by BLAS, whose threads cost more than they save here and round as their number has it."""
    return float(np.einsum("i,i->", a, b))
