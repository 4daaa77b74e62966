"""Propagation of windows over a mesh, from face to face in the order of distance.

Windows in the list of a halfedge wait there to cross the face. One event propagates the whole list of a halfedge. Lists
are sorted, so their images are too, and merge in linear time. A window is cut where paths from the ends of its edge are
shorter, and compared with the windows in its list. It is released once it has crossed.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
Xin, Wang: Improving Chen and Han's Algorithm on the Discrete Geodesic Problem. ACM Trans. Graph. 28(4), 2009.
Qin, Han, Yu, Yu, Zhang: Fast and Exact Discrete Geodesic Computation Based on Triangle-Oriented Wavefront Propagation.
ACM Trans. Graph. 35(4), 2016.
"""

from math import atan2, inf, pi, sqrt

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place, compiled_inline
from geomhw.geodesic.front import WAITING, Extent, Front, limit_at, limit_on_edge, pop, push, touch
from geomhw.geodesic.unfolded_faces import CONVEX, Surface, angle, ends, next_corner, total_angle, triangle
from geomhw.geodesic.window_images import above_line, continues, crossing_to, images
from geomhw.geodesic.windows import IN_USE, TIE, allocate, insert, least_length, length_to, release, tolerance, trim

#: From this number of events of one halfedge on, its windows stay in the list after they have crossed. A window that
#: returns there, for example round faces of zero area, is then no shorter than those in the list and ends.
PATIENCE = 8
#: At a face that has an angle with a smaller sine, windows stay if they are longer than this share of the edge: longer
#: paths that follow through a fan or strip of such faces end there, instead of passing all of it in quadratic time.
THIN = 0.1
#: Tolerance of directions, in radians.
SLACK = 1e-6


@compiled_in_place
def propagate(surface: Surface, front: Front, places: Floats, faces: Ints, within: Extent, targets: Ints) -> float:
    """Process events up to the limit or until all targets are final; return the radius of final distances.

    Return -1 if more room for windows is needed before the next call. places, faces: (k, 3) and (k,), source points.
    """
    n, h, done = len(front.distance), len(front.waiting), 0
    while front.counts[WAITING]:
        item, key = np.int64(front.items[0]), front.keys[0]
        while done < len(targets) and front.distance[targets[done]] <= key:
            done += 1
        if 0 < len(targets) == done:
            for target in targets:  # keys rise up to rounding only
                key = max(key, front.distance[target])
            return key
        room, used = len(front.windows) - 64, front.counts[IN_USE]
        if 8 * (used + 2 * _size(surface, front, faces, item)) > room:
            return -1.0
        pop(front)
        if item < h:
            _cross_face(surface, front, item, within)
        elif item < h + n:
            _turn(surface, front, item - h, within)
        else:
            i = item - h - n
            for k in range(3):
                x, y, z = places[i]
                _emit(surface, front, 3 * np.int64(faces[i]) + k, x, y, z, 0.0, -1 - i, within)
    return within.limit


@compiled_in_place
def start_from_edges(surface: Surface, front: Front, halfedges: Ints, k: int) -> None:
    """Add the edges of halfedges, of length above zero, as sources: lines perpendicular to them cross their faces.

    k: number of source points. The origin of the lines from halfedge h is -1-k-h.
    """
    for h in halfedges:
        low, high = ends(surface, h)
        (px, py, pz), (qx, qy, qz) = surface.points[low], surface.points[high]
        base = sqrt((px - qx) ** 2 + (py - qy) ** 2 + (pz - qz) ** 2)
        if base > 0:
            i = allocate(front.windows, front.counts, 0)
            w = front.windows[i]
            w.left, w.right, w.x, w.y, w.offset = 0.0, base, 0.0, -1.0, 0.0
            w.next, w.origin, w.crossed, w.passed = 0, -1 - k - h, 0, 0
            touch(front, h)
            front.waiting[h].first, front.waiting[h].count = i, 1
            push(front, h, 0.0)


