"""Triangles for polygons: fans where these are valid, the other diagonal of some quads, and ear clipping."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, pieces, ranges
from geomhw.mesh import geometry

#: A fan is valid if each of its triangles has at least this height, over its longest side, seen from the mean normal.
_THINNEST = 1e-6
#: A quad is warped if its two triangles meet at more than this angle (cosine), and its other diagonal is better if its
#: triangles meet at an angle whose cosine is larger by the second number.
_FLAT, _BETTER = np.cos(np.radians(5.0)), 1e-3


@dataclass(frozen=True)
class Triangulation:
    """Triangles (m, 3), the polygon of each, and the polygons whose sides cross or that have no area."""

    triangles: Ints
    polygons: Ints
    failed: Ints


def triangulate(points: Floats, corners: Ints, sizes: Ints) -> Triangulation:
    """Divide polygons into triangles, in order.

    The triangles of a polygon are the fan around its first corner where all of them are turned the same way and have
    an area. A quad that is concave there or clearly folded is divided by its other diagonal; ears are cut off any
    other polygon.

    corners: vertex indices of all polygons, flat. sizes: number of corners of each, at least 3.
    """
    if np.all(sizes == 3):
        return Triangulation(corners.reshape(-1, 3), np.arange(len(sizes)), np.empty(0, np.int64))
    begins = np.cumsum(sizes) - sizes
    triangles = np.empty((int(np.sum(sizes - 2)), 3), corners.dtype)  # filled column by column, which saves memory
    triangles[:, 0] = np.repeat(corners[begins], sizes - 2)
    second = ranges(begins + 1, sizes - 2)
    triangles[:, 1] = corners[second]
    triangles[:, 2] = corners[second + 1]
    failed, first = [], begins - 2 * np.arange(len(sizes))  # first: row of the first triangle of each polygon
    with np.errstate(all="ignore"):  # coordinates may be infinite or too large to square; then fans stay
        points = points / max(float(np.abs(points).max(initial=0)), np.finfo(float).tiny)
        if len(quads := np.flatnonzero(sizes == 4)):
            for piece in pieces(len(quads)):
                table = corners[begins[quads[piece]][:, None] + np.arange(4)]
                other, bad = _quads(points, table)
                at = first[quads[piece][other]]
                triangles[at] = table[other][:, [0, 1, 3]]
                triangles[at + 1] = table[other][:, [1, 2, 3]]
                failed.append(quads[piece][bad])
        if len(large := np.flatnonzero(sizes > 4)):
            bad = large[~_fans_are_valid(points, triangles, first[large], sizes[large] - 2)]
            if len(bad):
                from geomhw.mesh.ear_clipping import triangulate_polygons

                cut, success = triangulate_polygons(points, corners, begins[bad], sizes[bad])
                triangles[ranges(first[bad], sizes[bad] - 2)] = cut
                failed.append(bad[~success])
    owner, bad = np.repeat(np.arange(len(sizes)), sizes - 2), np.sort(np.concatenate([np.empty(0, np.int64), *failed]))
    if len(bad):  # their fans may have a vertex twice
        a, b, c = triangles.T
        single = (a != b) & (b != c) & (c != a)
        triangles, owner = triangles[single], owner[single]
    return Triangulation(triangles, owner, bad)


def _quads(points: Floats, quads: Ints) -> tuple[Ints, Ints]:
    """The quads, (k, 4), to be divided by the diagonal from corner 1 to corner 3, and those valid with neither."""
    check = _doubtful(points, quads)
    some = quads[check]
    area = _normals(points, some[:, :3]) + _normals(points, some[:, [0, 2, 3]])
    first_valid, first_fold = _division(points, some[:, :3], some[:, [0, 2, 3]], area)
    valid, fold = _division(points, some[:, [0, 1, 3]], some[:, 1:], area)
    better = valid & (~first_valid | ((first_fold < _FLAT) & (fold > first_fold + _BETTER)))
    return check[better], check[~valid & ~first_valid]


def _doubtful(points: Floats, quads: Ints) -> Ints:
    """The quads that are folded along the diagonal from corner 0 to corner 2, or thin beside it."""
    a, b, c, d = (geometry.rows(points, corner) for corner in quads.T)
    b, c, d = b - a, c - a, d - a
    one, other = geometry.cross(b, c), geometry.cross(c, d)
    size = _dots(b, b) + _dots(c, c) + _dots(d, d)
    square, other_square = _dots(one, one), _dots(other, other)
    sound = np.minimum(square, other_square) > (10 * _THINNEST * size) ** 2
    return np.flatnonzero(~(sound & (_dots(one, other) > _FLAT * np.sqrt(square * other_square))))


def _division(points: Floats, one: Ints, other: Ints, area: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Whether a division of quads into two triangles is valid, and the cosine of the angle between their normals."""
    a, b = _normals(points, one), _normals(points, other)
    valid = _is_valid(points, one, a, area) & _is_valid(points, other, b, area)
    return valid, _dots(a, b) / np.sqrt(_dots(a, a) * _dots(b, b))


def _fans_are_valid(points: Floats, triangles: Ints, first: Ints, counts: Ints) -> NDArray[np.bool_]:
    """Whether all triangles of each fan are valid; first, counts: of the triangles of each."""
    rows = triangles[ranges(first, counts)]
    normals, ends = _normals(points, rows), np.cumsum(counts) - counts
    area = np.repeat(np.add.reduceat(normals, ends), counts, axis=0)
    return np.asarray(np.logical_and.reduceat(_is_valid(points, rows, normals, area), ends))


def _is_valid(points: Floats, triangles: Ints, normals: Floats, area: Floats) -> NDArray[np.bool_]:
    """Whether triangles have an area that is turned like the area vector of their polygon."""
    sides = [points[triangles[:, i]] - points[triangles[:, i - 1]] for i in range(3)]
    longest = np.maximum(np.maximum(_dots(sides[0], sides[0]), _dots(sides[1], sides[1])), _dots(sides[2], sides[2]))
    return np.asarray(_dots(normals, area) > _THINNEST * longest * np.sqrt(_dots(area, area)))


def _normals(points: Floats, triangles: Ints) -> Floats:
    a, b, c = (points[corner] for corner in triangles.T)
    return geometry.cross(b - a, c - a)


def _dots(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.einsum("kx,kx->k", one, other))
