"""One-rings: what values do next to each vertex."""

import numpy as np

from geomhw.arrays import Floats, Ints


class OneRings:
    """The neighbors of each vertex by columns: the k-th neighbor of all vertices that have so many.

    edges: (e, 2), each edge once; n: how many vertices there are.
    """

    def __init__(self, edges: Ints, n: int) -> None:
        ends = np.concatenate([edges, edges[:, ::-1]])
        ends = ends[np.argsort(ends[:, 0], kind="stable")]
        valences = np.bincount(ends[:, 0], minlength=n)
        starts = np.cumsum(valences) - valences
        self._order = np.argsort(-valences, kind="stable")  # so that who has a k-th neighbor comes first
        sorted_starts, sorted_valences = starts[self._order], valences[self._order]
        self._columns = [
            ends[sorted_starts[: np.searchsorted(-sorted_valences, -k)] + k, 1].astype(np.intp)
            for k in range(valences.max(initial=0))
        ]

    def largest(self, values: Floats) -> Floats:
        """The largest of the values, (n,) or (n, k), at each vertex and its neighbors."""
        most = np.take(values, self._order, axis=0)
        for column in self._columns:
            first = most[: len(column)]
            np.maximum(first, np.take(values, column, axis=0), out=first)
        around = np.empty_like(most)
        around[self._order] = most
        return around
