"""The array types that everything agrees on, and the one way to make an array read-only."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[Any]


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """The same array, made read-only."""
    array.flags.writeable = False
    return array


def dot(a: Floats, b: Floats) -> float:
    """Σ a_i b_i. Not by BLAS, whose threads cost more than they save here and round as their number has it."""
    return float(np.einsum("i,i->", a, b))
