"""Fast marching with rays: each vertex has a distance, a direction to the source, and the curvature of the front.

The vertex of least distance is visited next. In each of its faces it offers its neighbors paths along the edges, and
rays across the sides to visited ones. The rays at both ends of a side lie on lines that meet in the center of the
front: behind the side, or ahead of it where the front converges. The line from the center to the third vertex of the
face is its ray. Where two fronts meet on a side, each end offers its own. A vertex whose distance decreases is visited
again. On flat surfaces all rays are exact.

Kimmel, Sethian: Computing Geodesic Paths on Manifolds. PNAS 95(15), 1998.
Trettner, Bommes, Kobbelt: Geodesic Distance Computation via Virtual Source Propagation. Comput. Graph. Forum 40(5),
2021.
Potter, Cameron: Jet Marching Methods for Solving the Eikonal Equation. SIAM J. Sci. Comput. 43(6), 2021.
"""

from math import acos, atan2, cos, hypot, inf, isinf, isnan, nan, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place, compiled_inline
from geomhw.geodesic.front import TOUCHED, WAITING, Extent, limit_at, pop, push, touch
from geomhw.geodesic.unfolded_faces import Surface, triangle
from geomhw.geodesic.vertex_angles import VertexAngles, behind, edge_angle, lay_out, least_turn

#: A ray at a smaller angle with a side does not cross it. A path that turns by less at a vertex is straight. Radians.
GRAZING, STRAIGHT = 1e-9, 1e-6
#: Two fronts meet on a side where the curvature of one front through both ends, times the length of the side, would be
#: less than that at the ends by more, or where rays would cross before this share of the way.
SHOCK, CROSSED = 0.03, 0.2
#: A distance is replaced if the new one is less by more than this share, which grows by a factor with each visit of the
#: vertex, so that visits end.
TOLERANCE, GROWTH = 1e-9, 1.5


class March(NamedTuple):
    """State of one query.

    distance: (n,). direction: (n,), angle of the direction to the source, as in `VertexAngles`, NaN where there is no
    ray. curvature: (n,), of the front, 1/length, negative where it converges. tolerance: (n,), see TOLERANCE. keys,
    items, places, counts, touched: queue of vertices, and those with a distance, as in `Front`.
    """

    distance: Floats
    direction: Floats
    curvature: Floats
    tolerance: Floats
    counts: Ints
    keys: Floats
    items: Ints
    places: Ints
    touched: Ints


class Side(NamedTuple):
    """A side pq of a face, as seen from p: its length, and the apex at (x, y), where q is on the positive x axis.

    at_p, at_q, at_apex: halfedges opposite p, q and the apex.
    """

    p: int
    q: int
    apex: int
    at_p: int
    at_q: int
    at_apex: int
    length: float
    x: float
    y: float


def empty_march(surface: Surface) -> March:
    """Return a state without sources. Most memory is used only once it is written to."""
    n = len(surface.points)
    queue = np.empty(n), np.empty(n, dtype=np.int32), np.zeros(n, dtype=np.int32), np.empty(n, dtype=np.int32)
    return March(np.full(n, inf), np.empty(n), np.empty(n), np.empty(n), np.zeros(5, dtype=np.int64), *queue)


