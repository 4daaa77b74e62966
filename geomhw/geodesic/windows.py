"""Windows over an edge: records in a pool, and sorted lists that keep the shortest window at each point of the edge.

A window is an interval of an edge that straight lines from one point reach, in the plane of the unfolded faces between.
The point is a source, or a vertex at which paths turn. Coordinates start at the lower vertex of the edge: x along the
edge, y the height of the point over it. Lists are linked through ``next``. Record 0 heads a list; it is no window.

Where y is negative, parallel lines perpendicular to a source edge reach the window. Then (x, -y) is their direction, a
unit vector, and ``offset`` the distance at the lower vertex. Along the edge the distance is offset + x t.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
"""

from math import sqrt
from typing import Any

import numpy as np

from geomhw.arrays import Ints
from geomhw.compiled import compiled_in_place

#: ``offset`` is the distance of the point from the sources; ``origin`` its vertex, or -1-k for source point k;
#: ``crossed`` the number of faces between; ``passed`` whether the window has been propagated across its face.
WINDOW = np.dtype(
    [(name, np.float64) for name in ("left", "right", "x", "y", "offset", "split")]
    + [(name, np.int32) for name in ("next", "origin", "crossed", "passed")],
    align=True,
)
#: Distances, lengths and places that agree up to this share are equal; each face crossed adds to it by rounding.
TIE, TIE_PER_FACE = 1e-14, 1e-16
#: ``next`` of a record that is in no list.
UNLINKED = -1
#: Places in ``counts``: first released record, largest record in use, number of records in use.
RELEASED, LAST, IN_USE = 0, 1, 2


@compiled_in_place
def allocate(windows: Any, counts: Ints, like: int) -> int:
    """Return a new record, a copy of another."""
    i = counts[RELEASED]
    if i:
        counts[RELEASED] = windows[i].next
    else:
        counts[LAST] += 1
        i = counts[LAST]
        if i == len(windows):
            raise MemoryError("more windows over one edge than the pool has room for")
    counts[IN_USE] += 1
    windows[i] = windows[like]
    windows[i].next = UNLINKED
    return i


@compiled_in_place
def release(windows: Any, counts: Ints, i: int) -> None:
    """Return a record to the pool."""
    windows[i].next = counts[RELEASED]
    counts[RELEASED] = i
    counts[IN_USE] -= 1


@compiled_in_place
def tolerance(window: Any) -> float:
    """Share up to which a length through a window is known."""
    return TIE + TIE_PER_FACE * window.crossed


@compiled_in_place
def length_to(window: Any, t: float) -> float:
    """Length of the path through a window to the place t on its edge."""
    if window.y < 0:
        return window.offset + window.x * t
    return window.offset + sqrt((t - window.x) ** 2 + window.y**2)


@compiled_in_place
def least_length(window: Any, x: float, y: float) -> float:
    """Lower bound of the lengths through a window to the point (x, y) on the other side; the length if straight."""
    if window.y < 0:
        return window.offset + window.x * x - window.y * y
    return window.offset + sqrt((x - window.x) ** 2 + (y + window.y) ** 2)


@compiled_in_place
def trim(window: Any, d_low: float, d_high: float, base: float) -> float:
    """Cut a window, in place, where a path along the edge from an end is shorter [Xin and Wang 2009, sec. 3.2].

    Return the least distance at the window, -1 where nothing is left. base: the edge length.
    """
    left, right, x, y = window.left, window.right, window.x, window.y
    if y < 0:
        return _trim_parallel(window, d_low, d_high, base)
    # Lengths from the two ends and at the window, less the offset.
    low, high, h = d_low - window.offset, d_high - window.offset, y * y
    share = (1 - tolerance(window)) ** 2
    at_left, at_right = ((left - x) ** 2 + h) * share, ((right - x) ** 2 + h) * share
    if _is_less(low + right, at_right) or _is_less(high + (base - left), at_left):
        return -1.0
    # t + D = |(t - x, y)|, at which both are equally long, is linear in t.
    if _is_less(low + left, at_left):
        left = min(max(left, (x * x + h - low * low) / (2 * (low + x))), right)
    if _is_less(high + (base - right), at_right):
        u = base - x
        right = max(min(right, base - (u * u + h - high * high) / (2 * (high + u))), left)
    window.left, window.right = left, right
    if not right - left > TIE * base:
        return -1.0
    return window.offset + y if left <= x <= right else length_to(window, left if x < left else right)


@compiled_in_place
def _trim_parallel(window: Any, d_low: float, d_high: float, base: float) -> float:
    """Cut a window of parallel lines as `trim` does."""
    left, right, low, high = window.left, window.right, d_low, d_high + base
    share = 1 - tolerance(window)
    at_left, at_right = length_to(window, left) * share, length_to(window, right) * share
    if low + right < at_right or high - left < at_left:
        return -1.0
    if low + left < at_left:
        left = min(left + (at_left - low - left) / (1 - window.x), right)
    if high - right < at_right:
        right = max(right - (at_right - high + right) / (1 + window.x), left)
    window.left, window.right = left, right
    least = max(min(length_to(window, left), length_to(window, right)), 0.0)
    return least if right - left > TIE * base else -1.0


@compiled_in_place
def _is_less(length: float, square: float) -> bool:
    """Whether a length is less than the root of a square."""
    return length < 0 or length * length < square


