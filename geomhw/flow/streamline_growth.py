"""Compiled growth of one streamline in both directions, until it closes, ends, or comes near another one."""

from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats
from geomhw.compiled import compiled, compiled_in_place
from geomhw.flow.flat_faces import BOUNDARY as BOUNDARY_VERTEX
from geomhw.flow.flat_faces import FlatFaces
from geomhw.flow.nearby_lines import LineStore, nearest_line
from geomhw.flow.search_windows import Search
from geomhw.flow.streamlines import ON_EDGE, FaceFlow, enter_face

#: Reasons why a streamline ends.
CLOSED, BOUNDARY, CRITICAL, NEAR, ITSELF, LONG = range(1, 7)
#: The store has no room for the streamline; -1 as its number of segments.
FULL = -1
#: A streamline that passes its seed this near, relative to the size of the face, is closed.
SAME = 1e-9
#: Parts of a streamline nearer to each other along it than this multiple of the limit may be near on the surface.
ALONG = 2.1
#: Length between two measurements of distance, at most and at least, as shares of the limit.
LONGEST, SHORTEST = 0.25, 0.01
#: A streamline that comes near itself is followed this multiple of the limit to see whether it closes.
PROBE = 3.0

#: Most edges that one half of a streamline crosses.
MOST_CROSSINGS = 1_000_000


class Growth(NamedTuple):
    """What streamlines grow in: both directions of the flow, the surface, and the room of searches."""

    forward: FaceFlow
    backward: FaceFlow
    flat: FlatFaces
    search: Search
    slow: float


@compiled
def grow(
    growth: Growth, store: LineStore, count: int, line: int, face: int, b: Floats, limit: float
) -> tuple[int, int, int, int]:
    """Add the streamline through a point of a face to the store after ``count`` segments.

    Return the number of segments at the end of its downstream part and at the end of all, `FULL` if there is no room,
    and why it ends downstream and upstream.
    """
    middle, downstream = _grow(growth, growth.forward, store, count, line, face, b, 1.0, limit)
    if middle == FULL or downstream == CLOSED:
        return middle, middle, downstream, downstream
    end, upstream = _grow(growth, growth.backward, store, middle, line, face, b, -1.0, limit)
    if end == FULL:
        remove(store, count, middle)
    return middle, end, downstream, upstream


@compiled_in_place
def remove(store: LineStore, count: int, end: int) -> None:
    """Remove the segments from ``count`` to ``end`` from their faces."""
    for s in range(end - 1, count - 1, -1):
        store.first[store.faces[s]] = store.after[s]


@compiled
def _grow(
    growth: Growth,
    flow: FaceFlow,
    store: LineStore,
    count: int,
    line: int,
    face: int,
    start: Floats,
    sign: float,
    limit: float,
) -> tuple[int, int]:
    """Add one half of a streamline, downstream or, with the flow and the sign reversed, upstream."""
    b = np.zeros(3)
    _copy(start, b)
    end, tip, arc, reason = _follow(growth, flow, store, count, line, face, b, start, face, 0.0, sign, limit, inf)
    if reason == ITSELF and sign > 0:
        # It may be about to close.
        length = abs(arc) + PROBE * limit
        more, _, _, closed = _follow(growth, flow, store, end, line, tip, b, start, face, arc, sign, limit, length)
        if closed == CLOSED:
            return more, CLOSED
        if more != FULL:
            remove(store, end, more)
        else:
            end = FULL
    if end == FULL:
        remove(store, count, len(store.faces))
    return end, reason


