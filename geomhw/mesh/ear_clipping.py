"""Triangulation of simple polygons in the plane by ear clipping, as a compiled loop.

Libraries such as earcut leave out corners on a straight side, which opens a crack to the neighbor that has them.
"""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled

#: Ears are cut in passes: first those whose height is at least this share of their longest side.
_SHAPES = np.array([0.2, 0.02, 1e-6, 0.0])
#: Twice an area below this many roundings of the coordinates is zero.
_ROUNDINGS = 16 * np.finfo(float).eps


def triangulate_polygons(points: Floats, corners: Ints, begins: Ints, sizes: Ints) -> tuple[Ints, Ints]:
    """Triangulate polygons in the plane across the largest component of their area vector.

    Corners on a straight side and polygons with holes, joined to the outline by a bridge of two equal sides, are
    allowed.

    Parameters
    ----------
    points : (n, 3) array of finite coordinates.
    corners : flat array of vertex indices.
    begins, sizes : (k,) arrays, position of the first corner of each polygon and number of its corners, at least 3.

    Returns
    -------
    triangles : (sum of sizes - 2, 3) array
        Vertex indices, by polygons; all of positive area in the orientation of their polygon where that has succeeded.
    success : (k,) array of bool
        False for a polygon of zero area or with sides that cross, whose triangles are those of a fan.
    """
    triangles = np.empty((int(np.sum(sizes - 2)), 3), corners.dtype)
    success = np.empty(len(sizes), dtype=np.bool_)
    _clip_all(np.ascontiguousarray(points), corners, begins, sizes, triangles, success)
    return triangles, success


@compiled
def _clip_all(points: Floats, corners: Ints, begins: Ints, sizes: Ints, triangles: Ints, success: Ints) -> None:
    row = 0
    for k in range(len(sizes)):
        size = sizes[k]
        ids = corners[begins[k] : begins[k] + size]
        x, y, rounding = _plane(points, ids)
        local = np.empty((size - 2, 3), dtype=np.int64)
        success[k] = rounding >= 0 and _clip(x, y, rounding, local)
        for j in range(size - 2):
            for c in range(3):
                at = local[j, c] if success[k] else (0 if c == 0 else j + c)
                triangles[row + j, c] = ids[at]
        row += size - 2


@compiled
def _plane(points: Floats, ids: Ints) -> tuple[Floats, Floats, float]:
    """Two coordinates of each corner, counterclockwise, and the rounding of twice an area; -1 for zero area."""
    size = len(ids)
    local = np.empty((size, 3))
    reach, extent = 0.0, 0.0
    for i in range(size):
        for c in range(3):
            local[i, c] = points[ids[i], c] - points[ids[0], c]
            reach = max(reach, abs(points[ids[i], c]))
            extent = max(extent, abs(local[i, c]))
    area = np.zeros(3)
    for i in range(1, size - 1):
        for c in range(3):
            p, q = (c + 1) % 3, (c + 2) % 3
            area[c] += local[i, p] * local[i + 1, q] - local[i, q] * local[i + 1, p]
    axis = 0
    for c in range(1, 3):
        if abs(area[c]) > abs(area[axis]):
            axis = c
    rounding = _ROUNDINGS * reach * extent
    x, y = local[:, (axis + 1) % 3].copy(), local[:, (axis + 2) % 3].copy()
    if area[axis] < 0:
        x, y = y, x
    return x, y, rounding if abs(area[axis]) > rounding else -1.0


@compiled
def _clip(x: Floats, y: Floats, rounding: float, triangles: Ints) -> bool:
    """Cut ears until one triangle is left; False if there are none before."""
    n = len(x)
    after, before = np.roll(np.arange(n), -1), np.roll(np.arange(n), 1)
    # The corners that are left, as a list by x, so that an ear is compared with those beside it only.
    order = np.argsort(x)
    right, left = np.full(n, -1), np.full(n, -1)
    right[order[:-1]], left[order[1:]] = order[1:], order[:-1]
    ring, queued = np.arange(n), np.ones(n, dtype=np.bool_)  # corners to test
    blocker = np.full(n, -1)  # a corner within the triangle at i
    gone = np.zeros(n, dtype=np.bool_)
    first, count, stage, row = 0, n, 0, 0
    while row < n - 3:
        if count == 0:
            woken = False
            for i in range(n):  # the list by x goes round no faster
                if not gone[i] and blocker[i] >= 0 and gone[blocker[i]]:
                    ring[(first + count) % n], queued[i], woken = i, True, True
                    count += 1
            if not woken:
                stage += 1
                if stage == len(_SHAPES):
                    return False
                for i in range(n):
                    if not gone[i]:
                        ring[(first + count) % n], queued[i] = i, True
                        count += 1
        i = ring[first]
        first, count, queued[i] = (first + 1) % n, count - 1, False
        a, c = before[i], after[i]
        if gone[i] or not _is_wide(x, y, rounding, a, i, c, _SHAPES[stage]):
            continue
        blocker[i] = _corner_within(x, y, rounding, a, i, c, right, left)
        if blocker[i] >= 0:
            continue
        triangles[row, 0], triangles[row, 1], triangles[row, 2] = a, i, c
        row += 1
        gone[i] = True
        after[a], before[c] = c, a
        if left[i] >= 0:
            right[left[i]] = right[i]
        if right[i] >= 0:
            left[right[i]] = left[i]
        for j in (a, c):
            blocker[j] = -1
            if not queued[j]:
                ring[(first + count) % n], queued[j] = j, True
                count += 1
    last = int(np.argmin(gone))
    a, c = before[last], after[last]
    triangles[row, 0], triangles[row, 1], triangles[row, 2] = a, last, c
    return _doubled_area(x, y, a, last, c) > rounding


@compiled
def _is_wide(x: Floats, y: Floats, rounding: float, a: int, b: int, c: int, shape: float) -> bool:
    """Whether a triangle is counterclockwise, and its height at least a share of its longest side."""
    longest = max((x[b] - x[a]) ** 2 + (y[b] - y[a]) ** 2, (x[c] - x[b]) ** 2 + (y[c] - y[b]) ** 2)
    longest = max(longest, (x[c] - x[a]) ** 2 + (y[c] - y[a]) ** 2)
    return _doubled_area(x, y, a, b, c) > max(rounding, shape * longest)


@compiled
def _corner_within(x: Floats, y: Floats, rounding: float, a: int, b: int, c: int, right: Ints, left: Ints) -> int:
    """A corner in or on a triangle, away from its own corners; -1 if there is none."""
    low, high = min(x[a], x[b], x[c]), max(x[a], x[b], x[c])
    bottom, top = min(y[a], y[b], y[c]), max(y[a], y[b], y[c])
    for links in (right, left):
        p = links[b]
        while p >= 0 and low <= x[p] <= high:
            if bottom <= y[p] <= top and _covers(x, y, rounding, a, b, c, p):
                return p
            p = links[p]
    return -1


@compiled
def _covers(x: Floats, y: Floats, rounding: float, a: int, b: int, c: int, p: int) -> bool:
    """Whether a triangle contains corner p, inside or on its boundary, away from its own corners."""
    for q in (a, b, c):
        if p == q or (x[p] == x[q] and y[p] == y[q]):
            return False
    return (
        _doubled_area(x, y, a, b, p) >= -rounding
        and _doubled_area(x, y, b, c, p) >= -rounding
        and _doubled_area(x, y, c, a, p) >= -rounding
    )


@compiled
def _doubled_area(x: Floats, y: Floats, a: int, b: int, c: int) -> float:
    return (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a])
