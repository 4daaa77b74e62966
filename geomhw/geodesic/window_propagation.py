"""Propagation of windows over a mesh, from face to face in the order of distance.

Halfedge 3f+k is the side of face f opposite its corner k; windows in its list wait there to cross the face. One event
propagates the whole list of a halfedge: lists are sorted, so their children are too, and merge in linear time. A window
is trimmed against the vertices at the ends of its edge and against the windows that wait with it, and then forgotten.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
Xin, Wang: Improving Chen and Han's Algorithm on the Discrete Geodesic Problem. ACM Trans. Graph. 28(4), 2009.
Qin, Han, Yu, Yu, Zhang: Fast and Exact Discrete Geodesic Computation Based on Triangle-Oriented Wavefront Propagation.
ACM Trans. Graph. 35(4), 2016.
"""

from math import atan2, inf, pi, sqrt
from typing import Any, NamedTuple

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.windows import IN_USE, TIE, allocate, insert, length_to, release, trim

#: Place in ``counts``, after those of `windows`: number of events in the queue.
WAITING = 3
#: From this many events of one halfedge on, its windows stay in the list after they have crossed: what comes round again
#: ends there, and so does every loop over faces without area.
PATIENCE = 8
#: A vertex with a larger angle, in radians over 2π, is a saddle.
FLAT = 1e-13
#: Windows of one origin whose points agree up to this share are pieces of one.
SAME = 1e-13
#: Kinds of vertices: paths pass only beside it; paths turn at it. 0 where not yet known.
CONVEX, TURNING = 1, 2


class Surface(NamedTuple):
    """A mesh as the front walks it.

    points (n, 3), faces (m, 3). across: (3m,), the next halfedge round the same edge, itself on the boundary. corners:
    halfedges opposite each vertex, those of v at ``starts[v]`` to ``starts[v + 1]``. kinds: (n,), filled on the way.
    sides: faces that meet in one edge, at most.
    """

    points: Floats
    faces: Ints
    across: Ints
    corners: Ints
    starts: Ints
    kinds: Ints
    sides: int


