"""Polygons of any size in flat arrays, and the fan of triangles each of them becomes."""

from collections.abc import Callable

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError


def ragged(begins: Ints, counts: Ints) -> Ints:
    """The ranges ``begins[i] .. begins[i] + counts[i]`` one after the other.

    >>> ragged(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    counts = np.asarray(counts, dtype=np.int64)
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    return np.asarray(np.repeat(begins - (ends - counts), counts) + np.arange(total))


def fan(corners: Ints, sizes: Ints) -> tuple[Ints, Ints]:
    """Triangles (i1, i_j, i_j+1) of each polygon, in order, and the polygon each of them comes from.

    corners: vertex indices of all polygons, flat. sizes: corners of each, at least 3.
    """
    if np.all(sizes == 3):
        return corners.reshape(-1, 3), np.arange(len(sizes))
    begins = np.cumsum(sizes) - sizes
    origin = np.repeat(np.arange(len(sizes)), sizes - 2)
    triangles = np.empty((len(origin), 3), corners.dtype)  # filled column by column, for the sake of memory
    triangles[:, 0] = np.repeat(corners[begins], sizes - 2)
    second = ragged(begins + 1, sizes - 2)
    triangles[:, 1] = corners[second]
    second += 1
    triangles[:, 2] = corners[second]
    return triangles, origin


def check_polygons(corners: Ints, sizes: Ints, n_vertices: int, place: Callable[[int], str]) -> None:
    """FormatError unless polygons have three corners or more, all different, among the vertices.

    place: says where polygon i is, as the start of a sentence: ``moo.off, line 17``.
    """
    if (small := sizes < 3).any():
        bad = int(np.argmax(small))
        raise FormatError(f"{place(bad)}: face has {sizes[bad]} corners; it needs at least 3")
    if len(corners) and (corners.min() < 0 or corners.max() >= n_vertices):
        at = int(np.argmax((corners < 0) | (corners >= n_vertices)))
        bad = polygon_of(at, sizes)
        raise FormatError(
            f"{place(bad)}: face names vertex {int(corners[at])}, but there are {n_vertices} (0 to {n_vertices - 1})"
        )
    check_distinct(corners, sizes, place)


def check_distinct(corners: Ints, sizes: Ints, place: Callable[[int], str], base: int = 0) -> None:
    """FormatError where a polygon names a vertex twice; ``base`` is added to the index in the message."""
    if np.all(sizes == 3):
        triangles = corners.reshape(-1, 3)
        a, b, c = triangles.T
        repeated = np.flatnonzero((a == b) | (b == c) | (c == a))
        if not len(repeated):
            return
    elif np.all(sizes == sizes[0]):
        ordered = np.sort(corners.reshape(len(sizes), -1), axis=1)
        if not (ordered[:, 1:] == ordered[:, :-1]).any():
            return
    owner = np.repeat(np.arange(len(sizes), dtype=np.int32), sizes)
    order = np.lexsort((corners, owner))
    twins = (np.diff(corners[order]) == 0) & (np.diff(owner[order]) == 0)
    if twins.any():
        at = order[int(np.argmax(twins))]
        raise FormatError(f"{place(int(owner[at]))}: face names vertex {int(corners[at]) + base} twice")


def polygon_of(corner: int, sizes: Ints) -> int:
    """Which polygon a position in the flat corners belongs to."""
    return int(np.searchsorted(np.cumsum(sizes), corner, side="right"))
