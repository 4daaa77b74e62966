"""Functions held below the distance along edges, many at once, at a fraction of what these distances cost.

A function φ with φ = 0 at a source exceeds the length of a path along edges only where it climbs faster than the path
gets longer. How much faster at most, at each level of φ, is told by the steep edges there: with q(φ) the largest share
of a climb that is beyond the length of its edge, no path from a vertex on gains more than R = ∫ q over the levels above
it, for an edge that leads down loses more than what is gained on the way up again. From the source, only vertices are
visited whose path is ahead of φ by less than R: on a regular mesh one in a hundred. On a mesh with many steep edges all
distances along edges are computed after all.
"""

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import edge_graph

#: Differences below this share of the largest value are rounding.
ROUNDING = 1e-13
#: Levels that are told apart.
LEVELS = 64
#: With more steep edges, or visits, than these shares of the vertices, all distances take less time.
STEEP, VISITS = 0.1, 0.05
#: Edges times functions that are looked at together: what fits into a cache.
PIECE = 1 << 18


class EdgePathBound:
    """The least of functions on one surface and the distance along edges from a vertex to each."""

    def __init__(self, surface: PolyhedralSurface) -> None:
        self._ends, self._lengths = surface.edges, surface.edge_lengths[:, None]
        both_ways = np.concatenate([surface.edges, surface.edges[:, ::-1]]).astype(np.int64)
        self._graph = edge_graph(both_ways, np.tile(surface.edge_lengths, 2), surface.n_vertices)
        self._paths, self._last = np.empty(0), np.empty(0, dtype=np.int64)

    def __call__(self, phi: Floats, sources: Ints) -> None:
        """Lower φ, (n, k), in place, to the distance along edges from the source of its column, (k,), where φ is 0."""
        from scipy.sparse.csgraph import dijkstra

        n, k = phi.shape
        least = ROUNDING * float(max(phi.max(), -phi.min()))
        low, high, columns, gains = self._steep(phi, least)
        few = np.bincount(columns, minlength=k) <= STEEP * n
        light = few[columns]
        levels = _Levels.of(phi, low[light], high[light], columns[light], gains[light])
        begin = np.flatnonzero(few & (levels.ahead[0] > least))
        if not self._follow(phi, np.asarray(sources)[begin].astype(np.int64) * k + begin, levels):
            few[begin] = False
        for column in np.flatnonzero(~few):
            phi[:, column] = np.minimum(phi[:, column], dijkstra(self._graph, indices=sources[column]))

    def _steep(self, phi: Floats, least: float) -> tuple[Floats, Floats, Ints, Floats]:
        """Edges on which φ climbs more than their length: from where to where, in which column, and how much more."""
        found = []
        size = max(1, PIECE // phi.shape[1])
        for start in range(0, len(self._ends), size):
            i, j = self._ends[start : start + size].T
            climb = phi[i] - phi[j]
            steepness = np.abs(climb, out=climb)
            steepness -= self._lengths[start : start + size]
            edge, column = np.divmod(np.flatnonzero(steepness > least), phi.shape[1])
            ends = phi[i[edge], column], phi[j[edge], column]
            found.append((np.minimum(*ends), np.maximum(*ends), column, steepness[edge, column]))
        low, high, columns, gains = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return low, high, columns, gains

    def _follow(self, phi: Floats, begin: Ints, levels: "_Levels") -> bool:
        """Lower φ along paths from places, vertex · k + column, as far as they may yet fall below it; or give up."""
        k, flat = phi.shape[1], phi.reshape(-1)
        if len(self._paths) < len(flat):
            self._paths, self._last = np.full(len(flat), np.inf), np.empty(len(flat), dtype=np.int64)
        paths, most = self._paths, VISITS * len(phi) * len(begin)
        paths[begin] = 0.0
        visited, count = [begin], 0
        while len(begin) and count <= most:
            vertex, column = np.divmod(begin, k)
            starts = self._graph.indptr[vertex]
            degree = self._graph.indptr[vertex + 1] - starts
            onward = np.repeat(np.arange(len(begin)), degree)
            edge = np.arange(len(onward)) + np.repeat(starts - np.cumsum(degree) + degree, degree)
            column = column[onward]
            ends = self._graph.indices[edge] * np.int64(k) + column
            found = paths[begin][onward] + self._graph.data[edge]
            useful = (found < paths[ends]) & (found - flat[ends] < levels.gain(flat[ends], column))
            begin = self._lowered(paths, ends[useful], found[useful])
            visited.append(begin)
            count += len(begin)
        everywhere = np.concatenate(visited)
        flat[everywhere] = np.minimum(flat[everywhere], paths[everywhere])
        paths[everywhere] = np.inf
        return count <= most

    def _lowered(self, values: Floats, places: Ints, found: Floats) -> NDArray[np.int64]:
        """Places whose values these lower, in place; each once."""
        np.minimum.at(values, places, found)
        count = np.arange(len(places))
        self._last[places] = count
        return places[self._last[places] == count]


class _Levels:
    """What can be gained above a level, by column: ahead, (L, k), from ``lowest`` on in steps of ``widths``, (k,)."""

    def __init__(self, lowest: Floats, widths: Floats, ahead: Floats) -> None:
        self.lowest, self.widths, self.ahead = lowest, widths, ahead

    @classmethod
    def of(cls, phi: Floats, low: Floats, high: Floats, columns: Ints, gains: Floats) -> "_Levels":
        """From steep edges. A step is no shorter than their climbs, so that each is in one step or two."""
        lowest = phi.min(axis=0)
        widths = (phi.max(axis=0) - lowest) / LEVELS
        np.maximum.at(widths, columns, high - low)
        widths[widths <= 0] = 1.0
        levels = cls(lowest, widths, np.zeros((LEVELS + 2, len(lowest))))
        shares = gains / (high - low)
        for ends in (low, high):
            np.maximum.at(levels.ahead, (levels.step(ends, columns), columns), shares)
        levels.ahead[:] = np.cumsum((levels.ahead * widths)[::-1], axis=0)[::-1]
        return levels

    def step(self, values: Floats, columns: Ints) -> NDArray[np.int64]:
        """Which step a value is in."""
        return ((values - self.lowest[columns]) / self.widths[columns]).astype(np.int64)

    def gain(self, values: Floats, columns: Ints) -> Floats:
        """No path gains more from there on."""
        return np.asarray(self.ahead[self.step(values, columns), columns])
