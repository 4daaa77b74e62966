"""Hilbert curve keys: points with close keys are close in space. No dependency of geomhw computes them."""

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats

#: Bits per coordinate; a key of three coordinates fits into 64 bits.
BITS = 20


def hilbert_keys(
    points: Floats, bits: int = BITS, *, low: Floats | None = None, size: float = 0.0
) -> NDArray[np.uint64]:
    """Return the index of each point, (k, 3), along the Hilbert curve through the 8^bits cells of a cube.

    low, size: lowest corner and edge length of the cube; by default those of the points.

    [Skilling 2004, "Programming the Hilbert curve"]
    """
    if low is None:
        low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    share = (points - low) / (size or 1.0)
    cells = np.minimum(np.floor(share * 2.0**bits), 2.0**bits - 1).astype(np.uint64)
    return _along_curve([cells[:, k] for k in range(3)], bits)


def _along_curve(x: list[NDArray[np.uint64]], bits: int) -> NDArray[np.uint64]:
    """Return the indices of cells given by their three integer coordinates; loops run over bits."""
    highest, one = np.uint64(1) << np.uint64(bits - 1), np.uint64(1)
    digits = [highest >> np.uint64(k) for k in range(bits)]
    for digit in digits[:-1]:
        below = digit - one
        for k in range(3):
            swapped = np.where(x[k] & digit, np.uint64(0), (x[0] ^ x[k]) & below)
            x[0] = x[0] ^ np.where(x[k] & digit, below, swapped)
            x[k] = x[k] ^ swapped
    x[1] = x[1] ^ x[0]
    x[2] = x[2] ^ x[1]
    turn = np.zeros_like(x[0])
    for digit in digits[:-1]:
        turn ^= np.where(x[2] & digit, digit - one, np.uint64(0))
    key = np.zeros_like(x[0])
    for digit in digits:
        for k in range(3):
            key = (key << one) | ((x[k] ^ turn) & digit != 0).astype(np.uint64)
    return key
