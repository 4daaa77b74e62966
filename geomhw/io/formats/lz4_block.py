"""Decoder of LZ4 blocks [LZ4 block format description, version of 2022], as a compiled loop."""

import numpy as np

from geomhw.arrays import Ints
from geomhw.compiled import compiled


def unpack_lz4(packed: bytes, size: int) -> bytes:
    """Return the bytes of a block; fewer than its size if the block is damaged."""
    plain = np.empty(min(size, 255 * len(packed)), np.uint8)  # no block unpacks to more
    return plain[: _unpack(np.frombuffer(packed, np.uint8), plain)].tobytes()


@compiled
def _unpack(packed: Ints, plain: Ints) -> int:
    """Fill the plain bytes; return their number, or 0 for a damaged block."""
    i, j = 0, 0
    while i < len(packed):
        token = np.int64(packed[i])
        count, i = _length(packed, i + 1, token >> 4)
        if i + count > len(packed) or j + count > len(plain):
            return 0
        plain[j : j + count] = packed[i : i + count]
        i, j = i + count, j + count
        if i + 2 > len(packed):  # the last sequence has no match
            return j if i == len(packed) else 0
        back = np.int64(packed[i]) + 256 * np.int64(packed[i + 1])
        count, i = _length(packed, i + 2, token & 15)
        if not 0 < back <= j or j + count + 4 > len(plain):
            return 0
        for k in range(j, j + count + 4):
            plain[k] = plain[k - back]
        j += count + 4
    return j


@compiled
def _length(packed: Ints, i: int, count: int) -> tuple[int, int]:
    """A length whose first four bits are given, and the position after its further bytes."""
    more = 255 if count == 15 else 0
    while more == 255 and i < len(packed):
        more = np.int64(packed[i])
        count, i = count + more, i + 1
    return count, i
