"""Compiled placement of streamlines at the spacing from those that exist (Jobard and Lefer 1997)."""

from math import cos, inf, nan, pi, radians, sin, sqrt
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled
from geomhw.flow.flat_faces import FlatFaces
from geomhw.flow.nearby_lines import LineStore, nearest_line
from geomhw.flow.streamline_growth import ALONG, CLOSED, FULL, MOST_CROSSINGS, Growth, grow, remove

#: Smallest distance of a streamline from others and from itself, and its smallest length, as shares of the spacing.
NEAREST, SHORTEST = 0.6, 1.0
#: A seed is this near to the spacing, as a share of it.
ROUNDING = 1e-6
#: Length between the points of a streamline on both sides of which others start, as a share of the spacing.
STEP = 0.25
#: Directions in which others start from the ends of a streamline: number on each side, and radians between them.
FAN, TURN = 4, radians(30)
#: Largest distance of neighbors that is measured, in spacings.
FARTHEST = 3.0
#: Smallest barycentric coordinate of a seed.
INSIDE = 1e-8


class Lines(NamedTuple):
    """The streamlines of a store: its segments, downstream from ``begins`` to ``middles``, then upstream to ``ends``.

    All (p,). downstream, upstream: why it ends there.
    """

    begins: Ints
    middles: Ints
    ends: Ints
    downstream: Ints
    upstream: Ints


@compiled
def seed_at(growth: Growth, store: LineStore, lines: Lines, line: int, face: int, b: Floats, spacing: float) -> int:
    """Add the streamline through a point as number ``line``, and return the next number.

    The number stays if the point is nearer than the spacing to a streamline, or its streamline is short. Return `FULL`
    if there is no room.
    """
    reach = (1 - ROUNDING) * spacing
    if nearest_line(growth.flat, store, growth.search, face, b, reach, line, 0.0, 0.0)[1] >= 0:
        return line
    total = 0.0
    for k in range(3):
        b[k] = max(b[k], INSIDE)
        total += b[k]
    for k in range(3):
        b[k] /= total
    count = lines.ends[line - 1] if line else line
    if line >= len(lines.ends):
        return FULL
    middle, end, downstream, upstream = grow(growth, store, count, line, face, b, NEAREST * spacing)
    if middle == FULL or end == FULL:
        return FULL
    length = 0.0
    for s in range(count, end):
        length += store.high[s] - store.low[s]
    if length < SHORTEST * spacing:
        remove(store, count, end)
        return line
    lines.begins[line], lines.middles[line], lines.ends[line] = count, middle, end
    lines.downstream[line], lines.upstream[line] = downstream, upstream
    return line + 1


@compiled
def spread_lines(
    growth: Growth, store: LineStore, lines: Lines, line: int, parent: int, segment: int, spacing: float
) -> tuple[int, int, int, bool]:
    """Add streamlines at the spacing from existing ones, from a segment of the parent on, until there is no place left.

    Return the number of streamlines, where to go on, and whether there is room.
    """
    b = np.zeros(3)
    while parent < line:
        segment = max(segment, lines.begins[parent])
        while segment < lines.ends[parent]:
            step = STEP * spacing
            low, high = store.low[segment], store.high[segment]
            arc = np.ceil(low / step) * step
            while arc < high:
                share = (arc - low) / (high - low)
                for side in range(2):
                    turn = (side + 0.5) * pi
                    line, room = _beside(growth, store, lines, line, segment, share, turn, b, spacing)
                    if not room:
                        return line, parent, segment, False
                arc += step
            segment += 1
        if lines.downstream[parent] != CLOSED:
            for end in range(2):
                last = lines.middles[parent] - 1 if end == 0 else lines.ends[parent] - 1
                if (end == 0 and last < lines.begins[parent]) or (end == 1 and last < lines.middles[parent]):
                    continue
                for k in range(1 - FAN, FAN):
                    line, room = _beside(growth, store, lines, line, last, 1.0 - end, k * TURN + pi * end, b, spacing)
                    if not room:
                        return line, parent, segment, False
        parent, segment = parent + 1, 0
    return line, parent, segment, True


