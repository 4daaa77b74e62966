"""Sources of fast marching: vertices, edges, and points within faces."""

from math import hypot, nan, sqrt

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.marching import March, Side, assign, offer_across
from geomhw.geodesic.unfolded_faces import Surface, triangle
from geomhw.geodesic.vertex_angles import VertexAngles, lay_out


@compiled_in_place
def start(surface: Surface, angles: VertexAngles, march: March, vertices: Ints) -> None:
    """Add source vertices."""
    for v in vertices:
        if march.distance[v] > 0:
            lay_out(surface, angles, v)
            assign(angles, march, v, 0.0, nan, 0.0)
        for h in surface.corners[surface.starts[v] : surface.starts[v + 1]]:
            side = _side(surface, np.int64(h))
            _shine(surface, angles, march, side, side.x, side.y)


@compiled_in_place
def start_from_edges(surface: Surface, angles: VertexAngles, march: March, halfedges: Ints) -> None:
    """Add the edges of halfedges as sources, for their faces; their ends are source vertices."""
    for h in halfedges:
        side = _side(surface, h)
        if side.y > 0 and 0 <= side.x <= side.length:
            offer_across(surface, angles, march, side, side.x, side.y, 0.0)


@compiled_in_place
def start_from_places(surface: Surface, angles: VertexAngles, march: March, places: Floats, faces: Ints) -> None:
    """Add points within faces, (k, 3), as sources: to the corners of their faces, then straight over the sides."""
    for i in range(3 * len(faces)):
        side = _side(surface, 3 * np.int64(faces[i // 3]) + i % 3)
        x, y = _over(surface, side, places[i // 3])
        reach = hypot(side.x - x, side.y - y)
        # The line from the apex through the source meets the side.
        at = side.x + (x - side.x) * side.y / (side.y - y) if side.y > y else x
        offer_across(surface, angles, march, side, at, reach, 1 / reach if reach > 0 else 0.0)
    for i in range(3 * len(faces)):
        side = _side(surface, 3 * np.int64(faces[i // 3]) + i % 3)
        x, y = _over(surface, side, places[i // 3])
        _shine(surface, angles, march, side, x, y)


@compiled_in_place
def _shine(surface: Surface, angles: VertexAngles, march: March, side: Side, x: float, y: float) -> None:
    """Offer straight lines from a point (x, y) of a face over its side to the apexes of the other faces there."""
    g = np.int64(surface.across[side.at_apex])
    while g != side.at_apex:
        other = _side(surface, g)
        at = (other.x * y + x * other.y) / (y + other.y) if y + other.y > 0 else -1.0
        if 0 <= at <= other.length:
            reach = hypot(other.x - x, other.y + y)
            offer_across(surface, angles, march, other, at, reach, 1 / reach)
        g = np.int64(surface.across[g])


@compiled_in_place
def _side(surface: Surface, h: int) -> Side:
    """The side h of its face, as seen from its lower end."""
    face = triangle(surface, h)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    return Side(face.low, face.high, face.apex, face.at_high, face.at_low, h, face.base, x, y)


@compiled_in_place
def _over(surface: Surface, side: Side, place: Floats) -> tuple[float, float]:
    """Coordinates of a point of a face as seen from p over its side."""
    p, q = surface.points[side.p], surface.points[side.q]
    along = across = 0.0
    if side.length > 0:
        for k in range(3):
            along += (place[k] - p[k]) * (q[k] - p[k]) / side.length
    for k in range(3):
        foot = (q[k] - p[k]) * along / side.length if side.length > 0 else 0.0
        across += (place[k] - p[k] - foot) ** 2
    return along, sqrt(across)
