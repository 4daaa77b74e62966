"""Compiled search for the polyline nearest to a point, by exact distance on the surface.

Faces around the point are laid flat one after the other, with the part of each that straight lines from the point
reach (Mitchell, Mount, Papadimitriou 1987), unless a vertex is known from which all of that part is nearer (Xin and
Wang 2009). Shortest paths turn at saddle and boundary vertices only.
"""

from math import acos, cos, inf, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place, compiled_inline
from geomhw.flow.flat_faces import BOUNDARY, FlatFaces, corner_distance
from geomhw.flow.search_windows import EQUAL, MOST_WAITING, Search, hit, is_nearer, push, push_vertex, reach

#: A polyline has turned back where it is nearer to itself than this share of the length between, and that length is at
#: least a share of ``along``.
TURNED, WOUND = 0.3, 0.25
#: A point on an edge is moved into the face by this share of its height.
INSIDE = 1e-8
#: Angle from which a path that turns at a vertex goes on along an edge: π up to rounding.
STRAIGHT = pi - 1e-9


class LineStore(NamedTuple):
    """Segments of polylines, each within a face.

    faces, lines: (s,), the face and the polyline. begins, ends: (s, 3), barycentric coordinates. low, high: (s,), arc
    length at begin and end. times: (s,), duration. slides: (s,), whether it follows an edge. after: (s,), the next
    segment in the same face, -1 for none. first: (m,), of each face.
    """

    faces: Ints
    lines: Ints
    begins: Floats
    ends: Floats
    low: Floats
    high: Floats
    times: Floats
    slides: Ints
    after: Ints
    first: Ints


@compiled_in_place
def nearest_line(
    flat: FlatFaces,
    store: LineStore,
    search: Search,
    face: int,
    b: Floats,
    limit: float,
    own: int,
    tip: float,
    along: float,
) -> tuple[float, int]:
    """Return the distance from a point b of a face to the nearest polyline within a limit, and its number.

    Points of the polyline ``own`` count if their arc length differs from ``tip`` by at least ``along``, or by much more
    than their distance; for a tip of NaN, none do. If there is no polyline, return the limit and -1.
    """
    x = y = total = 0.0
    search.number[0] += 1
    for k in range(3):
        share = max(b[k], INSIDE)
        x, y, total = x + share * flat.places[face, k, 0], y + share * flat.places[face, k, 1], total + share
    x, y = x / total, y / total
    ax, ay = flat.places[face, 0, 0] - x, flat.places[face, 0, 1] - y
    bx, by = flat.places[face, 1, 0] - x, flat.places[face, 1, 1] - y
    cx, cy = flat.places[face, 2, 0] - x, flat.places[face, 2, 1] - y
    zero = np.int64(0)  # a constant would be a type of its own, for which the loops are compiled once more
    best, line, count = limit, zero - 1, zero
    best, line = _in_face(
        store, face, zero, ax, ay, bx, by, cx, cy, 0.0, 0.0, 0.0, 0.0, 0.0, own, tip, along, best, line
    )
    for k in range(3):
        # Corner k is (ax, ay) here.
        count = push(flat, search, count, 3 * face + k, bx, by, cx, cy, bx, by, cx, cy, 0.0)
        reach(search, flat.corners[face, k], sqrt(ax * ax + ay * ay))
        count = push_vertex(flat, search, count, face, k, ax, ay, bx, by, cx, cy, 0.0)
        ax, ay, bx, by, cx, cy = bx, by, cx, cy, ax, ay
    head = zero
    while head < count:
        row = head % MOST_WAITING
        head += 1
        edge = search.edges[row]
        px, py, qx, qy, ux, uy, wx, wy, offset = search.planes[row]
        if edge < 0:  # a vertex
            best, line, count = _turn(
                flat, store, search, count, -1 - edge, px, py, qx, qy, ux, uy, offset, own, tip, along, best, line
            )
            continue
        if offset + _distance(ux, uy, wx, wy) >= best:
            continue
        f, k = edge // 3, edge % 3
        p, q = flat.corners[f, (k + 1) % 3], flat.corners[f, (k + 2) % 3]
        if is_nearer(search, p, px - wx, py - wy, offset, wx, wy) or is_nearer(
            search, q, qx - ux, qy - uy, offset, ux, uy
        ):
            continue
        nx, ny = py - qy, qx - px
        away = flat.rises[edge] if nx * px + ny * py >= 0 else -flat.rises[edge]
        ax = px + flat.feet[edge] * (qx - px) + away * nx
        ay = py + flat.feet[edge] * (qy - py) + away * ny
        best, line = _in_face(store, f, k, ax, ay, px, py, qx, qy, ux, uy, wx, wy, offset, own, tip, along, best, line)
        turn = ux * wy - uy * wx
        left, right = (ux * ay - uy * ax) * turn, (ax * wy - ay * wx) * turn
        if left > 0 and right > 0:
            reach(search, flat.corners[f, k], offset + sqrt(ax * ax + ay * ay))
            count = push_vertex(flat, search, count, f, k, ax, ay, px, py, qx, qy, offset)
            hx, hy = hit(ux, uy, px, py, ax, ay)
            count = push(flat, search, count, 3 * f + (k + 2) % 3, ax, ay, px, py, ax, ay, hx, hy, offset)
            hx, hy = hit(wx, wy, ax, ay, qx, qy)
            count = push(flat, search, count, 3 * f + (k + 1) % 3, qx, qy, ax, ay, hx, hy, ax, ay, offset)
        elif right > 0:
            hx, hy = hit(ux, uy, ax, ay, qx, qy)
            gx, gy = hit(wx, wy, ax, ay, qx, qy)
            count = push(flat, search, count, 3 * f + (k + 1) % 3, qx, qy, ax, ay, gx, gy, hx, hy, offset)
        elif left > 0:
            hx, hy = hit(ux, uy, px, py, ax, ay)
            gx, gy = hit(wx, wy, px, py, ax, ay)
            count = push(flat, search, count, 3 * f + (k + 2) % 3, ax, ay, px, py, gx, gy, hx, hy, offset)
    return best, line


