"""Whether another shortest path leads to a vertex: the vertex lies on the cut locus of the sources."""

from collections.abc import Callable
from math import pi

import numpy as np

from geomhw.geodesic.exact import Arrivals
from geomhw.geodesic.strips import Crossings, Strip, positions, straightened
from geomhw.geodesic.unfolded_faces import Surface
from geomhw.geodesic.vertex_fans import VertexFan, vertex_fan

#: Returns the strip of the last straight line of the path to a vertex and its origin, or None.
Traced = Callable[[Surface, Arrivals, int], tuple[Strip, int] | None]
#: Lengths that agree up to this share are equal.
EQUAL = 1e-10
#: Paths that arrive at a smaller angle, in radians, are the same.
APART = 1e-6


def arrival_angle(surface: Surface, fan: VertexFan, strip: Strip, found: Crossings) -> float:
    """Return the angle in the fan of a vertex at which the path in a strip comes to it, as seen from the vertex."""
    x = positions(surface, strip, found)
    steps = x - x[-1]
    far = np.flatnonzero(np.linalg.norm(steps, axis=1) > EQUAL * max(found.length, np.finfo(float).tiny))
    return fan.angle_of(surface, strip.last, steps[far[-1]]) if len(far) else 0.0


def is_tied(
    surface: Surface, arrivals: Arrivals, v: int, line: tuple[Strip, Crossings], origin: int, traced: Traced
) -> bool:
    """Return whether a path to v other than by a line is as short, among those beside the paths to its neighbors.

    traced: returns the strip of the last straight line of the path to a vertex, and its origin.
    """
    fan = vertex_fan(surface, v)
    if not fan.complete or fan.total == 0:
        return False
    arrival = arrival_angle(surface, fan, *line)
    for u in fan.first_ends(surface):
        if np.isinf(arrivals.distance[u]) or not (last := traced(surface, arrivals, u)) or last[1] == v:
            continue
        for corner in fan.corners:
            if u in surface.faces[corner // 3] and (longer := last[0].extended(surface, u, corner // 3, v)):
                longer, found = straightened(surface, longer)
                if arrivals.distance[last[1]] + found.length <= arrivals.distance[v] * (1 + EQUAL):
                    apart = abs(arrival_angle(surface, fan, longer, found) - arrival)
                    if APART < apart < (fan.total - APART if fan.closed else pi * 4):
                        return True
    return False
