"""Straight lines across faces, and the faces that the straight line of a shortest path crosses, traced back.

A line that crosses halfedge h into its face has coordinates there: the place t on the edge, from its lower vertex, and
a unit direction: c along the edge toward the higher vertex, s ≥ 0 into the face.
"""

from math import sqrt
from typing import Any

import numpy as np

from geomhw.compiled import compiled_in_place
from geomhw.geodesic.unfolded_faces import Surface, Triangle, triangle

#: A line may pass a vertex on either side if it is nearer, as a share of the length of the line.
AMBIGUOUS = 1e-8
#: Most faces that the search for one line enters.
MOST_STEPS = 20_000
#: Crossings of a line: ``leave`` and ``enter``, the halfedges of the faces before and after the edge; the line there;
#: ``left``, its length from there on; ``choice``, the number of the choice made there.
CROSSING = np.dtype(
    [(name, np.int64) for name in ("leave", "enter", "choice")]
    + [(name, np.float64) for name in ("place", "along", "into", "left")]
)


@compiled_in_place
def apex_side(face: Triangle, t: float, c: float, s: float) -> float:
    """Distance of the apex of a face from a line into it; positive if the apex is on its left."""
    return c * face.left * face.sin_low - s * (face.left * face.cos_low - t)


@compiled_in_place
def cross_face(face: Triangle, t: float, c: float, s: float, over_high: bool) -> Any:
    """Extend a line across a face, over the side at the higher or the lower end of its base.

    Return the halfedge of that side, the place on it, the direction behind it, and the length in the face.
    """
    if over_high:
        side, end, start, length, ex, ey = face.at_high, face.high, face.base, face.right, -face.cos_high, face.sin_high
    else:
        side, end, start, length, ex, ey = face.at_low, face.low, 0.0, face.left, face.cos_low, face.sin_low
    det = c * ey - s * ex
    u = walked = 0.0
    if det != 0:
        u, walked = min(max((start - t) * s / det, 0.0), length), max((start - t) * ey / det, 0.0)
    along, into = c * ex + s * ey, abs(det)
    if end > face.apex:
        u, along = length - u, -along
    norm = sqrt(along * along + into * into)
    return side, u, along / norm, into / norm, walked


@compiled_in_place
def distance_to_corner(face: Triangle, t: float, v: int) -> float:
    """Distance from the place t on the base of a face to a corner v; -1 if v is no corner."""
    if v == face.low:
        return t
    if v == face.high:
        return face.base - t
    if v == face.apex:
        return sqrt((face.left * face.cos_low - t) ** 2 + (face.left * face.sin_low) ** 2)
    return -1.0


@compiled_in_place
def line_to_origin(surface: Surface, h: int, t: float, origin: int, length: float, line: Any) -> int:
    """Trace the straight line from the vertex opposite h, through the place t on h, back to a vertex.

    Where the line passes a vertex up to rounding, and at edges of more than two faces, there is a choice; the search
    takes the next one where a line misses the origin. line: takes the crossings. Return their number, 0 if no line of
    the length reaches the origin, or -1 if there are more than ``line`` has room for.
    """
    face = triangle(surface, h)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    walked, slack, k = sqrt((x - t) ** 2 + y * y), AMBIGUOUS * length, 0
    if walked <= slack:  # the vertex lies on the edge, so the direction is unknown
        return 0
    _append(line, 0, h, t, (t - x) / walked, y / walked, length - walked)
    for _ in range(MOST_STEPS):
        w = line[k]
        copies = surface.sides[w.leave] - 1
        if w.choice >= 2 * copies:
            k -= 1
            if k < 0:
                return 0
            line[k].choice += 1
            continue
        g = np.int64(surface.across[w.leave])
        for _ in range(w.choice // 2):
            g = np.int64(surface.across[g])
        w.enter = g
        face = triangle(surface, g)
        rest = distance_to_corner(face, w.place, origin)
        if rest >= 0 and abs(rest - w.left) <= slack:
            return k + 1
        apex = apex_side(face, w.place, w.along, w.into)
        other = w.choice % 2 == 1
        if other and abs(apex) > slack:
            w.choice += 1
            continue
        side, place, along, into, walked = cross_face(face, w.place, w.along, w.into, (apex > 0) != other)
        if w.left - walked < -slack or surface.sides[side] < 2:
            w.choice += 1
            continue
        k += 1
        if k == len(line):
            return -1
        _append(line, k, side, place, along, into, w.left - walked)
    return 0


@compiled_in_place
def _append(line: Any, k: int, leave: int, place: float, along: float, into: float, left: float) -> None:
    """Set crossing k of a line."""
    w = line[k]
    w.leave, w.enter, w.choice, w.place, w.along, w.into, w.left = leave, 0, 0, place, along, into, left
