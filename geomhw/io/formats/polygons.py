"""Polygons of any size in flat arrays: their checks, and the fan of triangles that replaces each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Polygons:
    """Contents of a mesh file: points (n, 3), vertex indices, flat, and size of each polygon, arrays, report notes."""

    points: Floats
    corners: Ints
    sizes: Ints
    vertex_arrays: Arrays = field(default_factory=dict)
    face_arrays: Arrays = field(default_factory=dict)
    mesh_arrays: Arrays = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)


def ranges(begins: Ints, counts: Ints, step: int = 1) -> Ints:
    """Concatenate the ranges ``begins[i], begins[i] + step, ...`` of ``counts[i]`` numbers each.

    >>> ranges(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    counts = np.asarray(counts, dtype=np.int64)
    ends = np.cumsum(counts)
    found = np.repeat(begins - step * (ends - counts), counts)
    found += np.arange(0, step * len(found), step)
    return found


def fan_triangles(corners: Ints, sizes: Ints) -> tuple[Ints, Ints]:
    """Return the triangles (i1, i_j, i_j+1) of each polygon, in order, and the polygon of each triangle.

    corners: vertex indices of all polygons, flat. sizes: number of corners of each, at least 3.
    """
    if np.all(sizes == 3):
        return corners.reshape(-1, 3), np.arange(len(sizes))
    begins = np.cumsum(sizes) - sizes
    triangles = np.empty((int(np.sum(sizes - 2)), 3), corners.dtype)  # filled column by column, which saves memory
    triangles[:, 0] = np.repeat(corners[begins], sizes - 2)
    second = ranges(begins + 1, sizes - 2)
    triangles[:, 1] = corners[second]
    triangles[:, 2] = corners[second + 1]
    return triangles, np.repeat(np.arange(len(sizes)), sizes - 2)


def check_polygons(corners: Ints, sizes: Ints, n_vertices: int, place: Callable[[int], str]) -> None:
    """Raise FormatError unless each polygon has three corners or more, all different, among the vertices.

    place: returns where polygon i is, as the start of a message: ``moo.off, line 17``.
    """
    if (small := sizes < 3).any():
        bad = int(np.argmax(small))
        raise FormatError(f"{place(bad)}: face has {sizes[bad]} corners; it needs at least 3")
    if len(corners) and (corners.min() < 0 or corners.max() >= n_vertices):
        at = int(np.argmax((corners < 0) | (corners >= n_vertices)))
        raise FormatError(
            f"{place(polygon_of(at, sizes))}: face names vertex {int(corners[at])}, "
            f"but there are {n_vertices} (0 to {n_vertices - 1})"
        )
    check_distinct(corners, sizes, place)


def check_distinct(corners: Ints, sizes: Ints, place: Callable[[int], str], base: int = 0) -> None:
    """Raise FormatError where a polygon names a vertex twice; ``base`` is added to the index in the message."""
    width = int(sizes.max(initial=3))
    if width <= 8 and (sizes == width).all():
        table = corners.reshape(-1, width)
        if not any((table[:, i] == table[:, j]).any() for i in range(width) for j in range(i)):
            return
    owner = np.repeat(np.arange(len(sizes), dtype=np.int32), sizes)
    order = np.lexsort((corners, owner))
    equal = (np.diff(corners[order]) == 0) & (np.diff(owner[order]) == 0)
    if equal.any():
        at = order[int(np.argmax(equal))]
        raise FormatError(f"{place(int(owner[at]))}: face names vertex {int(corners[at]) + base} twice")


def polygon_of(corner: int, sizes: Ints) -> int:
    """Return the polygon that holds a position in the flat corners."""
    return int(np.searchsorted(np.cumsum(sizes), corner, side="right"))
