"""Directions in which the shortest paths from one vertex start."""

from math import atan2, nan
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.exact import EQUAL, Arrivals, ExactDistance
from geomhw.geodesic.shortest_paths import traced_path
from geomhw.geodesic.straight_lines import CROSSING, line_to_origin
from geomhw.geodesic.unfolded_faces import Surface, angle, triangle
from geomhw.geodesic.vertex_fans import VertexFan


def start_directions(solver: ExactDistance, arrivals: Arrivals, fan: VertexFan) -> Floats:
    """Return the angle in a fan at which the path to each vertex starts, (n,), radians; NaN where no path leads.

    arrivals: from the vertex of the fan.
    """
    surface, v = solver.surface, fan.vertex
    place_in_fan = np.full(surface.faces.size, -1)
    place_in_fan[fan.corners] = np.arange(len(fan.corners))
    begins, firsts = np.array(fan.begins), np.array(fan.first_ends(surface))
    order = np.argsort(arrivals.distance, kind="stable")
    order = order[np.isfinite(arrivals.distance[order])]
    found, line = np.full(len(surface.points), nan), np.empty(1024, dtype=CROSSING)
    found[v], done = 0.0, 0
    while done < len(order):
        done = _directions(surface, *arrivals_of(arrivals), order, done, v, place_in_fan, begins, firsts, found, line)
        if done < 0:
            line, done = np.empty(4 * len(line), dtype=CROSSING), -1 - done
        elif done < len(order):  # the line is lost
            found[order[done]] = _along_path(solver, arrivals, fan, int(order[done]))
            done += 1
    for u in order[np.isnan(found[order])].tolist():  # where edges of length zero have no order
        found[u] = _along_path(solver, arrivals, fan, u)
    return found


def _along_path(solver: ExactDistance, arrivals: Arrivals, fan: VertexFan, v: int) -> float:
    """Return the angle of the first segment of a path that has a length; NaN if that is at another vertex."""
    path = traced_path(solver, arrivals, v)
    steps = np.diff(path.positions, axis=0)
    first = int(np.flatnonzero(np.append(steps.any(axis=1), True))[0])
    at = path.weights[first] == 1
    if first == len(steps) or fan.vertex not in path.mesh.faces[path.faces[first], at]:
        return nan
    return fan.angle_of(solver.surface, int(path.faces[first]), steps[first])


def arrivals_of(arrivals: Arrivals) -> tuple[Floats, Ints, Ints, Floats]:
    """Return the arrays of arrivals."""
    return arrivals.distance, arrivals.origin, arrivals.halfedge, arrivals.entry


@compiled_in_place
def _directions(
    surface: Surface,
    distance: Floats,
    origin: Ints,
    halfedge: Ints,
    entry: Floats,
    order: Ints,
    begin: int,
    source: int,
    place_in_fan: Ints,
    begins: Floats,
    firsts: Ints,
    found: Floats,
    line: Any,
) -> int:
    """Set the angles of the vertices of ``order``, by distance, from number ``begin`` on.

    Return the number of the first vertex whose line is lost, the number of vertices if there is none, or -1-i if
    ``line`` has no room for vertex i.
    """
    for i in range(begin, len(order)):
        v = order[i]
        if v == source:
            continue
        h, t, start = np.int64(halfedge[v]), entry[v], np.int64(origin[v])
        if h >= 0:
            # A line that arrives over the end of an edge comes along another edge.
            face = triangle(surface, h)
            if abs(t) <= EQUAL * face.base and distance[face.low] + face.left <= distance[v] * (1 + EQUAL):
                start, h = face.low, -1
            elif abs(t - face.base) <= EQUAL * face.base and distance[face.high] + face.right <= distance[v] * (
                1 + EQUAL
            ):
                start, h = face.high, -1
        if start != source:
            found[v] = found[start]
        elif h < 0:
            found[v] = _of_edge(surface, source, v, place_in_fan, begins, firsts)
        else:
            count = line_to_origin(surface, h, t, source, distance[v], line)
            if count < 0:
                return -1 - i
            if count == 0:
                return i
            g, t = np.int64(line[count - 1].enter), line[count - 1].place
            face = triangle(surface, g)
            k = place_in_fan[g]
            if face.apex == source and k >= 0:
                x, y = face.left * face.cos_low, face.left * face.sin_low
                turned = atan2(t * y, x * (x - t) + y * y)
                found[v] = begins[k] + (turned if firsts[k] == face.low else angle(surface, g) - turned)
            else:
                found[v] = _of_edge(surface, source, face.low + face.high - source, place_in_fan, begins, firsts)
    return len(order)


@compiled_in_place
def _of_edge(surface: Surface, source: int, v: int, place_in_fan: Ints, begins: Floats, firsts: Ints) -> float:
    """Angle of the edge from the source to v."""
    for i in range(surface.starts[source], surface.starts[source + 1]):
        h = np.int64(surface.corners[i])
        f = h - h % 3
        k = place_in_fan[h]
        for g in range(f, f + 3):
            if k >= 0 and g != h and surface.faces[g // 3, g % 3] == v:
                return begins[k] if firsts[k] == v else begins[k] + angle(surface, h)
    return nan