@compiled
def neighbor_distances(growth: Growth, store: LineStore, lines: Lines, count: int, spacing: float) -> Floats:
    """Return the distance to the nearest other streamline, or part of the same one, at even places of streamlines.

    It is infinite beyond `FARTHEST`.
    """
    found, number, b = np.full(count, inf), 0, np.zeros(3)
    step, along, reach = spacing / 2, ALONG * NEAREST * spacing, FARTHEST * spacing
    for segment in range(count):
        low, high, line = store.low[segment], store.high[segment], store.lines[segment]
        if np.ceil(low / step) * step >= high:
            continue
        for k in range(3):
            b[k] = (store.begins[segment, k] + store.ends[segment, k]) / 2
        arc, face = (low + high) / 2, store.faces[segment]
        last = store.high[lines.ends[line] - 1]
        if lines.downstream[line] == CLOSED and (arc < along or arc + along > last):
            arc = nan  # its other parts continue across the place where it closes
        distance, other = nearest_line(growth.flat, store, growth.search, face, b, reach, line, arc, along)
        if other >= 0:
            found[number] = distance
        number += 1
    return found[:number]


@compiled
def _beside(
    growth: Growth,
    store: LineStore,
    lines: Lines,
    line: int,
    segment: int,
    share: float,
    turn: float,
    b: Floats,
    spacing: float,
) -> tuple[int, bool]:
    """Try a seed at the spacing from a place on a segment, in a direction turned from it counterclockwise."""
    flat, face = growth.flat, store.faces[segment]
    dx = dy = 0.0
    for k in range(3):
        one, other = store.begins[segment, k], store.ends[segment, k]
        b[k] = (1 - share) * one + share * other
        dx, dy = dx + (other - one) * flat.places[face, k, 0], dy + (other - one) * flat.places[face, k, 1]
    length = sqrt(dx * dx + dy * dy)
    if length == 0:
        return line, True
    c, s = cos(turn) / length, sin(turn) / length
    face = walk_straight(flat, face, b, c * dx - s * dy, s * dx + c * dy, spacing)
    if face < 0:
        return line, True
    added = seed_at(growth, store, lines, line, face, b, spacing)
    return (line, False) if added == FULL else (added, True)


@compiled
def walk_straight(flat: FlatFaces, face: int, b: Floats, ux: float, uy: float, length: float) -> int:
    """Move a point along the straightest line in a unit direction; its face, -1 beyond the boundary."""
    rates, entered = np.zeros(3), -1
    for _ in range(MOST_CROSSINGS):
        time, edge = inf, -1
        for k in range(3):
            one, other, apex = flat.places[face, (k + 1) % 3], flat.places[face, (k + 2) % 3], flat.places[face, k]
            nx, ny = one[1] - other[1], other[0] - one[0]
            rates[k] = (nx * ux + ny * uy) / (nx * (apex[0] - one[0]) + ny * (apex[1] - one[1]))
            if k != entered and rates[k] < 0 and b[k] / -rates[k] < time:
                time, edge = b[k] / -rates[k], k
        if edge < 0:
            return -1
        step, total = min(time, length), 0.0
        for k in range(3):
            b[k] = max(b[k] + step * rates[k], 0.0)
            total += b[k]
        for k in range(3):
            b[k] /= total
        length -= step
        if length <= 0:
            return face
        other = flat.across[3 * face + edge]
        if other < 0:
            return -1
        i, j = (edge + 1) % 3, (edge + 2) % 3
        ex, ey = _unit(flat, face, i, j)
        along = ux * ex + uy * ey
        out = sqrt(max(1 - along * along, 0.0))
        beyond, entered = other // 3, other % 3
        one, two = b[i], b[j]
        if flat.corners[face, i] != flat.corners[beyond, (entered + 1) % 3]:
            one, two, along = two, one, -along
        face = beyond
        b[entered], b[(entered + 1) % 3], b[(entered + 2) % 3] = 0.0, one, two
        ex, ey = _unit(flat, face, (entered + 1) % 3, (entered + 2) % 3)
        # Faces lie counterclockwise in the plane, so the inside is to the left.
        ux, uy = along * ex - out * ey, along * ey + out * ex
    return -1


@compiled
def _unit(flat: FlatFaces, face: int, i: int, j: int) -> tuple[float, float]:
    """Return the direction from a corner of a flat face to another."""
    x = flat.places[face, j, 0] - flat.places[face, i, 0]
    y = flat.places[face, j, 1] - flat.places[face, i, 1]
    length = sqrt(x * x + y * y)
    return x / length, y / length