@compiled_in_place
def raise_to_chords(surface: Surface, march: March, x: float, y: float, z: float) -> None:
    """Raise distances from one source (x, y, z) to those along the straight line."""
    for v in march.touched[: march.counts[TOUCHED]]:
        p = surface.points[v]
        chord = sqrt((p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2)
        march.distance[v] = max(march.distance[v], chord)


@compiled_in_place
def reset(march: March) -> None:
    """Remove sources and distances; the time is proportional to their number."""
    for v in march.touched[: march.counts[TOUCHED]]:
        march.distance[v] = inf
    for v in march.items[: march.counts[WAITING]]:
        march.places[v] = 0
    march.counts[:] = 0


@compiled_in_place
def propagate(surface: Surface, angles: VertexAngles, march: March, within: Extent, targets: Ints) -> float:
    """March up to the limit or until all targets are final; return the radius of final distances.

    Over a long side, a ray reaches a vertex that is nearer than the ends of the side. So vertices somewhat beyond the
    limit are visited for what they offer across sides.
    """
    done, limit = 0, within.limit
    while march.counts[WAITING]:
        v, key = np.int64(march.items[0]), march.keys[0]
        pop(march)
        while done < len(targets) and march.distance[targets[done]] <= key:
            done += 1
            if done == len(targets):
                limit = _largest(march, targets)
        beyond = key - min(limit, limit_at(within, v))
        if beyond <= 0 or beyond <= _longest(surface, v):
            march.tolerance[v] *= GROWTH
            for h in surface.corners[surface.starts[v] : surface.starts[v + 1]]:
                _enter(surface, angles, march, np.int64(h), beyond <= 0)
    return _largest(march, targets) if 0 < len(targets) == done else limit


@compiled_in_place
def _largest(march: March, vertices: Ints) -> float:
    """Largest distance of some vertices."""
    largest = 0.0
    for v in vertices:
        largest = max(largest, march.distance[v])
    return largest


@compiled_in_place
def _longest(surface: Surface, v: int) -> float:
    """Length of the longest edge at a vertex."""
    longest = 0.0
    for h in surface.corners[surface.starts[v] : surface.starts[v + 1]]:
        face = triangle(surface, np.int64(h))
        longest = max(longest, face.left, face.right)
    return longest


@compiled_inline
def _enter(surface: Surface, angles: VertexAngles, march: March, h: int, along: bool) -> None:
    """March from the vertex opposite a halfedge h into its face: across two sides, and along them if wanted."""
    face = triangle(surface, h)
    low, high, left, right = face.low, face.high, face.left, face.right
    cosine = face.sin_low * face.sin_high - face.cos_low * face.cos_high
    sine = face.sin_low * face.cos_high + face.cos_low * face.sin_high
    if along:
        _along(surface, angles, march, face.apex, low, h, face.at_high, high, left)
        _along(surface, angles, march, face.apex, high, h, face.at_low, low, right)
    if sine > 0 and left > 0 and right > 0:
        to_low, to_high, v = face.at_low, face.at_high, face.apex
        _across(surface, angles, march, Side(v, low, high, h, to_high, to_low, left, right * cosine, right * sine))
        _across(surface, angles, march, Side(v, high, low, h, to_low, to_high, right, left * cosine, left * sine))


@compiled_inline
def _along(
    surface: Surface,
    angles: VertexAngles,
    march: March,
    v: int,
    w: int,
    at_v: int,
    at_w: int,
    other: int,
    length: float,
) -> None:
    """Offer w the path along the edge from v, in a face.

    at_v, at_w: halfedges opposite v and w. other: the third vertex. A path with less than pi on one side of v is not a
    shortest one: it is an upper bound, and no ray.
    """
    reach = march.distance[v] + length
    if _is_less(angles, march, w, reach, False):
        lay_out(surface, angles, w)
        is_source = march.distance[v] == 0
        turn = 0.0 if is_source else least_turn(angles, v, march.direction[v], at_v, w, other)
        direction = edge_angle(angles, at_w, v, other) if is_source or turn >= -STRAIGHT else nan
        bend = march.curvature[v]
        bend = 1 / length if (is_source or turn > STRAIGHT) and length > 0 else bend / (1 + bend * length)
        assign(angles, march, w, reach, direction, bend)


@compiled_inline
def _across(surface: Surface, angles: VertexAngles, march: March, side: Side) -> None:
    """Offer the apex of a face the rays that cross one of its sides."""
    p, q, base, x, y = side.p, side.q, side.length, side.x, side.y
    one, other, known = march.distance[p], march.distance[q], march.distance[side.apex]
    nearest = min(max((base + one - other) / 2, 0.0), base)
    is_waiting = march.places[q] != 0
    if is_waiting or known <= one - nearest + sqrt((x - nearest) ** 2 + y * y):
        return  # q will come here when it is visited; or see `_offer_ray`
    # Angles of the rays at both ends with the side.
    a = behind(angles, p, march.direction[p], side.at_p, q, side.apex)
    b = behind(angles, q, march.direction[q], side.at_q, p, side.apex)
    if isinf(angles.turns[p]):
        a = _angle(one, other, base)
    if isinf(angles.turns[q]):
        b = _angle(other, one, base)
    from_p, from_q = GRAZING < a < pi - GRAZING, GRAZING < b < pi - GRAZING
    if from_p and from_q:
        sin_a, cos_a, sin_b, cos_b = sin(a), cos(a), sin(b), cos(b)
        bend = (cos_a / sin_a + cos_b / sin_b) / base  # 1 / depth of the center of the front behind the side
        spread = 1 + bend * y
        at = (x + y * cos_a / sin_a) / spread
        slope = bend * at - cos_a / sin_a
        stretch = sqrt(1 + slope * slope)
        mean = (march.curvature[p] + march.curvature[q]) / 2
        if spread > CROSSED and (bend / stretch - mean) * base > -SHOCK:
            if 0 <= at <= base:
                late = _lag(x, y, -cos_a, sin_a, bend * sin_a)
                later = _lag(base - x, y, -cos_b, sin_b, bend * sin_b)
                reach = one + late + at / base * (other + later - one - late)
                _offer_ray(surface, angles, march, side, at, reach, bend / (spread * stretch))
            return
    if from_p:
        at, reach, bend = _from_end(x, y, a, march.curvature[p])
        if 0 <= at <= base:
            _offer_ray(surface, angles, march, side, at, one + reach, bend)
    if from_q:
        at, reach, bend = _from_end(base - x, y, b, march.curvature[q])
        if 0 <= at <= base:
            _offer_ray(surface, angles, march, side, base - at, other + reach, bend)


@compiled_inline
def _angle(one: float, other: float, base: float) -> float:
    """Angle at one end of a side in the triangle with the source, of three lengths; NaN where there is none."""
    cosine = (base * base + (one - other) * (one + other)) / (2 * one * base)
    return acos(cosine) if abs(cosine) < 1 else nan


@compiled_inline
def _from_end(x: float, y: float, a: float, curvature: float) -> tuple[float, float, float]:
    """The ray to (x, y) of a front of some curvature, whose ray at the origin has an angle a with the x axis.

    Return where it crosses the x axis, -1 if it does not, how much later it arrives, and the curvature there.
    """
    dx, dy = curvature * x - cos(a), curvature * y + sin(a)
    if dy <= 0 or 1 + curvature * (y * sin(a) - x * cos(a)) <= 0:
        return -1.0, inf, 0.0
    return x - y * dx / dy, _lag(x, y, -cos(a), sin(a), curvature), curvature / hypot(dx, dy)


@compiled_inline
def _lag(x: float, y: float, ex: float, ey: float, curvature: float) -> float:
    """How much later a front arrives at (x, y) than at the origin, where it moves along the unit vector e."""
    along, square = x * ex + y * ey, x * x + y * y
    root = sqrt(max(1 + 2 * curvature * along + curvature * curvature * square, 0.0))
    return (curvature * square + 2 * along) / (root + 1)


@compiled_inline
def _offer_ray(
    surface: Surface, angles: VertexAngles, march: March, side: Side, at: float, reach: float, bend: float
) -> None:
    """Offer the apex over a side a distance by a ray from behind the side.

    Along a path, the distance decreases by at most the length of the path. So the distances of p and q bound this one
    from below.
    """
    before = max(march.distance[side.p] - at, march.distance[side.q] - side.length + at)
    offer_across(surface, angles, march, side, at, max(reach, before + hypot(side.x - at, side.y)), bend)


@compiled_inline
def offer_across(
    surface: Surface, angles: VertexAngles, march: March, side: Side, at: float, reach: float, bend: float
) -> None:
    """Offer the apex over a side a distance by a ray on the line that crosses the side at a distance from p."""
    if _is_less(angles, march, side.apex, reach, True):
        lay_out(surface, angles, side.apex)
        inner = atan2(side.y * at, side.y * side.y - side.x * (at - side.x))
        begin = edge_angle(angles, side.at_apex, side.p, side.q)
        end = edge_angle(angles, side.at_apex, side.q, side.p)
        assign(angles, march, side.apex, reach, begin + inner if end > begin else begin - inner, bend)


@compiled_inline
def _is_less(angles: VertexAngles, march: March, v: int, reach: float, by_ray: bool) -> bool:
    """Whether a vertex takes a distance: it is less than its own, or equal and by a ray where that is by none."""
    known = march.distance[v]
    if known == inf:
        return reach < inf
    is_bound = isnan(march.direction[v]) and known > 0 and angles.turns[v] < inf
    if by_ray and is_bound and march.tolerance[v] < 1:
        return reach <= known
    return reach < known * (1 - march.tolerance[v])


@compiled_inline
def assign(angles: VertexAngles, march: March, v: int, reach: float, direction: float, bend: float) -> None:
    """Give a vertex a distance, the direction to the source, NaN for none, and the curvature of the front."""
    if march.distance[v] == inf:
        touch(march, v)
        march.tolerance[v] = TOLERANCE
    march.distance[v], march.curvature[v] = reach, bend
    march.direction[v] = direction if reach > 0 and angles.turns[v] < inf else nan
    push(march, v, reach)
