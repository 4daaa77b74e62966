"""Angles of the edges around vertices, laid out when first needed: each vertex has polar coordinates for directions."""

from math import inf, isinf, pi
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.unfolded_faces import Surface, angle, ends, next_corner

#: ``turns`` of a vertex on the boundary, with one open fan.
OPEN = -1.0


class VertexAngles(NamedTuple):
    """Angles at the vertex opposite each halfedge, and the whole angle of each vertex.

    to_low, to_high: (3m,), angles of the edges to the lower and the higher end of the halfedge, around their vertex.
    turns: (n,), the sum of the angles of a closed fan of faces, OPEN for an open fan, inf where the faces are no single
    fan, so that directions there have no angles, and 0 until `lay_out`.
    """

    to_low: Floats
    to_high: Floats
    turns: Floats


def no_angles(surface: Surface) -> VertexAngles:
    """Return angles of which none is computed. Most memory is used only once it is written to."""
    h = surface.faces.size
    return VertexAngles(np.zeros(h), np.zeros(h), np.zeros(len(surface.points)))


@compiled_in_place
def lay_out(surface: Surface, angles: VertexAngles, v: int) -> None:
    """Compute the angles at a vertex."""
    if angles.turns[v] == 0:
        angles.turns[v] = _lay_out(surface, angles, v)


@compiled_in_place
def lay_out_all(surface: Surface, angles: VertexAngles) -> None:
    """Compute the angles at all vertices, before threads share them."""
    for v in range(len(angles.turns)):
        if surface.starts[v] < surface.starts[v + 1]:
            lay_out(surface, angles, v)


@compiled_in_place
def _lay_out(surface: Surface, angles: VertexAngles, v: int) -> float:
    """Fill in the angles of the edges at a vertex, and return its ``turns``."""
    number = surface.starts[v + 1] - surface.starts[v]
    first = np.int64(surface.corners[surface.starts[v]])
    corner, begin, closed = first, _next_side(first), False
    for _ in range(number):  # back to the boundary, if there is one
        if surface.sides[begin] != 2:
            break
        corner, begin = next_corner(surface, v, begin)
        if corner == first:
            closed = True
            break
    total = 0.0
    for count in range(number):
        low, high = ends(surface, begin)
        after = total + angle(surface, corner)
        begins_low = low + high - v == ends(surface, corner)[0]
        angles.to_low[corner] = total if begins_low else after
        angles.to_high[corner] = after if begins_low else total
        total, side = after, 3 * (corner // 3) + 3 - corner % 3 - begin % 3
        if count + 1 == number:
            is_fan = total > 0 and (closed or surface.sides[side] == 1)
            return (total if closed else OPEN) if is_fan else inf
        if surface.sides[side] != 2:
            return inf
        corner, other = next_corner(surface, v, side)
        begin = 3 * (corner // 3) + 3 - corner % 3 - other % 3
    return inf


@compiled_in_place
def _next_side(corner: int) -> int:
    """One of the two sides at a corner."""
    return 3 * (corner // 3) + (corner % 3 + 1) % 3


@compiled_in_place
def edge_angle(angles: VertexAngles, corner: int, end: int, other: int) -> float:
    """Angle of the edge to one end of a halfedge, around the vertex opposite of it. other: the other end."""
    return angles.to_low[corner] if end < other else angles.to_high[corner]


@compiled_in_place
def behind(angles: VertexAngles, v: int, direction: float, corner: int, end: int, other: int) -> float:
    """Angle at v from its edge to another vertex to a direction, through the faces on the other side of that edge.

    corner: halfedge opposite v in the face on this side of the edge, whose third vertex is other. Negative, or NaN, if
    there is no such angle.
    """
    edge, away = edge_angle(angles, corner, end, other), edge_angle(angles, corner, other, end)
    turn = edge - direction if away > edge else direction - edge
    return turn + angles.turns[v] if turn < 0 < angles.turns[v] else turn


@compiled_in_place
def least_turn(angles: VertexAngles, v: int, direction: float, corner: int, end: int, other: int) -> float:
    """Angle beyond pi between a direction at v and its edge to another vertex, on the side where it is less.

    Negative where a path from there along the edge is not a shortest one; inf where the faces are no single fan, and
    NaN without a direction. On the boundary only the side within the faces counts. At a vertex of an angle below 2 pi,
    it is 0 between the straight continuations on both sides, which cross. Arguments as of `behind`.
    """
    if isinf(angles.turns[v]):
        return inf
    turn = abs(edge_angle(angles, corner, end, other) - direction) - pi
    if angles.turns[v] < 0:
        return turn
    defect = 2 * pi - angles.turns[v]
    turn = min(turn, -defect - turn)
    return min(turn + defect, 0.0) if defect > 0 else turn
