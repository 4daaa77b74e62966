"""Isolines of a piecewise-linear function: ordered polylines with length, and areas where they separate."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints, ranges
from geomhw.curves.level_graph import RIDGE, LevelGraph, barycentric, chains, level_graph
from geomhw.curves.level_regions import separated_areas
from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.geometry import lengths as norms
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import linked_components
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field


@dataclass(frozen=True, eq=False, repr=False)
class Isolines:
    """The p polylines of some levels, with K points together.

    Higher values are on the left of a line, seen from outside. A closed line ends with its first point.

    Attributes
    ----------
    mesh : TriangleMesh
    positions : (K, 3) array
        Coordinates of the points.
    faces : (K,) integer array
        The face of the segment that follows each point; of the last point, the face of the last segment.
    weights : (K, 3) array
        Barycentric coordinates of the points in these faces.
    starts : (p + 1,) integer array
        Line i has the points from ``starts[i]`` to ``starts[i + 1] - 1``.
    levels : (p,) array
        The value on each line, ascending.
    closed : (p,) bool array
    lengths : (p,) array
    areas : (p, 2) array
        Area of the component on the side of lower and of higher values, if the line alone divides it; else NaN.
    """

    mesh: TriangleMesh
    positions: Floats
    faces: Ints
    weights: Floats
    starts: Ints
    levels: Floats
    closed: Ints
    lengths: Floats
    areas: Floats

    def __len__(self) -> int:
        return len(self.levels)

    def __repr__(self) -> str:
        return f"Isolines: {len(self)} lines of length {self.lengths.sum():.6g}"

    @property
    def enclosed_areas(self) -> Floats:
        """Area of the smaller side of each line, (p,); NaN if it does not separate."""
        return np.asarray(self.areas.min(axis=1))

    @property
    def curves(self) -> list[tuple[Ints, Floats]]:
        """Faces and weights of each line, as of `geomhw.mesh.insert_curves`."""
        return [(self.faces[a:b], self.weights[a:b]) for a, b in pairwise(self.starts.tolist())]

    def cloud(self) -> Cloud:
        """Return the lines as polylines.

        Returns
        -------
        Cloud with ``path`` (number of the line), ``face``, ``barycentric`` and ``arc_length`` on points, and ``level``,
        ``length``, ``closed``, ``enclosed_area``, ``area_below`` and ``area_above`` of each line.
        """
        line = np.repeat(np.arange(len(self), dtype=np.int32), np.diff(self.starts))
        steps = np.append(0.0, np.cumsum(norms(np.diff(self.positions, axis=0))))
        fields = [
            Field("path", "vertex", line),
            Field("face", "vertex", self.faces.astype(np.int32)),
            Field("barycentric", "vertex", self.weights),
            Field("arc_length", "vertex", steps - steps[self.starts[:-1]][line]),
            Field("level", "face", self.levels),
            Field("length", "face", self.lengths),
            Field("closed", "face", self.closed.astype(np.uint8)),
            Field("enclosed_area", "face", self.enclosed_areas),
            Field("area_below", "face", self.areas[:, 0]),
            Field("area_above", "face", self.areas[:, 1]),
        ]
        return Cloud(self.positions, fields, self.starts)

    def report(self) -> list[dict[str, Any]]:
        """Return level, length, closedness, areas and number of points of each line as plain JSON values."""
        columns = {
            "level": self.levels.tolist(),
            "length": self.lengths.tolist(),
            "closed": self.closed.astype(bool).tolist(),
            "enclosed_area": _with_none(self.enclosed_areas),
            "area_below": _with_none(self.areas[:, 0]),
            "area_above": _with_none(self.areas[:, 1]),
            "points": np.diff(self.starts).tolist(),
        }
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def isolines(mesh: TriangleMesh, values: ArrayLike, levels: ArrayLike) -> Isolines:
    """Trace the isolines of the function that interpolates vertex values on each face.

    Lines pass through vertices at a level and along edges at a level, each once. Faces with all corners at a level are
    outlined. In each face, the lines of one level have at most one segment. At saddles, lines go round the lower
    values. Lines end at the boundary, at edges of more than two faces, and at faces with a value that is not finite.

    Parameters
    ----------
    mesh : TriangleMesh
    values : (n,) array
        Values at vertices. Faces with a value that is not finite have no isolines.
    levels : array of finite numbers, in any order.

    Raises
    ------
    FieldError
        If there is not one number per vertex.
    ArgumentError
        If there is no level, or one is not finite.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(3)
    >>> circles = isolines(ball, ball.vertices[:, 2], [0.0, 0.5])
    >>> circles.levels.tolist(), circles.closed.tolist(), circles.lengths.round(1).tolist()
    ([0.0, 0.5], [True, True], [6.3, 5.4])
    """
    function, wanted = np.asarray(values, dtype=float), np.unique(np.asarray(levels, dtype=float))
    if function.shape != (mesh.n_vertices,):
        raise FieldError(f"isolines need one number per vertex, ({mesh.n_vertices},), not {function.shape}")
    if not len(wanted) or not np.isfinite(wanted).all():
        raise ArgumentError("isolines need at least one level, a finite number")
    graph = level_graph(mesh, function, wanted)
    return _polylines(mesh, graph, wanted)


def levels_between(mesh: TriangleMesh, one: SurfacePoints, other: SurfacePoints) -> Floats:
    """Return the share of the way from one set of points to another at each vertex: d₁ / (d₁ + d₂) of exact distances.

    It is NaN on components without one of the sets.

    Raises
    ------
    ArgumentError
        If the sets share a vertex.
    FieldError
        If no path leads from one to the other.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> square = grid(2, 2)
    >>> levels_between(square, vertex_points(square, [0, 3, 6]), vertex_points(square, [2, 5, 8]))[:3].tolist()
    [0.0, 0.5, 1.0]
    """
    solver = ExactDistance(mesh)
    near, far = (np.asarray(solver.from_sources(points)["distance"]) for points in (one, other))
    if ((near == 0) & (far == 0)).any():
        shared = int(np.flatnonzero((near == 0) & (far == 0))[0])
        raise ArgumentError(f"both sets contain vertex {shared}; between them there must be a distance")
    way = near + far
    if not np.isfinite(way).any():
        raise FieldError("no path leads from one set to the other: they lie on different components")
    return np.asarray(np.divide(near, way, out=np.full(len(way), np.nan), where=np.isfinite(way)))


def _polylines(mesh: TriangleMesh, graph: LevelGraph, levels: Floats) -> Isolines:
    """Return the chains of links as polylines, by level."""
    order, starts, opened = chains(graph.partners)
    sizes = np.diff(starts)
    votes = np.add.reduceat(graph.turns[order // 2] * np.where(order % 2, -1, 1), starts[:-1]) if len(order) else sizes
    ranked = np.lexsort((starts[:-1], graph.levels[order[starts[:-1]] // 2]))
    # Points: the entry of each link, and the exit of the last.
    sequences = _sequences(starts, votes < 0, ranked)
    entries = np.where(np.repeat(votes[ranked] < 0, sizes[ranked]), order[sequences] ^ 1, order[sequences])
    begins = np.append(0, np.cumsum(sizes[ranked]))
    last = begins[1:] - 1
    places = np.insert(entries, begins[1:], entries[last] ^ 1)
    begins = begins + np.arange(len(begins))
    nodes, link = graph.links.ravel()[places], places // 2
    ends, share = graph.ends[nodes], graph.shares[nodes]
    X = mesh.vertices
    positions = (1 - share)[:, None] * X[ends[:, 0]] + share[:, None] * X[ends[:, 1]]
    closed = ranked >= opened
    line = np.repeat(np.arange(len(ranked)), np.diff(begins))
    moves = np.append((line[1:] == line[:-1]) & (positions[1:] != positions[:-1]).any(axis=1), False)[: len(line)]
    # Segments of zero length, in faces of zero area, join points on different edges; lines of no other segments go.
    real = np.bincount(line[moves], minlength=len(ranked)) > 0
    kept = real[line]
    regions = _line_regions(graph, entries // 2, begins - np.arange(len(begins)))
    face = graph.faces[link[kept]]
    steps = norms(np.diff(positions, axis=0, append=positions[-1:])) if len(positions) else np.empty(0)
    steps[begins[1:] - 1] = 0.0
    return Isolines(
        mesh,
        positions[kept],
        face,
        barycentric(mesh.faces[face], ends[kept], share[kept]),
        np.append(0, np.cumsum(np.diff(begins)[real])),
        levels[graph.levels[link[begins[:-1]]]][real],
        closed[real],
        np.asarray(np.bincount(line, steps, len(ranked)), dtype=float)[real],
        regions[real],
    )


def _sequences(starts: Ints, reversed_: Ints, ranked: Ints) -> Ints:
    """Return the indices of the links of chains in the order of ``ranked``, some of them backward."""
    sizes = np.diff(starts)[ranked]
    rank = ranges(np.zeros_like(sizes), sizes)
    back = np.repeat(reversed_[ranked], sizes)
    rank = np.where(back, np.repeat(sizes, sizes) - 1 - rank, rank)
    return np.asarray(np.repeat(starts[:-1][ranked], sizes) + rank)


def _line_regions(graph: LevelGraph, links: Ints, starts: Ints) -> Floats:
    """Return the areas below and above each line, (p, 2); regions on one side of a line are one."""
    count, size = len(starts) - 1, len(graph.areas)
    line = np.repeat(np.arange(count), np.diff(starts))
    sides = graph.regions[links].astype(np.int64)
    for k in (0, 1):  # outside of the mesh, a region of each line
        sides[:, k] = np.where(sides[:, k] < 0, size + line, sides[:, k])
    kinds = graph.kinds[links[starts[:-1]]]
    proper = kinds[line] != RIDGE
    ridge = ~proper
    one = np.concatenate([*(sides[starts[:-1]][line][proper, k] for k in (0, 1)), sides[ridge, 0]])
    other = np.concatenate([*(sides[proper, k] for k in (0, 1)), sides[ridge, 1]])
    merged = linked_components(one, other, size + count)
    areas = np.asarray(np.bincount(merged, np.append(graph.areas, np.zeros(count))), dtype=float)
    ends = merged[sides[starts[:-1]]] if count else np.empty((0, 2), dtype=np.int64)
    ends[kinds == RIDGE] = -1
    return separated_areas(areas, ends)


def _with_none(values: Floats) -> list[float | None]:
    """Return a list with None in place of NaN."""
    return [None if np.isnan(value) else value for value in values.tolist()]
