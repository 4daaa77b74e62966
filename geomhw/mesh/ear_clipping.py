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
    row = 0
    for k, (begin, size) in enumerate(zip(begins.tolist(), sizes.tolist(), strict=True)):
        ids = corners[begin : begin + size]
        x, y, rounding = _plane(points[ids])
        local = np.empty((size - 2, 3), dtype=np.int64)
        success[k] = rounding >= 0 and _clip(x, y, rounding, np.argsort(x, kind="stable"), local)
        if not success[k]:
            local = np.add.outer(np.arange(size - 2), [0, 1, 2])
            local[:, 0] = 0
        triangles[row : row + size - 2] = ids[local]
        row += size - 2
    return triangles, success


def _plane(points: Floats) -> tuple[Floats, Floats, float]:
    """Two coordinates of each corner, counterclockwise, and the rounding of twice an area; -1 for zero area."""
    local = points - points[0]
    area = np.cross(local[1:-1], local[2:]).sum(axis=0)
    axis = int(np.abs(area).argmax())
    rounding = _ROUNDINGS * float(np.abs(points).max()) * float(np.abs(local).max())
    x, y = (np.ascontiguousarray(local[:, (axis + k) % 3]) for k in (1, 2))
    if area[axis] < 0:
        x, y = y, x
    return x, y, rounding if abs(area[axis]) > rounding else -1.0


@compiled
def _clip(x: Floats, y: Floats, rounding: float, order: Ints, triangles: Ints) -> bool:
    """Cut ears until one triangle is left; False if there are none before. order: of the corners by x."""
    n = len(x)
    after, before, ring = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
    # The corners that are left, as a list by x, so that an ear is compared with those beside it only.
    right, left = np.empty(n, np.int64), np.empty(n, np.int64)
    blocker = np.empty(n, np.int64)  # a corner within the triangle at i
    gone, queued = np.zeros(n, np.bool_), np.ones(n, np.bool_)
    for i in range(n):
        after[i], before[i], ring[i], blocker[i] = (i + 1) % n, (i - 1) % n, i, -1
        right[order[i]] = order[i + 1] if i + 1 < n else -1
        left[order[i]] = order[i - 1] if i > 0 else -1
    first, count, stage, row = 0, n, 0, 0  # of the ring of corners to test
    while row < n - 3:
        if count == 0:
            for i in range(n):
                if not gone[i] and blocker[i] >= 0 and gone[blocker[i]]:
                    ring[(first + count) % n], queued[i] = i, True
                    count += 1
            if count == 0:
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
    last = 0
    while gone[last]:
        last += 1
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
