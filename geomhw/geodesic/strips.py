"""Strips of faces, and the straightening of a path by moving its strip to the other side of a vertex.

A path that is shortest in its strip turns only at vertices. Where the angle on the outer side of the turn is below π,
the path is shorter on that side; on both sides at least π, it is a geodesic [Sharp and Crane 2020].

Sharp, Crane: You Can Find Geodesic Paths in Triangle Meshes by Just Flipping Edges. ACM Trans. Graph. 39(6), 2020.
Xin, Wang: Efficiently Determining a Locally Exact Shortest Path on Polyhedral Surfaces. CAD 39(12), 2007.
"""

from dataclasses import dataclass
from math import atan2, pi
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.funnel import shortest_in_strip
from geomhw.geodesic.unfolded_faces import Surface, angle, ends

#: The path moves to the other side of a vertex if the angle there is smaller than π by more, in radians.
STRAIGHT = 1e-9
#: Points of a path nearer to a vertex, as a share of an edge there, give no direction.
SAME_POINT = 1e-12


@dataclass
class Strip:
    """The edges that a path crosses, as halfedges of the faces before and after each, and its ends.

    start, end: (3,) barycentric coordinates in the faces ``first`` and that of the last halfedge entered.
    """

    first: int
    leave: list[int]
    enter: list[int]
    start: Floats
    end: Floats

    @classmethod
    def between(cls, surface: Surface, first: int, leave: list[int], enter: list[int], start: int, end: int) -> "Strip":
        """Return a strip from one vertex to another."""
        last = enter[-1] // 3 if enter else first
        weights = [(surface.faces[f] == v).astype(float) for f, v in ((first, start), (last, end))]
        return cls(first, leave, enter, *weights)

    def extended(self, surface: Surface, u: int, face: int, v: int) -> "Strip | None":
        """Return a strip that ends at a vertex u, extended round u to a face and to its vertex v; None if it cannot."""
        fan = fan_between(surface, u, self.last, face)
        if fan is None:
            return None
        end = (surface.faces[face] == v).astype(float)
        return Strip(self.first, self.leave + fan[0], self.enter + fan[1], self.start, end)

    @property
    def last(self) -> int:
        """The face of the end."""
        return self.enter[-1] // 3 if self.enter else self.first


class Crossings(NamedTuple):
    """The shortest path in a strip: its length, the share of each edge before the crossing, and turns, or -1."""

    length: float
    shares: Floats
    bends: Ints


def straightened(surface: Surface, strip: Strip) -> tuple[Strip, Crossings]:
    """Return the strip of the geodesic in the homotopy class of a path with fixed ends, and the geodesic in it."""
    strip = shortened_ends(surface, strip)
    found = crossings(surface, strip)
    while moved := rerouted(surface, strip, found):
        moved = shortened_ends(surface, moved)
        shorter = crossings(surface, moved)
        if not shorter.length < found.length:  # up to rounding
            break
        strip, found = moved, shorter
    return strip, found


def crossings(surface: Surface, strip: Strip) -> Crossings:
    """Return the shortest path within a strip."""
    k = len(strip.leave)
    if k == 0:
        corners = surface.points[surface.faces[strip.first]]
        return Crossings(float(np.linalg.norm((strip.end - strip.start) @ corners)), np.empty(0), np.empty(0, np.int64))
    bends, shares = np.empty(k, dtype=np.int64), np.empty(k)
    leave, enter = np.array(strip.leave), np.array(strip.enter)
    length = shortest_in_strip(surface, leave, enter, strip.start, strip.end, np.empty((k + 2, 4)), bends, shares)
    return Crossings(length, shares, bends)