class Front(NamedTuple):
    """State of one query: what has arrived at vertices, windows on their way, and the queue of events.

    distance, origin, halfedge, entry: (n,), as in `Arrivals`. waiting: (3m,), first window of each list. events: (3m,),
    how often each halfedge has been propagated. keys, items: the queue, a binary heap; places: (3m+n+k,), one more than
    the place of each item there. Item h < 3m is a halfedge, 3m+v a vertex, 3m+n+i source point i.
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


class Triangle(NamedTuple):
    """A face seen from one side: its vertices, the other two halfedges, and lengths and angles at the base."""

    low: int
    high: int
    apex: int
    at_low: int
    at_high: int
    base: float
    left: float
    right: float
    cos_low: float
    sin_low: float
    cos_high: float
    sin_high: float


@compiled_in_place
def propagate(surface: Surface, front: Front, places: Floats, faces: Ints, limit: float, targets: Ints) -> float:
    """Process events up to the limit or until all targets are final; return the radius up to which distances are.

    Return -1 when the pool needs more room; call again then. places, faces: (k, 3) and (k,), source points in faces.
    """
    n, h, reached = len(front.distance), len(front.waiting), 0
    while front.counts[WAITING]:
        item, key = front.items[0], front.keys[0]
        while reached < len(targets) and front.distance[targets[reached]] <= key:
            reached += 1
        if 0 < len(targets) == reached:
            return key
        if 8 * (front.counts[IN_USE] + 2 * surface.sides * _size(surface, front, item)) > len(front.windows) - 64:
            return -1.0
        _pop(front)
        if item < h:
            _cross_face(surface, front, item, limit)
        elif item < h + n:
            v = item - h
            for k in range(surface.starts[v], surface.starts[v + 1]):
                _emit(surface, front, surface.corners[k], surface.points[v], front.distance[v], v, limit)
        else:
            i = item - h - n
            for k in range(3):
                _emit(surface, front, 3 * faces[i] + k, places[i], 0.0, -1 - i, limit)
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
def _emit(surface: Surface, front: Front, h: int, place: Floats, d: float, origin: int, limit: float) -> None:
    """Send one window from a point of a face out over halfedge h, and reach the ends of that."""
    low, high = _ends(surface, h)
    p, q, r = surface.points[low], surface.points[high], place
    ex, ey, ez, rx, ry, rz = q[0] - p[0], q[1] - p[1], q[2] - p[2], r[0] - p[0], r[1] - p[1], r[2] - p[2]
    base, along = sqrt(ex * ex + ey * ey + ez * ez), ex * rx + ey * ry + ez * rz
    cross = sqrt((ey * rz - ez * ry) ** 2 + (ez * rx - ex * rz) ** 2 + (ex * ry - ey * rx) ** 2)
    _reach(surface, front, low, d + sqrt(rx * rx + ry * ry + rz * rz), origin, -1, 0.0, limit)
    far = sqrt((r[0] - q[0]) ** 2 + (r[1] - q[1]) ** 2 + (r[2] - q[2]) ** 2)
    _reach(surface, front, high, d + far, origin, -1, 0.0, limit)
    if base > 0 and (cross > 0 or 0 < along < base * base):
        i = allocate(front.windows, front.counts, 0)
        w = front.windows[i]
        w.left, w.right, w.x, w.y, w.offset = 0.0, base, along / base, cross / base, d
        w.next, w.origin, w.passed = 0, origin, 0
        _deliver(surface, front, h, i, base, limit)


@compiled_in_place
def _cross_face(surface: Surface, front: Front, h: int, limit: float) -> None:
    """Propagate all windows that wait at a halfedge across its face: update the apex, then fill the other two sides."""
    windows, face = front.windows, _triangle(surface, h)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    first = i = front.waiting[h]
    while i:
        w = windows[i]
        while w.next and _continues(w, windows[w.next], face.base):
            j = w.next
            w.right, w.next = windows[j].right, windows[j].next
            release(windows, front.counts, j)
        if not w.passed and w.offset + sqrt((x - w.x) ** 2 + (y + w.y) ** 2) < front.distance[face.apex]:
            t = min(max(_split(w.x, w.y, x, y), w.left), w.right)
            d = length_to(w, t) + sqrt((x - t) ** 2 + y * y)
            _reach(surface, front, face.apex, d, w.origin, h, t, limit)
        i = w.next
    at_low = _children(
        windows, front.counts, first, face.base, face.left, face.cos_low, face.sin_low, False, face.low > face.apex
    )
    at_high = _children(
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
def _continues(a: Any, b: Any, base: float) -> bool:
    """Whether window b goes on where a ends, from the same point: paths on both sides of a flat vertex."""
    far = abs(a.x) + a.y
    return (
        a.origin == b.origin
        and a.offset == b.offset
        and a.passed == b.passed
        and b.left - a.right <= SAME * base
        and abs(a.x - b.x) + abs(a.y - b.y) <= min(SAME * far, 1e-6 * (b.right - b.left) * a.y / far)
    )


@compiled_in_place
def _split(x: float, y: float, apex_x: float, apex_y: float) -> float:
    """Place where the line from (x, -y) to the apex crosses the base."""
    return x + (apex_x - x) * y / (y + apex_y) if y + apex_y > 0 else apex_x


@compiled_in_place
def _children(
    windows: Any, counts: Ints, i: int, base: float, side: float, cos: float, sin: float, mirrored: bool, flipped: bool
) -> int:
    """List of the windows on one side of the triangle, from the list i on its base, in the order of the side's points.

    The side leaves the base's lower end, or the higher if mirrored, at an angle. flipped: whether the apex is the side's
    lower vertex.
    """
    first = last = 0
    while i:
        w = windows[i]
        left, right, x, y = w.left, w.right, w.x, w.y
        if mirrored:
            left, right, x = base - right, base - left, base - x
        split = _split(x, y, side * cos, side * sin)
        if not w.passed and left < split:
            height, foot = x * sin + y * cos, x * cos - y * sin
            low = _image(left, y, height, sin, side)
            high = side if right >= split else _image(right, y, height, sin, side)
            if low < high and (height > 0 or 0 < foot < side):
                j = allocate(windows, counts, i)
                if flipped:
                    low, high, foot = side - high, side - low, side - foot
                child = windows[j]
                child.left, child.right, child.x, child.y, child.next = low, high, foot, height, 0
                if first == 0:
                    first = j
                elif flipped != mirrored:
                    child.next, first = first, j
                else:
                    windows[last].next = j
                if child.next == 0:
                    last = j
        i = w.next
    return first


@compiled_in_place
def _image(t: float, y: float, height: float, sin: float, side: float) -> float:
    """Place on a side of the triangle where the ray through t on the base arrives, at most its length."""
    ahead = height - t * sin
    return min(t * y / ahead, side) if ahead > 0 else (side if t > 0 else 0.0)


@compiled_in_place
def _deliver(surface: Surface, front: Front, h: int, i: int, base: float, limit: float) -> None:
    """Pass a list of windows on from halfedge h of the face that they leave to all other faces at its edge."""
    windows, counts = front.windows, front.counts
    low, high = _ends(surface, h)
    first, last, least, g = 0, 0, inf, surface.across[h]
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
        copied, start, i = surface.across[g] != h, 0, first
        windows[0].next = front.waiting[g]
        while i:
            following = windows[i].next
            start = insert(windows, counts, allocate(windows, counts, i) if copied else i, start)
            i = following
        front.waiting[g] = windows[0].next
        _push(front, g, least)
        g = surface.across[g]


@compiled_in_place
def _reach(
    surface: Surface, front: Front, v: int, d: float, origin: int, halfedge: int, entry: float, limit: float
) -> None:
    """Give a vertex a shorter distance; it becomes an event if paths may turn there."""
    if d < front.distance[v] * (1 - TIE) and d <= limit:
        front.distance[v], front.origin[v], front.halfedge[v], front.entry[v] = d, origin, halfedge, entry
        if surface.kinds[v] == 0:
            surface.kinds[v] = TURNING if _turns(surface, v) else CONVEX
        if surface.kinds[v] == TURNING:
            _push(front, len(front.waiting) + v, d)


@compiled_in_place
def _turns(surface: Surface, v: int) -> bool:
    """Whether shortest paths may turn at a vertex: unless its faces are one closed fan of angle at most 2π."""
    h = first = surface.corners[surface.starts[v]]
    out = _triangle(surface, h).at_low
    angle = 0.0
    for count in range(surface.starts[v + 1] - surface.starts[v]):
        face = _triangle(surface, h)
        if count > 0 and h == first:
            return True
        angle += pi - atan2(face.sin_low, face.cos_low) - atan2(face.sin_high, face.cos_high)
        g = surface.across[out]
        if g == out or surface.across[g] != out or face.left == 0 or face.right == 0:
            return True
        h = g // 3 * 3
        while surface.faces[h // 3, h % 3] != v:
            h += 1
        face = _triangle(surface, h)
        out = face.at_high if g == face.at_low else face.at_low
    return angle > 2 * pi + FLAT


@compiled_in_place
def _ends(surface: Surface, h: int) -> tuple[int, int]:
    """Lower and higher vertex of a halfedge."""
    f, k = h // 3, h % 3
    a, b = surface.faces[f, (k + 1) % 3], surface.faces[f, (k + 2) % 3]
    return min(a, b), max(a, b)


@compiled_in_place
def _triangle(surface: Surface, h: int) -> Triangle:
    """Lay out a face over its halfedge h; angles at an edge of length zero are 0."""
    f, k = h // 3, h % 3
    i, j = (k + 1) % 3, (k + 2) % 3
    if surface.faces[f, i] > surface.faces[f, j]:
        i, j = j, i
    low, high, apex = surface.faces[f, i], surface.faces[f, j], surface.faces[f, k]
    p, q, r = surface.points[low], surface.points[high], surface.points[apex]
    ex, ey, ez, lx, ly, lz = q[0] - p[0], q[1] - p[1], q[2] - p[2], r[0] - p[0], r[1] - p[1], r[2] - p[2]
    rx, ry, rz = r[0] - q[0], r[1] - q[1], r[2] - q[2]
    base, left, right = (
        sqrt(ex * ex + ey * ey + ez * ez),
        sqrt(lx * lx + ly * ly + lz * lz),
        sqrt(rx * rx + ry * ry + rz * rz),
    )
    area = sqrt((ey * lz - ez * ly) ** 2 + (ez * lx - ex * lz) ** 2 + (ex * ly - ey * lx) ** 2)
    cos_low = cos_high = 1.0
    sin_low = sin_high = 0.0
    if base * left > 0:
        cos_low, sin_low = (ex * lx + ey * ly + ez * lz) / (base * left), area / (base * left)
    if base * right > 0:
        cos_high, sin_high = -(ex * rx + ey * ry + ez * rz) / (base * right), area / (base * right)
    return Triangle(low, high, apex, 3 * f + j, 3 * f + i, base, left, right, cos_low, sin_low, cos_high, sin_high)


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
