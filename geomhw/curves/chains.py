"""Chains of links: open ones from end to end, then closed ones."""

import numpy as np

from geomhw.arrays import Ints
from geomhw.compiled import compiled


@compiled
def chains(partners: Ints) -> tuple[Ints, Ints, int]:
    """Return the entry ends of links chain by chain, (L,), the start of each chain, (c + 1,), the number of open ones.

    Link l has the ends 2l and 2l+1. partners: (2L,), the end that continues each end, or -1.
    """
    size = len(partners) // 2
    order, starts, used = np.empty(size, np.int64), np.zeros(size + 1, np.int64), np.zeros(size, np.bool_)
    count = at = opened = 0
    for closed in range(2):
        for first in range(2 * size):
            if used[first // 2] or (closed == 0 and partners[first] >= 0):
                continue
            end = first
            while end >= 0 and not used[end // 2]:
                order[at], used[end // 2] = end, True
                at += 1
                end = partners[end ^ 1]
            count += 1
            starts[count] = at
        if closed == 0:
            opened = count
    return order, starts[: count + 1], opened