def shortened_ends(surface: Surface, strip: Strip) -> Strip:
    """Return a strip without edges that its ends lie on, and without edges that it crosses twice in a row."""
    leave: list[int] = []
    enter: list[int] = []
    for out, into in zip(strip.leave, strip.enter, strict=True):
        if enter and out == enter[-1]:
            enter.pop()
            if leave[-1] == into:
                leave.pop()
            else:
                enter.append(into)
        else:
            leave.append(out)
            enter.append(into)
    first, start, end = strip.first, strip.start, strip.end
    drop = 0
    while drop < len(leave) and start[leave[drop] % 3] == 0:
        start = _in_face(surface, start, first, enter[drop] // 3)
        first = enter[drop] // 3
        drop += 1
    leave, enter = leave[drop:], enter[drop:]
    while leave and end[enter[-1] % 3] == 0:
        end = _in_face(surface, end, enter[-1] // 3, leave[-1] // 3)
        leave.pop()
        enter.pop()
    return Strip(first, leave, enter, start, end)


def fan_between(surface: Surface, v: int, face: int, other: int) -> tuple[list[int], list[int]] | None:
    """Return the fewest edges at a vertex that lead from one of its faces to another; None if they do not meet."""
    reached, waiting = {face: (list[int](), list[int]())}, [face]
    while waiting and other not in reached:
        f = waiting.pop(0)
        for side in range(3 * f, 3 * f + 3):
            g = int(surface.across[side])
            while v in ends(surface, side) and g != side:
                if g // 3 not in reached:
                    reached[g // 3] = [*reached[f][0], side], [*reached[f][1], g]
                    waiting.append(g // 3)
                g = int(surface.across[g])
    return reached.get(other)


def _in_face(surface: Surface, weights: Floats, face: int, other: int) -> Floats:
    """Return the barycentric coordinates, in another face, of a point on an edge of both."""
    moved = np.zeros(3)
    for v, weight in zip(surface.faces[face], weights, strict=True):
        if weight:
            moved[np.flatnonzero(surface.faces[other] == v)[0]] = weight
    return moved


def rerouted(surface: Surface, strip: Strip, found: Crossings) -> Strip | None:
    """Return the strip on the other side of the vertices where that shortens the path, or None if there are none."""
    leave, enter, changed = list(strip.leave), list(strip.enter), False
    x, b = positions(surface, strip, found), len(leave) - 1
    while b >= 0:
        w, a = int(found.bends[b]), b
        while w >= 0 and a > 0 and found.bends[a - 1] == w:
            a -= 1
        if w >= 0:
            before, after = x[a], x[b + 2]
            if (fan := _outer_fan(surface, w, strip.leave[a], strip.enter[b], before, after)) is not None:
                leave[a : b + 1], enter[a : b + 1] = fan
                changed = True
        b = a - 1
    return Strip(strip.first, leave, enter, strip.start, strip.end) if changed else None


def positions(surface: Surface, strip: Strip, found: Crossings) -> Floats:
    """Return the positions of the start, the crossings and the end of a path in a strip, (k + 2, 3)."""
    sides, points = np.array(strip.leave, dtype=np.int64), surface.points
    corners = np.sort([surface.faces[sides // 3, (sides % 3 + k) % 3] for k in (1, 2)], axis=0)
    shares = found.shares[:, None]
    inner = (1 - shares) * points[corners[0]] + shares * points[corners[1]]
    start, end = strip.start @ points[surface.faces[strip.first]], strip.end @ points[surface.faces[strip.last]]
    return np.concatenate([[start], inner, [end]])


def _outer_fan(
    surface: Surface, w: int, leave: int, enter: int, before: Floats, after: Floats
) -> tuple[list[int], list[int]] | None:
    """Return the edges crossed on the other side of a vertex w if the angle there is below π, else None.

    leave, enter: halfedges of the first and last face at w over which the path leaves and enters now. before, after:
    points of the path in these faces.
    """
    first, last = leave // 3, enter // 3
    at_w = surface.points[w]
    if first == last:
        return [], []
    out, into = _other_side(surface, w, leave), _other_side(surface, w, enter)
    begin = _angle(before - at_w, _far_end(surface, w, out) - at_w)
    rest = _angle(after - at_w, _far_end(surface, w, into) - at_w)
    best, least = None, pi - STRAIGHT - rest
    stack: list[tuple[int, float, list[int], list[int]]] = [(out, begin, [], [])]
    while stack:
        side, total, leaves, enters = stack.pop()
        g = int(surface.across[side])
        while g != side:
            if g == into:
                if total < least:
                    best, least = ([*leaves, side], [*enters, g]), total
            elif all(g // 3 != h // 3 for h in [side, *enters]):
                corner = 3 * (g // 3) + int(np.flatnonzero(surface.faces[g // 3] == w)[0])
                if (turned := total + angle(surface, corner)) < least:
                    stack.append((_other_side(surface, w, g), turned, [*leaves, side], [*enters, g]))
            g = int(surface.across[g])
    return best


def _other_side(surface: Surface, w: int, side: int) -> int:
    """Return the other halfedge at a corner w of a face, given one."""
    f = side // 3
    k = int(np.flatnonzero(surface.faces[f] == w)[0])
    return 3 * f + 3 - k - side % 3


def _far_end(surface: Surface, w: int, side: int) -> Floats:
    """Return the position of the other end of a halfedge at w."""
    low, high = ends(surface, side)
    return surface.points[low + high - w]


def _angle(a: Floats, b: Floats) -> float:
    """Return the angle between two vectors; 0, so that the other side is tried, if the first is zero up to rounding."""
    if a @ a <= SAME_POINT**2 * (b @ b):
        return 0.0
    return atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b))
