"""Statistics of the distances between groups of vertices: a number for each pair of labels."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import TableStatistic

_UFUNCS: dict[TableStatistic, Any] = {"mean": np.add, "min": np.minimum, "max": np.maximum}


class LabelGroups:
    """Groups of the vertices of a mesh by label, and statistics of the distances between them.

    Parameters
    ----------
    mesh : vertices without faces belong to no group.
    labels : (n,) or (m,) array, of vertices or of faces. A vertex belongs to the groups of all its faces.
    of_faces : whether the labels are of faces.
    statistics : what the tables contain, in this order.

    Attributes
    ----------
    values : (L,) array
        The labels, ascending.
    """

    def __init__(
        self, mesh: TriangleMesh, labels: Floats, of_faces: bool, statistics: Sequence[TableStatistic]
    ) -> None:
        labels = np.asarray(labels, dtype=np.float64)
        of_corners = np.repeat(labels, 3) if of_faces else labels[mesh.faces.ravel()]
        pairs = np.unique(np.stack([of_corners, mesh.faces.ravel()], axis=1), axis=0)
        self.values, self._starts, self._sizes = np.unique(pairs[:, 0], return_index=True, return_counts=True)
        self._vertices: Ints = pairs[:, 1].astype(np.int64)
        self.statistics = tuple(statistics)

    def of_rows(self, rows: Floats) -> Floats:
        """Return the statistics of rows of distances, (k, n), over the vertices of each group, (k, s, L)."""
        return np.stack([self._reduced(name, rows[:, self._vertices]) for name in self.statistics], axis=1)

    def _reduced(self, name: TableStatistic, values: Floats) -> Floats:
        """Reduce the columns of each group to one."""
        total: Floats = _UFUNCS[name].reduceat(values, self._starts, axis=1)
        return total / self._sizes if name == "mean" else total

    @property
    def groups(self) -> list[Ints]:
        """Vertices of each group, ascending."""
        return np.split(self._vertices, self._starts[1:])

    def report(self) -> dict[str, Any]:
        """Return labels, groups and statistics as plain values."""
        groups = [group.tolist() for group in self.groups]
        return {"labels": self.values.tolist(), "groups": groups, "statistics": list(self.statistics)}


def label_table(values: Floats, groups: Sequence[Ints], statistics: Sequence[TableStatistic]) -> Floats:
    """Return statistics between groups, (s, L, L), from those of vertices by `LabelGroups.of_rows`, (n, s, L)."""
    table = np.empty((len(statistics), len(groups), len(groups)))
    for k, vertices in enumerate(groups):
        for s, name in enumerate(statistics):
            total = _UFUNCS[name].reduce(values[vertices, s], axis=0)
            table[s, k] = total / len(vertices) if name == "mean" else total
    return table
