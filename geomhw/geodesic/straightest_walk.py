"""Compiled walk along a straightest geodesic, across edges and through vertices.

Polthier, Schmies: Straightest Geodesics on Polyhedral Surfaces. Mathematical Visualization, 1998.
"""

from math import acos, atan2, cos, pi, sin

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.straight_lines import apex_side, cross_face
from geomhw.geodesic.unfolded_faces import Surface, angle, ends, next_corner, triangle

#: A line passes through a vertex if it is nearer, as a share of the edge.
AT_VERTEX = 1e-10
#: Results of a walk: more room is needed, or the line ends by its length, at the boundary, or where it may branch.
FULL, LENGTH, BOUNDARY, BRANCH = range(4)


@compiled_in_place
def walk(
    surface: Surface, h: int, t: float, c: float, distance: float, length: float, faces: Ints, points: Floats
) -> tuple[int, int]:
    """Trace a line that leaves its first face over halfedge h, at the place t and in the direction c along h.

    distance: from the start to there. faces, points: take the points of the line, with the start in ``points[0]``.
    Return their number and why the line ends.
    """
    left, count = length, 1
    faces[0] = h // 3
    s = (1 - c * c) ** 0.5 if abs(c) < 1 else 0.0
    while True:
        # A segment in the face of h, from the last point to the place t on h.
        if count + 2 > len(points):
            return count, FULL
        face = triangle(surface, h)
        f = h // 3
        share = min(t / face.base, 1.0) if face.base > 0 else 0.0
        share = 0.0 if share < AT_VERTEX else 1.0 if share > 1 - AT_VERTEX else share
        part = left / distance if distance > left else 1.0
        for k in range(3):
            v = surface.faces[f, k]
            end = 1 - share if v == face.low else share if v == face.high else 0.0
            points[count, k] = end if part == 1 else (1 - part) * points[count - 1, k] + part * end
        faces[count] = f
        count += 1
        left -= distance
        if left <= 0:
            return count, LENGTH
        if share == 0 or share == 1:
            v = face.low if share == 0 else face.high
            side, inner = _through_vertex(surface, h, v, acos(min(max(-c if share == 0 else c, -1.0), 1.0)))
            if side < 0:
                return count, BOUNDARY if side == -1 else BRANCH
            h, t, c, s, distance = _from_vertex(surface, side, v, inner)
            f = h // 3
        else:
            if surface.sides[h] != 2:
                return count, BOUNDARY if surface.sides[h] == 1 else BRANCH
            g = np.int64(surface.across[h])
            f = g // 3
            ahead = triangle(surface, g)
            h, t, c, s, distance = cross_face(ahead, t, c, s, apex_side(ahead, t, c, s) > 0)
        # The point just passed, in the face that follows.
        for k in range(3):
            points[count - 1, k] = 0.0
        if share == 0 or share == 1:
            for k in range(3):
                points[count - 1, k] = 1.0 if surface.faces[f, k] == v else 0.0
        else:
            for k in range(3):
                u = surface.faces[f, k]
                points[count - 1, k] = 1 - share if u == face.low else share if u == face.high else 0.0
        faces[count - 1] = f


@compiled_in_place
def _through_vertex(surface: Surface, h: int, v: int, back: float) -> tuple[int, float]:
    """Continue a line through a vertex v at the end of halfedge h, with half of the total angle on each side.

    back: angle between h and the line by which it comes, in the face of h. Return the halfedge at which the face of the
    outgoing line begins, and the angle from there; -1 at the boundary, -2 where more than two faces meet.
    """
    count, total = 0, 0.0
    side, end = np.int64(h), np.int64(surface.starts[v + 1] - surface.starts[v])
    while True:
        if surface.sides[side] != 2:
            return (-1 if surface.sides[side] == 1 else -2), 0.0
        corner, other = next_corner(surface, v, side)
        total += angle(surface, corner)
        count += 1
        side = other
        if other // 3 == h // 3 or count > end:
            break
    if count != end:
        return -2, 0.0
    rest = total / 2 - back
    if rest < 0:
        return np.int64(h), -rest
    side = np.int64(h)
    for _ in range(count):
        into = np.int64(surface.across[side])
        corner, other = next_corner(surface, v, side)
        a = angle(surface, corner)
        if rest <= a:
            return into, rest
        rest -= a
        side = other
    return np.int64(h), 0.0


@compiled_in_place
def _from_vertex(surface: Surface, side: int, v: int, inner: float) -> tuple[int, float, float, float, float]:
    """Start a line at a vertex v into the face of a halfedge ``side`` at v, at an angle from it.

    Return the halfedge over which it leaves the face, the place, its direction there, and the distance.
    """
    f = side // 3
    h = 3 * f
    while surface.faces[h // 3, h % 3] != v:
        h += 1
    face = triangle(surface, h)
    low, high = ends(surface, side)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    # The direction to the lower end of h, turned toward the higher end.
    turned = inner if face.low == low + high - v else angle(surface, h) - inner
    lead = pi + atan2(y, x) + turned
    c, s = cos(lead), -sin(lead)
    if s <= 0:
        return (h, 0.0, c, 0.0, face.left) if turned < angle(surface, h) / 2 else (h, face.base, c, 0.0, face.right)
    distance = y / s
    t = min(max(x + c * distance, 0.0), face.base)
    return h, t, c, s, distance