@compiled_in_place
def _in_face(
    store: LineStore,
    face: int,
    k: int,
    ax: float,
    ay: float,
    px: float,
    py: float,
    qx: float,
    qy: float,
    ux: float,
    uy: float,
    wx: float,
    wy: float,
    offset: float,
    own: int,
    tip: float,
    along: float,
    best: float,
    line: int,
) -> tuple[float, int]:
    """Return the smaller of ``best`` and the distance to the segments in a face, within the angle from u to w.

    Corner k is at a, the next ones at p and q. Zeros for u and w: all directions.
    """
    turn = ux * wy - uy * wx
    s = store.first[face]
    while s >= 0:
        here, start, end = s, 0.0, 1.0
        s = store.after[s]
        apart = inf
        if store.lines[here] == own:
            begin, finish = store.low[here], store.high[here]
            if begin < tip - along:
                end = min((tip - along - begin) / (finish - begin), 1.0)
            elif finish > tip + along:
                start = max((tip + along - begin) / (finish - begin), 0.0)
            else:
                apart = max(begin - tip, tip - finish)
                if not apart >= WOUND * along:
                    continue
        i, j = (k + 1) % 3, (k + 2) % 3
        one, two = store.begins[here], store.ends[here]
        x, y = one[k] * ax + one[i] * px + one[j] * qx, one[k] * ay + one[i] * py + one[j] * qy
        dx = two[k] * ax + two[i] * px + two[j] * qx - x
        dy = two[k] * ay + two[i] * py + two[j] * qy - y
        if turn != 0:
            # The segment is at value + t slope >= 0 on the visible sides of u and w.
            value, slope = (ux * y - uy * x) * turn, (ux * dy - uy * dx) * turn
            start, end = _clipped(value, slope, start, end)
            value, slope = (x * wy - y * wx) * turn, (dx * wy - dy * wx) * turn
            start, end = _clipped(value, slope, start, end)
        if start <= end:
            distance = offset + _distance(x + start * dx, y + start * dy, x + end * dx, y + end * dy)
            if distance < best and distance < TURNED * apart:
                best, line = distance, store.lines[here]
    return best, line