@compiled_in_place
def _size(surface: Surface, front: Front, faces: Ints, item: int) -> int:
    """Number of windows that an event propagates, with their copies at all faces of an edge."""
    h, n, sides, count = len(front.waiting), len(front.distance), surface.sides, np.int64(0)
    if item >= h + n:
        f = 3 * np.int64(faces[item - h - n])
        return _copies(surface, f) + sides[f]
    if item >= h:
        for k in range(surface.starts[item - h], surface.starts[item - h + 1]):
            count += sides[surface.corners[k]]
        return count
    return np.int64(front.waiting[item].count) * _copies(surface, item)


@compiled_in_place
def _copies(surface: Surface, h: int) -> int:
    """Number of faces behind the other two edges of the face of a halfedge."""
    f = h // 3 * 3
    return np.int64(surface.sides[f]) + surface.sides[f + 1] + surface.sides[f + 2] - surface.sides[h]


@compiled_inline
def _turn(surface: Surface, front: Front, v: int, within: Extent) -> None:
    """Send windows from a vertex into its faces in which a shortest path may continue.

    The path makes an angle of at least π on both sides with the straight line by which it arrives.
    """
    total, d, (x, y, z) = total_angle(surface, v), front.distance[v], surface.points[v]
    is_source = front.origin[v] == v or (front.origin[v] < 0 and front.halfedge[v] < 0)
    if is_source or total == inf:
        for k in range(surface.starts[v], surface.starts[v + 1]):
            _emit(surface, front, np.int64(surface.corners[k]), x, y, z, d, v, within)
        return
    h, side, begin = _arrival(surface, front, v)
    for _ in range(surface.starts[v + 1] - surface.starts[v]):
        end = begin + angle(surface, h)
        if end > pi - SLACK and begin < total - pi + SLACK:
            _emit(surface, front, h, x, y, z, d, v, within)
        h, side = next_corner(surface, v, side)
        begin = end


