"""Clamp functions to the edge-path distance from a vertex without a full Dijkstra run each.

A function φ with φ = 0 at the source exceeds the length of an edge path only where it climbs faster than the path gets
longer. Let q(φ) be the largest share of a climb through the level φ that exceeds the length of its edge. Beyond a
vertex of level φ, no path gains more on the function than the integral of q over the levels above. So Dijkstra's
algorithm only visits vertices whose path is ahead of φ by less than that: one in a hundred on a regular mesh.
"""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import edge_graph

#: Differences below this share of the largest value are rounding.
ROUNDING = 1e-13
#: Levels between the least and the largest value of a function.
LEVELS = 64


class EdgePathBound:
    """The smaller of functions on one surface and the edge-path distance from a vertex to each."""

    def __init__(self, surface: PolyhedralSurface) -> None:
        both_ways = np.concatenate([surface.edges, surface.edges[:, ::-1]]).astype(np.int64)
        graph = edge_graph(both_ways, np.tile(surface.edge_lengths, 2), surface.n_vertices)
        self._graph = graph.indptr, graph.indices, graph.data

    def __call__(self, phi: Floats, sources: Ints) -> None:
        """Clamp φ, (n, k), in place, to the edge-path distance from the source of its column, (k,), where φ is 0."""
        columns = np.ascontiguousarray(phi.T)
        for function, source in zip(columns, np.asarray(sources), strict=True):
            _clamp(*self._graph, function, source)
        phi[:] = columns.T


@compiled
def _clamp(indptr: Ints, indices: Ints, lengths: Floats, phi: Floats, source: int) -> None:
    """Clamp one function, (n,), in place, where it is 0 at the source."""
    lowest, width, gains = _gains(indptr, indices, lengths, phi)
    if gains[0] <= 0.0:
        return
    order, rank = _bucket_order(phi)
    path, waiting = np.full(len(phi), np.inf), np.zeros(len(phi), dtype=np.bool_)
    path[source], waiting[source] = 0.0, True
    # φ is nearly the path length: in its order, nearly each vertex is final when its turn comes.
    again = True
    while again:
        again = False
        for i in order:
            if waiting[i]:
                waiting[i] = False
                for p in range(indptr[i], indptr[i + 1]):
                    j, length = np.uintp(indices[p]), path[i] + lengths[p]
                    if length < path[j] and length - phi[j] < gains[np.uintp((phi[j] - lowest) / width)]:
                        path[j], waiting[j] = length, True
                        again = again or rank[j] <= rank[i]
    for i in range(len(phi)):
        phi[i] = min(phi[i], path[i])


@compiled
def _bucket_order(values: Floats) -> tuple[Ints, Ints]:
    """Indices by ascending value up to the width of a bucket, and the place of each index in that order."""
    n = len(values)
    lowest, highest = values.min(), values.max()
    scale = n / (highest - lowest) if highest > lowest else 0.0
    starts, buckets = np.zeros(n + 2, dtype=np.int64), np.empty(n, dtype=np.int64)
    for i in range(n):
        buckets[i] = int((values[i] - lowest) * scale)
        starts[buckets[i] + 1] += 1
    starts = np.cumsum(starts)
    order, rank = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    for i in range(n):
        rank[i] = starts[buckets[i]]
        order[rank[i]] = i
        starts[buckets[i]] += 1
    return order, rank


@compiled
def _gains(indptr: Ints, indices: Ints, lengths: Floats, phi: Floats) -> tuple[float, float, Floats]:
    """The least value, the width of a level, and by level the most that a path gains on φ from there on."""
    gains = np.zeros(LEVELS + 2)
    lowest, highest = phi.min(), phi.max()
    rounding = ROUNDING * max(highest, -lowest)
    width = (highest - lowest) / LEVELS
    for i in range(len(phi)):
        for p in range(indptr[i], indptr[i + 1]):
            climb = phi[indices[p]] - phi[i]
            if climb - lengths[p] > rounding:
                width = max(width, climb)  # so that a climb reaches two levels at most
    if not width > 0.0:
        return lowest, 1.0, gains
    for i in range(len(phi)):
        for p in range(indptr[i], indptr[i + 1]):
            climb = phi[indices[p]] - phi[i]
            if climb - lengths[p] > rounding:
                share = 1.0 - lengths[p] / climb
                for end in (phi[i], phi[indices[p]]):
                    level = int((end - lowest) / width)
                    gains[level] = max(gains[level], share)
    for level in range(LEVELS, -1, -1):
        gains[level] = gains[level + 1] + gains[level] * width
    return lowest, width, gains