@compiled_in_place
def _turn(
    flat: FlatFaces,
    store: LineStore,
    search: Search,
    count: int,
    corner: int,
    ax: float,
    ay: float,
    px: float,
    py: float,
    qx: float,
    qy: float,
    offset: float,
    own: int,
    tip: float,
    along: float,
    best: float,
    line: int,
) -> tuple[float, int, int]:
    """Continue the search behind corner 3f + k, at a, in the directions where a shortest path turns there.

    They are at least π from the direction back to the source, on both sides.
    """
    far = sqrt(ax * ax + ay * ay)
    if offset + far >= best:
        return best, line, count
    face, k = corner // 3, corner % 3
    vertex = flat.corners[face, k]
    if search.stamps[vertex] == search.number[0] and offset + far > search.reached[vertex] * (1 + EQUAL):
        return best, line, count
    reach(search, vertex, offset + far)
    total = flat.totals[vertex]
    for side in range(2 if total == BOUNDARY else 1):
        ex, ey = (qx - ax, qy - ay) if side == 0 else (px - ax, py - ay)
        ratio = -(ax * ex + ay * ey) / (far * sqrt(ex * ex + ey * ey)) if far > 0 else 1.0
        passed, last = acos(min(max(ratio, -1.0), 1.0)), inf if total == BOUNDARY else total - pi
        edge = 3 * face + (k + 1 + side) % 3
        while passed < last and flat.across[edge] >= 0:
            other = flat.across[edge]
            f, z = other // 3, other % 3
            v = (z + 1) % 3 if flat.corners[f, (z + 1) % 3] == vertex else (z + 2) % 3
            angle, w = flat.angles[3 * f + v], 3 - z - v
            if passed + angle > pi:
                wx, length = corner_distance(flat, f, v, w), corner_distance(flat, f, v, z)
                zx, zy = length * cos(angle), length * sin(angle)
                if passed >= STRAIGHT:
                    reach(search, flat.corners[f, w], offset + far + wx)
                    # Straight along the edge to its other end.
                    if v == (w + 1) % 3:
                        count = push_vertex(flat, search, count, f, w, wx, 0.0, 0.0, 0.0, zx, zy, offset + far)
                    else:
                        count = push_vertex(flat, search, count, f, w, wx, 0.0, zx, zy, 0.0, 0.0, offset + far)
                begin, end = max(pi - passed, 0.0), min(last - passed, angle)
                lx, ly = hit(cos(begin), sin(begin), wx, 0.0, zx, zy)
                rx, ry = hit(cos(end), sin(end), wx, 0.0, zx, zy)
                ux, uy, tx, ty = (wx, 0.0, zx, zy) if w == (v + 1) % 3 else (zx, zy, wx, 0.0)
                best, line = _in_face(
                    store, f, v, 0.0, 0.0, ux, uy, tx, ty, lx, ly, rx, ry, offset + far, own, tip, along, best, line
                )
                if w == (v + 1) % 3:
                    count = push(flat, search, count, 3 * f + v, wx, 0.0, zx, zy, lx, ly, rx, ry, offset + far)
                else:
                    count = push(flat, search, count, 3 * f + v, zx, zy, wx, 0.0, rx, ry, lx, ly, offset + far)
            passed, edge = passed + angle, 3 * f + w
            if flat.across[edge] < 0 and passed >= STRAIGHT:  # along the boundary
                x = corner_distance(flat, f, v, z)
                y = corner_distance(flat, f, v, w)
                px, py, qx, qy = 0.0, 0.0, y * cos(angle), -y * sin(angle)
                if v != (z + 1) % 3:
                    px, py, qx, qy = qx, qy, px, py
                count = push_vertex(flat, search, count, f, z, x, 0.0, px, py, qx, qy, offset + far)
            if f == face:
                break
    return best, line, count


@compiled_inline
def _clipped(value: float, slope: float, start: float, end: float) -> tuple[float, float]:
    """Return the part of start <= t <= end where value + t slope >= 0; end < start if there is none."""
    if value < 0 and value + slope < 0:
        return 1.0, 0.0
    if value < 0:
        return max(start, -value / slope), end
    if value + slope < 0:
        return start, min(end, -value / slope)
    return start, end


@compiled_inline
def _distance(px: float, py: float, qx: float, qy: float) -> float:
    """Return the distance from the origin to a segment."""
    dx, dy = qx - px, qy - py
    square = dx * dx + dy * dy
    t = min(max(-(px * dx + py * dy) / square, 0.0), 1.0) if square > 0 else 0.0
    return sqrt((px + t * dx) ** 2 + (py + t * dy) ** 2)