@compiled_in_place
def insert(windows: Any, counts: Ints, new: int, start: int) -> int:
    """Insert a window into a list of disjoint windows, which keeps the shortest at each point: their lower envelope.

    start: a record of the list before the window, or 0. Return the last record before the window, from which the search
    for the next window further right may start. Of equal lengths, the longer straight line stays, because a window from
    a vertex beside it may end where the straight line continues. Otherwise the old window stays, so that inserting the
    same window twice adds nothing.
    """
    t, stop = windows[new].left, windows[new].right
    if start and windows[start].right > t:
        start = 0
    old = windows[start].next
    while old > 0 and windows[old].right <= t:
        start = old
        old = windows[old].next
    windows[new].next = UNLINKED
    # The sweep is at t. ``best`` is the shortest window since ``begin``, not yet in the list, which ends at ``tail``.
    tail, best, begin, end = start, new, t, stop
    while old > 0 and windows[old].left < stop:
        following, low, high = windows[old].next, windows[old].left, windows[old].right
        windows[old].next = UNLINKED
        if low < t:
            best, begin = old, low
        elif low > t:
            if best != new:
                tail = _link(windows, counts, tail, best, begin, t)
                best, begin = new, t
            t = low
        end = min(high, stop)
        gain, gain_end, middle = _gain(windows, new, old, t), _gain(windows, new, old, end), end
        if gain * gain_end > 0 and not _have_one_offset(windows[new], windows[old]):
            middle = _turning_point(windows[new], windows[old], t, end)
        while True:
            gain_middle = _gain(windows, new, old, middle) if middle < end else gain_end
            shorter = new if gain < 0 else old
            if shorter != best:
                if begin < t:
                    tail = _link(windows, counts, tail, best, begin, t)
                best, begin = shorter, t
            if (gain < 0) != (gain_middle < 0):
                t = _crossing(windows, new, old, t, middle)
                tail = _link(windows, counts, tail, best, begin, t)
                best, begin = new if gain_middle < 0 else old, t
            t, gain = middle, gain_middle
            if t == end:
                break
            middle = end
        if end < high and best != old:
            tail = _link(windows, counts, tail, best, begin, end)
            best, begin = old, end
        t, end = end, high
        if best != old and windows[old].next == UNLINKED:
            release(windows, counts, old)
        old = following
    if t < stop and best != new:
        tail = _link(windows, counts, tail, best, begin, t)
        best, begin = new, t
    tail = _link(windows, counts, tail, best, begin, stop if best == new else end)
    windows[tail].next = old
    if windows[new].next == UNLINKED:
        release(windows, counts, new)
    return start


@compiled_in_place
def _link(windows: Any, counts: Ints, tail: int, window: int, left: float, right: float) -> int:
    """Append the interval of a window to the list that ends at ``tail``, in a copy if the record is in use."""
    i = window
    if windows[i].next != UNLINKED:
        i = allocate(windows, counts, window)
    windows[i].left, windows[i].right, windows[i].next = left, right, 0
    windows[tail].next = i
    return i


@compiled_in_place
def _gain(windows: Any, new: int, old: int, t: float) -> float:
    """Length through one window less that through another, or the difference of their squares if this has its sign.

    It is negative where the first is shorter, or equal up to rounding with a longer straight line.
    """
    a, b = windows[new], windows[old]
    tie = max(tolerance(a), tolerance(b))
    if _have_one_offset(a, b):
        square = (t - a.x) ** 2 + a.y**2
        return square * (1 + 2 * tie) - ((t - b.x) ** 2 + b.y**2)
    d = length_to(a, t)
    gain = d - length_to(b, t)
    return gain - tie * d if a.offset < b.offset else gain + tie * d


@compiled_in_place
def _have_one_offset(a: Any, b: Any) -> bool:
    """Whether two windows of points have the same offset, so that the difference of squared lengths is linear."""
    return a.offset == b.offset and a.y >= 0 and b.y >= 0


@compiled_in_place
def _turning_point(a: Any, b: Any, low: float, high: float) -> float:
    """Place in low to high where the difference of two lengths is extreme, or high.

    It is on the line of both points, or where a line from one point is parallel to the other lines.
    """
    t = high
    if a.y < 0 or b.y < 0:
        if a.y >= 0:
            t = a.x - a.y * b.x / b.y
        elif b.y >= 0:
            t = b.x - b.y * a.x / a.y
    elif a.y != b.y:
        t = (a.x * b.y - b.x * a.y) / (b.y - a.y)
    return t if low < t < high else high


@compiled_in_place
def _crossing(windows: Any, new: int, old: int, low: float, high: float) -> float:
    """Place between low and high where two lengths are equal, if their difference changes sign once between them."""
    a, b = windows[new], windows[old]
    if _have_one_offset(a, b):
        c = b.x - a.x
        return min(max(b.x - (c + (a.y - b.y) * (a.y + b.y) / c) / 2, low), high) if c != 0 else low
    if a.y >= 0 and b.y >= 0:
        c, D = b.x - a.x, b.offset - a.offset
        k = ((c - D) * (c + D) + (a.y - b.y) * (a.y + b.y)) / 2
        # With u = t - b.x: c u + k = D |(u, b.y)|; squared, A u² + 2 c k u + (k² - D² b.y²) = 0.
        A = (c - D) * (c + D)
        root = abs(D) * sqrt(max(k * k + b.y * b.y * A, 0.0))
        q = -c * k + root if c * k < 0 else -c * k - root
        for u in (q / A, (k - D * b.y) * (k + D * b.y) / q):
            t = min(max(b.x + u, low), high)
            if abs(_gain(windows, new, old, t)) <= 4 * max(tolerance(a), tolerance(b)) * length_to(a, t):
                return t
    falls, t = _gain(windows, new, old, high) < 0, (low + high) / 2
    while low < t < high:  # both roots are inaccurate, or lines are parallel
        if (_gain(windows, new, old, t) < 0) == falls:
            high = t
        else:
            low = t
        t = (low + high) / 2
    return t