@compiled_in_place
def _arrival(surface: Surface, front: Front, v: int) -> tuple[int, int, float]:
    """Halfedge opposite a vertex over which its path arrives, a side there, and the negative angle between the line
    and the other side.
    """
    h = np.int64(front.halfedge[v])
    if h >= 0:
        face, t = triangle(surface, h), front.entry[v]
        x, y = face.left * face.cos_low, face.left * face.sin_low
        return h, face.at_high, -atan2(t * y, x * (x - t) + y * y)
    for k in range(surface.starts[v], surface.starts[v + 1]):
        h = np.int64(surface.corners[k])
        for g in range(h - h % 3, h - h % 3 + 3):
            if surface.faces[g // 3, g % 3] == front.origin[v]:
                return h, g, 0.0
    return h, h, 0.0


@compiled_inline
def _emit(
    surface: Surface, front: Front, h: int, x: float, y: float, z: float, d: float, origin: int, within: Extent
) -> None:
    """Send one window from a point (x, y, z) of a face over its halfedge h, and reach the ends of the halfedge."""
    low, high = ends(surface, h)
    p, q = surface.points[low], surface.points[high]
    ex, ey, ez, rx, ry, rz = q[0] - p[0], q[1] - p[1], q[2] - p[2], x - p[0], y - p[1], z - p[2]
    base, along = sqrt(ex * ex + ey * ey + ez * ez), ex * rx + ey * ry + ez * rz
    cross = sqrt((ey * rz - ez * ry) ** 2 + (ez * rx - ex * rz) ** 2 + (ex * ry - ey * rx) ** 2)
    _reach(surface, front, low, d + sqrt(rx * rx + ry * ry + rz * rz), TIE, origin, -1, 0.0, within)
    far = sqrt((x - q[0]) ** 2 + (y - q[1]) ** 2 + (z - q[2]) ** 2)
    _reach(surface, front, high, d + far, TIE, origin, -1, 0.0, within)
    if base > 0 and (cross > 0 or 0 < along < base * base):
        i = allocate(front.windows, front.counts, 0)
        w = front.windows[i]
        w.left, w.right, w.x, w.offset = 0.0, base, along / base, d
        w.y = above_line(cross / base, w.x, base)
        w.next, w.origin, w.crossed, w.passed = 0, origin, 0, 0
        _deliver(surface, front, h, i, base, within)


@compiled_inline
def _cross_face(surface: Surface, front: Front, h: int, within: Extent) -> None:
    """Propagate the windows in the list of a halfedge across its face, to the apex and over the other two sides."""
    windows, face = front.windows, triangle(surface, h)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    waiting = front.waiting[h]
    first = i = np.int64(waiting.first)
    while i > 0:
        w = windows[i]
        while w.next and continues(w, windows[w.next], face.base):
            j = w.next
            w.right, w.next = windows[j].right, windows[j].next
            release(windows, front.counts, j)
        w.split = crossing_to(w.x, w.y, x, y)
        if not w.passed and least_length(w, x, y) < front.distance[face.apex]:
            t = min(max(w.split, w.left), w.right)
            d = length_to(w, t) + sqrt((x - t) ** 2 + y * y)
            _reach(surface, front, face.apex, d, tolerance(w), w.origin, h, t, within)
        i = w.next
    at_low = images(
        windows, front.counts, first, face.base, face.left, face.cos_low, face.sin_low, False, face.low > face.apex
    )
    at_high = images(
        windows, front.counts, first, face.base, face.right, face.cos_high, face.sin_high, True, face.high > face.apex
    )
    waiting.events += 1
    sin_apex = face.sin_low * face.base / face.right if face.right > 0 else 0.0
    is_thin = min(face.sin_low, face.sin_high, sin_apex) < THIN
    shortest = -1.0 if waiting.events > PATIENCE else THIN * face.base if is_thin else inf
    windows[0].next = last = count = 0
    i = first
    while i > 0:
        following = windows[i].next
        windows[i].passed = 1
        if windows[i].right - windows[i].left > shortest:
            windows[last].next, last, count = i, i, count + 1
        else:
            release(windows, front.counts, i)
        i = following
    windows[last].next = 0
    waiting.first, waiting.count = windows[0].next, count
    for side, first, base in ((face.at_low, at_low, face.left), (face.at_high, at_high, face.right)):
        if first:
            _deliver(surface, front, side, first, base, within)


@compiled_inline
def _deliver(surface: Surface, front: Front, h: int, i: int, base: float, within: Extent) -> None:
    """Insert the windows of a list, which leave a face over its halfedge h, at all other faces of the edge."""
    windows, counts = front.windows, front.counts
    low, high = ends(surface, h)
    limit = limit_on_edge(within, low, high, base)
    first, last, least, g = 0, 0, inf, np.int64(surface.across[h])
    while i > 0:
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
        copied, before, i, waiting = surface.across[g] != h, 0, first, front.waiting[g]
        if waiting.count == waiting.events == 0:
            touch(front, g)
        windows[0].next = waiting.first
        waiting.count -= counts[IN_USE]
        while i > 0:
            following = windows[i].next
            waiting.count += not copied
            before = insert(windows, counts, allocate(windows, counts, i) if copied else i, before)
            i = following
        waiting.first, waiting.count = windows[0].next, waiting.count + counts[IN_USE]
        push(front, g, least)
        g = np.int64(surface.across[g])


@compiled_in_place
def _reach(
    surface: Surface,
    front: Front,
    v: int,
    d: float,
    tie: float,
    origin: int,
    halfedge: int,
    entry: float,
    within: Extent,
) -> None:
    """Set the distance of a vertex if it becomes shorter by more than a share; an event if paths may turn there."""
    if d < front.distance[v] * (1 - tie) and d <= limit_at(within, v):
        if front.distance[v] == inf:
            touch(front, len(front.waiting) + v)
        front.distance[v], front.origin[v], front.halfedge[v], front.entry[v] = d, origin, halfedge, entry
        if total_angle(surface, v) != CONVEX:
            push(front, len(front.waiting) + v, d)
