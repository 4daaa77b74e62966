"""Contents of a mesh file with polygons of any size in flat arrays, and their checks."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, ranges
from geomhw.errors import FormatError

Arrays = Mapping[str, NDArray[Any]]
#: Returns where a face or vertex is, as the start of a message: ``moo.off, line 17``.
Place = Callable[[int], str]


@dataclass(frozen=True)
class Polygons:
    """Contents of a mesh file: points (n, 3), vertex indices, flat, and size of each polygon, arrays, report notes.

    labels: names of the values of face arrays that are labels.

    remarks: sentences on what was read differently from what the file says.
    """

    points: Floats
    corners: Ints
    sizes: Ints
    vertex_arrays: Arrays = field(default_factory=dict)
    face_arrays: Arrays = field(default_factory=dict)
    mesh_arrays: Arrays = field(default_factory=dict)
    labels: Mapping[str, Mapping[int, str]] = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)


def strip_triangles(corners: Ints, sizes: Ints) -> tuple[Ints, Ints]:
    """Return the corners of the triangles of strips, flat, and the strip of each triangle.

    Every second triangle of a strip is turned, so that all have the orientation of the first.

    >>> strip_triangles(np.array([4, 5, 6, 7]), np.array([4]))[0].tolist()
    [4, 5, 6, 7, 6, 5]
    """
    counts = np.maximum(sizes - 2, 0)
    first = ranges(np.cumsum(sizes) - sizes, counts)
    odd = ranges(np.zeros_like(counts), counts) % 2
    return corners[np.stack([first + 2 * odd, first + 1, first + 2 - 2 * odd], axis=1)].ravel(), np.repeat(
        np.arange(len(sizes)), counts
    )


#: Plane pieces of a face with nodes on its sides, by its number of nodes in VTK's order: corners, the middles of the
#: sides, and for 7 and 9 nodes the center.
_PIECES = {
    6: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    7: ((0, 3, 6), (3, 1, 6), (1, 4, 6), (4, 2, 6), (2, 5, 6), (5, 0, 6)),
    8: ((0, 4, 1, 5, 2, 6, 3, 7),),
    9: ((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3)),
}


def plane_pieces(nodes: Ints) -> tuple[Ints, Ints, Ints]:
    """Return the corners, flat, and sizes of the pieces of faces of second order, and the face of each piece.

    nodes: (k, 6) to (k, 9).

    >>> plane_pieces(np.array([[10, 11, 12, 13, 14, 15]]))[0].tolist()
    [10, 13, 15, 13, 11, 14, 15, 14, 12, 13, 14, 15]
    """
    pieces = np.array(_PIECES[nodes.shape[1]])
    faces = np.repeat(np.arange(len(nodes)), len(pieces))
    return nodes[:, pieces].ravel(), np.full(len(faces), pieces.shape[1]), faces


def check_indices(corners: Ints, sizes: Ints, n_vertices: int, place: Place) -> None:
    """Raise FormatError if a polygon names a vertex that does not exist."""
    if len(corners) and (corners.min() < 0 or corners.max() >= n_vertices):
        at = int(np.argmax((corners < 0) | (corners >= n_vertices)))
        raise FormatError(
            f"{place(polygon_of(at, sizes))}: face names vertex {int(corners[at])}, "
            f"but there are {n_vertices} (0 to {n_vertices - 1})"
        )


def without_repetitions(corners: Ints, sizes: Ints) -> tuple[Ints, Ints, Ints]:
    """Remove corners that repeat their neighbor in a polygon, and sides that go forth and back.

    Returns
    -------
    corners, sizes
        Of the polygons with three corners or more that are left.
    kept
        These polygons, ascending.
    """
    if not _may_repeat(corners, sizes):
        return corners, sizes, np.arange(len(sizes))
    owner = np.repeat(np.arange(len(sizes)), sizes)
    ends = np.cumsum(sizes)
    following = np.arange(1, len(corners) + 1)
    following[ends[sizes > 0] - 1] = (ends - sizes)[sizes > 0]
    single = (corners != corners[following]) | (following == np.arange(len(corners)))
    corners, owner = corners[single], owner[single]
    sizes = np.bincount(owner, minlength=len(sizes))
    begins = np.cumsum(sizes) - sizes
    stays = np.ones(len(corners), dtype=bool)
    for i in np.flatnonzero((sizes > 3) & _repeats(corners, owner, len(sizes))).tolist():
        ids = corners[begins[i] : begins[i] + sizes[i]].tolist()
        stays[begins[i] : begins[i] + sizes[i]] = False
        stays[begins[i] + np.array(_without_spikes(ids), dtype=np.int64)] = True
    sizes = np.bincount(owner[stays], minlength=len(sizes))
    stays &= (sizes >= 3)[owner]
    kept = np.flatnonzero(sizes >= 3)
    return corners[stays], sizes[kept], kept


def _may_repeat(corners: Ints, sizes: Ints) -> bool:
    """Whether a polygon has fewer than three corners, or may have one twice."""
    if sizes.min(initial=3) < 3:
        return True
    width = int(sizes.max(initial=3))
    if width <= 8 and (sizes == width).all():
        table = corners.reshape(-1, width)
        return any(bool((table[:, i] == table[:, j]).any()) for i in range(width) for j in range(i))
    return bool(_repeats(corners, np.repeat(np.arange(len(sizes)), sizes), len(sizes)).any())


def _repeats(corners: Ints, owner: Ints, size: int) -> NDArray[np.bool_]:
    """Whether each polygon has a corner twice."""
    order = np.lexsort((corners, owner))
    equal = (np.diff(corners[order]) == 0) & (np.diff(owner[order]) == 0)
    found = np.zeros(size, dtype=bool)
    found[owner[order[1:][equal]]] = True
    return found


def _without_spikes(ids: list[int]) -> list[int]:
    """Positions of the corners of a polygon that are left when b goes wherever a, b, a follow each other."""
    left: deque[int] = deque()
    for i, corner in enumerate(ids):
        while len(left) >= 2 and ids[left[-2]] == corner:
            left.pop()
        if not left or ids[left[-1]] != corner:
            left.append(i)
    while len(left) >= 3:  # across the end of the list
        if ids[left[0]] in (ids[left[-1]], ids[left[-2]]):
            left.pop()
        elif ids[left[1]] == ids[left[-1]]:
            left.popleft()
        else:
            break
    return list(left)


def polygon_of(corner: int, sizes: Ints) -> int:
    """Return the polygon that holds a position in the flat corners."""
    return int(np.searchsorted(np.cumsum(sizes), corner, side="right"))


def equal_triangles(one: Ints, other: Ints) -> bool:
    """Whether two lists of corners have the same triangles, in any order."""
    one, other = (np.sort(flat.reshape(-1, 3).astype(np.int64), axis=1) for flat in (one, other))
    return len(one) == len(other) and np.array_equal(one[np.lexsort(one.T)], other[np.lexsort(other.T)])
