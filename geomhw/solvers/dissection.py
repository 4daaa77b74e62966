"""Nested dissection: the unknowns of a sparse system as a binary tree of separators.

A part is halved, and those of its unknowns that touch the other half are set apart, to be eliminated after both. So the
halves know nothing of each other, however far elimination fills the matrix [George 1973]. Here the parts of one level
are halved together: across the direction in which each is longest, in coordinates that are numbers of steps from a few
landmarks; and a least set of unknowns that covers all links between the halves is set apart [König 1931].

George: Nested Dissection of a Regular Finite Element Mesh. SIAM J. Numer. Anal. 10(2), 1973.
Chan, Gilbert, Teng: Geometric Spectral Partitioning. Xerox PARC Technical Report, 1995 (bisection in coordinates).
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints

#: Landmarks that unknowns get their coordinates from.
LANDMARKS = 4
#: Parts of about this size are not halved any more: dense algebra on them is as fast as any on their halves.
LEAF = 64


@dataclass(frozen=True)
class Dissection:
    """A binary tree of nodes, and which of them has each unknown.

    nodes: (n,), by the numbers of a heap: 1 is the root, and 2k and 2k+1 hang from k. An entry A_ij that is not zero,
    or becomes so, has the node of i above that of j, or below, or the same. depth: the leaves' distance to the root.
    """

    nodes: Ints
    depth: int

    @classmethod
    def of(cls, matrix: sp.csr_array, leaf: int = LEAF) -> "Dissection":
        """Of a matrix, (n, n), of symmetric pattern; the values do not matter."""
        n = matrix.shape[0]
        depth = max(0, math.ceil(math.log2(max(n, 1) / leaf)))
        pattern = sp.csr_array((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
        places = _coordinates(pattern) if depth else np.zeros((n, 1))
        links = np.stack(sp.triu(pattern, 1).tocoo().coords)
        parts, nodes, active = np.ones(n, np.int64), np.zeros(n, np.int64), np.arange(n)
        side = np.zeros(n, np.int64)
        for level in range(depth):
            first = 1 << level
            side[active] = _upper_half(places[active], parts[active] - first, first)
            same = (parts[links[0]] == parts[links[1]]) & (nodes[links] == 0).all(axis=0)
            links = links[:, same]
            across = side[links[0]] != side[links[1]]
            apart = _least_cover(np.where(side[links] == 0, links, links[::-1])[:, across], n)
            nodes[apart] = parts[apart]
            active = active[nodes[active] == 0]
            parts[active] = 2 * parts[active] + side[active]
        nodes[active] = parts[active]
        return cls(nodes, depth)


def _upper_half(places: Floats, parts: Ints, count: int) -> NDArray[np.bool_]:
    """Which points, (k, d), are in the upper half of their part along its longest direction."""
    sizes = np.bincount(parts, minlength=count)
    centers = np.stack([np.bincount(parts, x, count) for x in places.T], axis=1) / np.maximum(sizes, 1)[:, None]
    offset = places - centers[parts]
    d = places.shape[1]
    spread = np.stack([np.bincount(parts, offset[:, a] * offset[:, b], count) for a in range(d) for b in range(d)])
    longest = np.linalg.eigh(spread.T.reshape(count, d, d))[1][:, :, -1]
    along = np.einsum("kd,kd->k", offset, longest[parts])
    order = np.lexsort((along, parts))
    starts = np.cumsum(sizes) - sizes
    upper = np.empty(len(parts), dtype=bool)
    upper[order] = 2 * (np.arange(len(parts)) - starts[parts[order]]) >= sizes[parts[order]]
    return upper


def _least_cover(links: Ints, n: int) -> Ints:
    """The fewest unknowns that every link, (2, k), from a lower to an upper one, has one of [König 1931]."""
    from scipy.sparse.csgraph import maximum_bipartite_matching

    (low, i), (high, j) = (np.unique(ends, return_inverse=True) for ends in links)
    if not len(low):
        return low
    graph = sp.csr_array((np.ones(len(i)), (i, j)), shape=(len(low), len(high)))
    partner = maximum_bipartite_matching(graph, perm_type="column")
    matched = np.flatnonzero(partner >= 0)
    back = np.full(len(high), -1)
    back[partner[matched]] = matched
    # What alternating paths from unmatched lower ones reach: those on the upper side cover, the rest of the lower do.
    reached_low, reached_high = partner < 0, np.zeros(len(high), dtype=bool)
    upward = graph.T.tocsr()
    while (more := (upward @ reached_low.astype(float) > 0) & ~reached_high).any():
        reached_high |= more
        reached_low[back[more]] = True
    return np.concatenate([low[~reached_low], high[reached_high]])


def _coordinates(matrix: sp.csr_array) -> Floats:
    """Numbers of steps from landmarks, each as far as can be from those before, (n, d); components lie far apart."""
    from scipy.sparse.csgraph import connected_components

    count, labels = connected_components(matrix, directed=False)
    nearest = _steps(matrix, np.unique(labels, return_index=True)[1])
    columns: list[Floats] = []
    for _ in range(LANDMARKS):
        ranked = np.lexsort((nearest, labels))
        farthest = ranked[np.append(np.flatnonzero(np.diff(labels[ranked])), len(ranked) - 1)]
        columns.append(_steps(matrix, farthest))
        nearest = np.minimum(nearest, columns[-1]) if len(columns) > 1 else columns[0]
    if count > 1:
        columns.append(labels * (4.0 * max(column.max() for column in columns) + 1))
    return np.stack(columns, axis=1)


def _steps(matrix: sp.csr_array, starts: Ints) -> Floats:
    """The least number of links to each unknown from one of the starts, of which every component has one, (n,)."""
    from scipy.sparse.csgraph import breadth_first_order

    n = matrix.shape[0]
    # One more unknown, from which all starts are reached.
    indices = np.append(matrix.indices, starts)
    graph = sp.csr_array((np.ones(len(indices)), indices, np.append(matrix.indptr, len(indices))), shape=(n + 1, n + 1))
    before = breadth_first_order(graph, n)[1]
    before[n] = n
    steps = np.where(before == n, 0, 1)
    while (before != n).any():  # as many rounds as there are bits in the longest path
        steps += steps[before]
        before = before[before]
    return steps[:n].astype(float)