@compiled
def _follow(
    growth: Growth,
    flow: FaceFlow,
    store: LineStore,
    count: int,
    line: int,
    face: int,
    b: Floats,
    start: Floats,
    seed: int,
    arc: float,
    sign: float,
    limit: float,
    longest: float,
) -> tuple[int, int, float, int]:
    """Add the streamline from b on to the store; b moves to its end.

    start, seed: where the streamline began, and the face of that point. longest: arc length at which it ends as near
    itself; if it is finite, other parts of it do not count as near. Return the number of segments, face and arc length
    at the end, and why it ends.
    """
    flat, first = growth.flat, count
    ahead, rates, cut = np.zeros(3), np.zeros(3), np.zeros(3)
    free, reach = 0.0, (1 + LONGEST + SHORTEST) * limit
    for _ in range(MOST_CROSSINGS):
        if count >= len(store.faces):
            return FULL, face, arc, LONG
        face, _ = enter_face(flow, face, b, rates)
        time, slides, reason = _step(growth, flow, face, b, rates, ahead)
        if reason:
            return count, face, arc, reason
        length = _length(flat, face, b, ahead)
        if face == seed and (count > first + 1 or arc != 0):
            share = _passes(flat, face, b, ahead, start)
            if share >= 0:
                count = _add(store, count, line, face, b, start, arc, sign * share * length, share * time, slides)
                return count, face, arc, CLOSED
        # The distance is measured after a length in which it cannot fall below the limit.
        done = 0.0
        while done + free < length:
            done += free
            share, tip = done / length, arc + sign * done
            for k in range(3):
                cut[k] = b[k] + share * (ahead[k] - b[k])
            own = tip if longest == inf else nan
            distance, other = nearest_line(flat, store, growth.search, face, cut, reach, line, own, ALONG * limit)
            if distance < (1 + SHORTEST) * limit or abs(tip) > longest:
                if done > 0:
                    count = _add(store, count, line, face, b, cut, arc, sign * done, share * time, slides)
                _copy(cut, b)
                return count, face, tip, NEAR if other >= 0 and other != line else ITSELF
            free = min(distance - limit, LONGEST * limit)
        free -= length - done
        if length > 0:
            count = _add(store, count, line, face, b, ahead, arc, sign * length, time, slides)
            arc += sign * length
        _copy(ahead, b)
    return count, face, arc, LONG


@compiled_in_place
def _step(growth: Growth, flow: FaceFlow, face: int, b: Floats, rates: Floats, ahead: Floats) -> tuple[float, int, int]:
    """Set where a point leaves its face; return the time, whether it slides along an edge, and why it stops, or 0."""
    flat, square, slides = growth.flat, 0.0, 0
    for k in range(3):
        square += flow.V[face, k] ** 2
        if b[k] == 0 and rates[k] == 0 and flow.rates[face, k] < 0:
            slides = 1
            if flat.across[3 * face + k] < 0:
                return 0.0, 1, BOUNDARY
    time, edge = inf, -1
    for k in range(3):
        if rates[k] < 0 and b[k] / -rates[k] < time:
            time, edge = b[k] / -rates[k], k
    if edge < 0 or not time < inf or sqrt(square) <= growth.slow:
        for k in range(3):
            if b[k] == 1 and flat.totals[flat.corners[face, k]] == BOUNDARY_VERTEX:
                return 0.0, slides, BOUNDARY
        return 0.0, slides, CRITICAL
    total = 0.0
    for k in range(3):
        ahead[k] = b[k] + time * rates[k]
        if ahead[k] < ON_EDGE or k == edge:
            ahead[k] = 0.0
        total += ahead[k]
    for k in range(3):
        ahead[k] /= total
    return time, slides, 0


@compiled_in_place
def _add(
    store: LineStore,
    s: int,
    line: int,
    face: int,
    begin: Floats,
    end: Floats,
    arc: float,
    length: float,
    time: float,
    slides: int,
) -> int:
    """Add a segment to the store as number s, with arc length ascending; the number of segments."""
    store.faces[s], store.lines[s], store.times[s], store.slides[s] = face, line, time, slides
    for k in range(3):
        store.begins[s, k] = begin[k] if length > 0 else end[k]
        store.ends[s, k] = end[k] if length > 0 else begin[k]
    store.low[s], store.high[s] = min(arc, arc + length), max(arc, arc + length)
    store.after[s], store.first[face] = store.first[face], s
    return s + 1


@compiled_in_place
def _length(flat: FlatFaces, face: int, one: Floats, other: Floats) -> float:
    """Return the distance between two points of a face."""
    x = y = 0.0
    for k in range(3):
        x += (other[k] - one[k]) * flat.places[face, k, 0]
        y += (other[k] - one[k]) * flat.places[face, k, 1]
    return sqrt(x * x + y * y)


@compiled_in_place
def _passes(flat: FlatFaces, face: int, one: Floats, other: Floats, point: Floats) -> float:
    """Return the share of a segment at which it passes a point of the face, -1 if it does not."""
    dx = dy = px = py = size = 0.0
    for k in range(3):
        x, y = flat.places[face, k]
        dx, dy = dx + (other[k] - one[k]) * x, dy + (other[k] - one[k]) * y
        px, py = px + (point[k] - one[k]) * x, py + (point[k] - one[k]) * y
        size = max(size, abs(x), abs(y))
    square = dx * dx + dy * dy
    share = (px * dx + py * dy) / square if square > 0 else -1.0
    if 0 <= share <= 1 and (px - share * dx) ** 2 + (py - share * dy) ** 2 <= (SAME * size) ** 2:
        return share
    return -1.0


@compiled_in_place
def _copy(point: Floats, b: Floats) -> None:
    """Copy barycentric coordinates."""
    for k in range(3):
        b[k] = point[k]
