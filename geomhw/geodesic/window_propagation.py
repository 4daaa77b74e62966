"""Propagation of windows over a mesh, from face to face in the order of distance.

Windows in the list of a halfedge wait there to cross the face. One event propagates the whole list of a halfedge. Lists
are sorted, so their images are too, and merge in linear time. A window is cut where paths from the ends of its edge are
shorter, and compared with the windows in its list. It is released once it has crossed.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
Xin, Wang: Improving Chen and Han's Algorithm on the Discrete Geodesic Problem. ACM Trans. Graph. 28(4), 2009.
Qin, Han, Yu, Yu, Zhang: Fast and Exact Discrete Geodesic Computation Based on Triangle-Oriented Wavefront Propagation.
ACM Trans. Graph. 35(4), 2016.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.unfolded_faces import CONVEX, TURNING, Surface, ends, is_turning, triangle
from geomhw.geodesic.window_images import above_line, continues, crossing_to, images
from geomhw.geodesic.windows import IN_USE, LAST, TIE, WINDOW, allocate, insert, length_to, release, trim

#: Places in ``counts``, after those of `windows`: number of events in the queue, and of items in ``touched``.
WAITING, TOUCHED = 3, 4
#: From this number of events of one halfedge on, its windows stay in the list after they have crossed. A window that
#: returns there, for example round faces of zero area, is then no shorter than those in the list and ends.
PATIENCE = 8
#: Initial number of window records.
ROOM = 4096


class Front(NamedTuple):
    """State of one query: arrivals at vertices, windows, and the queue of events.

    distance, origin, halfedge, entry: (n,), as in `Arrivals`. waiting: (3m,), first window of each list. events: (3m,),
    how often each halfedge has been propagated. keys, items: the queue, a binary heap; places: (3m+n+k,), one more than
    the place of each item there. Item h < 3m is a halfedge, 3m+v a vertex, 3m+n+i source point i. touched: (3m+n,),
    halfedges and vertices whose state has changed, as items.
    """

    distance: Floats
    origin: Ints
    halfedge: Ints
    entry: Floats
    waiting: Ints
    events: Ints
    windows: Any
    counts: Ints
    keys: Floats
    items: Ints
    places: Ints
    touched: Ints


def empty_front(surface: Surface, k: int = 0) -> Front:
    """Return a front without sources, with room for k source points. Most memory is used only once it is written to."""
    n, h = len(surface.points), surface.faces.size
    return Front(
        np.full(n, inf),
        np.empty(n, dtype=np.int32),
        np.empty(n, dtype=np.int32),
        np.empty(n),
        np.zeros(h, dtype=np.int32),
        np.zeros(h, dtype=np.int32),
        np.zeros(ROOM, dtype=WINDOW),
        np.zeros(5, dtype=np.int64),
        np.empty(h + n + k),
        np.empty(h + n + k, dtype=np.int32),
        np.zeros(h + n + k, dtype=np.int32),
        np.empty(h + n, dtype=np.int32),
    )


def with_more_room(front: Front) -> Front:
    """Return the front with twice as many window records."""
    windows = np.empty(2 * len(front.windows), dtype=WINDOW)
    used = front.counts[LAST] + 1
    windows[:used] = front.windows[:used]
    return front._replace(windows=windows)


def reached(front: Front) -> Ints:
    """Return the vertices with a distance, in the order in which they were first reached."""
    items = front.touched[: front.counts[TOUCHED]]
    vertices: Ints = items[items >= len(front.waiting)] - len(front.waiting)
    return vertices


@compiled_in_place
def start(front: Front, vertices: Ints, k: int) -> None:
    """Add sources to a front: vertices, and source points 0 to k-1."""
    h, n = len(front.waiting), len(front.distance)
    for v in vertices:
        if front.distance[v] > 0:
            _touch(front, h + v)
            front.distance[v], front.origin[v], front.halfedge[v], front.entry[v] = 0.0, v, -1, 0.0
            _push(front, h + v, 0.0)
    for i in range(k):
        _push(front, h + n + i, 0.0)


@compiled_in_place
def reset(front: Front) -> None:
    """Remove sources, arrivals and windows; the time is proportional to their number."""
    h = len(front.waiting)
    for i in front.touched[: front.counts[TOUCHED]]:
        if i < h:
            front.waiting[i] = front.events[i] = 0
        else:
            front.distance[i - h] = inf
    for i in front.items[: front.counts[WAITING]]:
        front.places[i] = 0
    front.counts[:] = 0


@compiled_in_place
def propagate(surface: Surface, front: Front, places: Floats, faces: Ints, limit: float, targets: Ints) -> float:
    """Process events up to the limit or until all targets are final; return the radius of final distances.

    Return -1 if more room for windows is needed before the next call. places, faces: (k, 3) and (k,), source points.
    """
    n, h, done = len(front.distance), len(front.waiting), 0
    while front.counts[WAITING]:
        item, key = np.int64(front.items[0]), front.keys[0]
        while done < len(targets) and front.distance[targets[done]] <= key:
            done += 1
        if 0 < len(targets) == done:
            return key
        if 8 * (front.counts[IN_USE] + 2 * surface.sides * _size(surface, front, item)) > len(front.windows) - 64:
            return -1.0
        _pop(front)
        if item < h:
            _cross_face(surface, front, item, limit)
        elif item < h + n:
            v = item - h
            for k in range(surface.starts[v], surface.starts[v + 1]):
                x, y, z = surface.points[v]
                _emit(surface, front, np.int64(surface.corners[k]), x, y, z, front.distance[v], v, limit)
        else:
            i = item - h - n
            for k in range(3):
                x, y, z = places[i]
                _emit(surface, front, 3 * np.int64(faces[i]) + k, x, y, z, 0.0, -1 - i, limit)
    return limit


@compiled_in_place
def _size(surface: Surface, front: Front, item: int) -> int:
    """Number of windows that an event propagates."""
    if item >= len(front.waiting):
        v = item - len(front.waiting)
        return surface.starts[v + 1] - surface.starts[v] if v < len(front.distance) else 3
    count, i = 0, front.waiting[item]
    while i:
        count += 1
        i = front.windows[i].next
    return count


@compiled_in_place
def _emit(
    surface: Surface, front: Front, h: int, x: float, y: float, z: float, d: float, origin: int, limit: float
) -> None:
    """Send one window from a point (x, y, z) of a face over its halfedge h, and reach the ends of the halfedge."""
    low, high = ends(surface, h)
    p, q = surface.points[low], surface.points[high]
    ex, ey, ez, rx, ry, rz = q[0] - p[0], q[1] - p[1], q[2] - p[2], x - p[0], y - p[1], z - p[2]
    base, along = sqrt(ex * ex + ey * ey + ez * ez), ex * rx + ey * ry + ez * rz
    cross = sqrt((ey * rz - ez * ry) ** 2 + (ez * rx - ex * rz) ** 2 + (ex * ry - ey * rx) ** 2)
    _reach(surface, front, low, d + sqrt(rx * rx + ry * ry + rz * rz), origin, -1, 0.0, limit)
    far = sqrt((x - q[0]) ** 2 + (y - q[1]) ** 2 + (z - q[2]) ** 2)
    _reach(surface, front, high, d + far, origin, -1, 0.0, limit)
    if base > 0 and (cross > 0 or 0 < along < base * base):
        i = allocate(front.windows, front.counts, 0)
        w = front.windows[i]
        w.left, w.right, w.x, w.offset = 0.0, base, along / base, d
        w.y = above_line(cross / base, w.x, base)
        w.next, w.origin, w.passed = 0, origin, 0
        _deliver(surface, front, h, i, base, limit)


@compiled_in_place
def _cross_face(surface: Surface, front: Front, h: int, limit: float) -> None:
    """Propagate the windows in the list of a halfedge across its face, to the apex and over the other two sides."""
    windows, face = front.windows, triangle(surface, h)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    first = i = np.int64(front.waiting[h])
    while i:
        w = windows[i]
        while w.next and continues(w, windows[w.next], face.base):
            j = w.next
            w.right, w.next = windows[j].right, windows[j].next
            release(windows, front.counts, j)
        if not w.passed and w.offset + sqrt((x - w.x) ** 2 + (y + w.y) ** 2) < front.distance[face.apex]:
            t = min(max(crossing_to(w.x, w.y, x, y), w.left), w.right)
            d = length_to(w, t) + sqrt((x - t) ** 2 + y * y)
            _reach(surface, front, face.apex, d, w.origin, h, t, limit)
        i = w.next
    at_low = images(
        windows, front.counts, first, face.base, face.left, face.cos_low, face.sin_low, False, face.low > face.apex
    )
    at_high = images(
        windows, front.counts, first, face.base, face.right, face.cos_high, face.sin_high, True, face.high > face.apex
    )
    front.events[h] += 1
    keep = front.events[h] > PATIENCE
    front.waiting[h] = first if keep else 0
    i = first
    while i:
        following = windows[i].next
        windows[i].passed = 1
        if not keep:
            release(windows, front.counts, i)
        i = following
    if at_low:
        _deliver(surface, front, face.at_low, at_low, face.left, limit)
    if at_high:
        _deliver(surface, front, face.at_high, at_high, face.right, limit)


@compiled_in_place
def _deliver(surface: Surface, front: Front, h: int, i: int, base: float, limit: float) -> None:
    """Insert the windows of a list, which leave a face over its halfedge h, at all other faces of the edge."""
    windows, counts = front.windows, front.counts
    low, high = ends(surface, h)
    first, last, least, g = 0, 0, inf, np.int64(surface.across[h])
    while i:
        following = windows[i].next
        d = trim(windows[i], front.distance[low], front.distance[high], base) if g != h else -1.0
        if 0 <= d <= limit:
            least = min(least, d)
            if first == 0:
                first = i
            else:
                windows[last].next = i
            last = i
            windows[i].next = 0
        else:
            release(windows, counts, i)
        i = following
    while first and g != h:
        copied, before, i = surface.across[g] != h, 0, first
        if front.waiting[g] == 0 and front.events[g] == 0:
            _touch(front, g)
        windows[0].next = front.waiting[g]
        while i:
            following = windows[i].next
            before = insert(windows, counts, allocate(windows, counts, i) if copied else i, before)
            i = following
        front.waiting[g] = windows[0].next
        _push(front, g, least)
        g = np.int64(surface.across[g])


@compiled_in_place
def _reach(
    surface: Surface, front: Front, v: int, d: float, origin: int, halfedge: int, entry: float, limit: float
) -> None:
    """Set the distance of a vertex if it becomes shorter; the vertex becomes an event if paths may turn there."""
    if d < front.distance[v] * (1 - TIE) and d <= limit:
        if front.distance[v] == inf:
            _touch(front, len(front.waiting) + v)
        front.distance[v], front.origin[v], front.halfedge[v], front.entry[v] = d, origin, halfedge, entry
        if surface.kinds[v] == 0:
            surface.kinds[v] = TURNING if is_turning(surface, v) else CONVEX
        if surface.kinds[v] == TURNING:
            _push(front, len(front.waiting) + v, d)


@compiled_in_place
def _touch(front: Front, item: int) -> None:
    """Note that the state of an item has changed."""
    front.touched[front.counts[TOUCHED]] = item
    front.counts[TOUCHED] += 1


@compiled_in_place
def _push(front: Front, item: int, key: float) -> None:
    """Put an item into the queue, or move it forward."""
    keys, items, places = front.keys, front.items, front.places
    p = places[item] - 1
    if p < 0:
        p = front.counts[WAITING]
        front.counts[WAITING] += 1
    elif key >= keys[p]:
        return
    while p > 0 and keys[(p - 1) // 2] > key:
        up = (p - 1) // 2
        keys[p], items[p] = keys[up], items[up]
        places[items[p]] = p + 1
        p = up
    keys[p], items[p], places[item] = key, item, p + 1


@compiled_in_place
def _pop(front: Front) -> None:
    """Remove the item of the least key from the queue."""
    keys, items, places = front.keys, front.items, front.places
    places[items[0]] = 0
    front.counts[WAITING] -= 1
    size, p = front.counts[WAITING], 0
    while size > 0:
        down = 2 * p + 1
        if down + 1 < size and keys[down + 1] < keys[down]:
            down += 1
        if down >= size or keys[down] >= keys[size]:
            keys[p], items[p] = keys[size], items[size]
            places[items[p]] = p + 1
            return
        keys[p], items[p] = keys[down], items[down]
        places[items[p]] = p + 1
        p = down
