"""Shortest paths on polyhedral surfaces, traced back along the straight lines of exact distances.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
"""

from dataclasses import replace
from heapq import heappop, heappush

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FieldError
from geomhw.geodesic.cut_locus import is_tied
from geomhw.geodesic.exact import EQUAL, Arrivals, ExactDistance
from geomhw.geodesic.nearest_border import nearest_starts
from geomhw.geodesic.straight_lines import CROSSING, line_to_origin
from geomhw.geodesic.strips import Strip, straightened
from geomhw.geodesic.surface_path import SurfacePath, joined, on_original, path_in_strip
from geomhw.geodesic.unfolded_faces import Surface
from geomhw.mesh.inserted_points import InsertedPoints, insert_points
from geomhw.mesh.named_points import face_points, vertex_points
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.topology import vertex_components
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Length, in mean edge lengths, of edges that join vertices in one place.
_ONE_PLACE = 1e-4


class ShortestPaths:
    """Shortest paths on one mesh.

    The length of a path is the exact distance. A path is straight across edges, and turns only at vertices with a total
    angle of at least 2π or where the mesh is no surface: on the boundary and at edges of more than two faces.

    Parameters
    ----------
    mesh : any triangle mesh. Paths pass as those of `ExactDistance`.
    ties : whether to look for other shortest paths to the same end, which takes several times as long.

    Raises
    ------
    MeshError
        As `ExactDistance` does.

    Examples
    --------
    >>> from geomhw.mesh import TriangleMesh, vertex_points
    >>> square = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> (path,) = ShortestPaths(square).between(vertex_points(square, [1]), vertex_points(square, [3]))
    >>> path.positions.round(6).tolist()
    [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]]
    """

    def __init__(self, mesh: TriangleMesh, ties: bool = False) -> None:
        self.mesh, self.ties = mesh, ties
        self._solver: ExactDistance | None = None

    def to_nearest(self, sources: SurfacePoints, targets: SurfacePoints) -> list[SurfacePath]:
        """Return, for each target, the shortest path from the nearest source; from a filled region, from its border.

        Raises
        ------
        FieldError
            If no path leads to a target, or a point lies inside a face of zero area.
        """
        points = _Points(self, concatenate([sources, targets]))
        ends = points.vertices[len(sources) :]
        if sources.filled.any():
            return self.between(points.nearest_starts(sources, targets), targets)
        arrivals = points.arrivals(points.vertices[: len(sources)], ends)
        return [points.path(arrivals, v, targets.name(i)) for i, v in enumerate(ends.tolist())]

    def between(self, sources: SurfacePoints, targets: SurfacePoints) -> list[SurfacePath]:
        """Return the shortest path from each source to the target of the same index; raises as `to_nearest`."""
        paths = self.by_pair(sources, targets)
        return [paths[i] for i in range(len(sources))]

    def by_pair(
        self, sources: SurfacePoints, targets: SurfacePoints, part: slice = slice(None)
    ) -> dict[int, SurfacePath]:
        """Return the paths of `between` from a part of the sources by their index; all parts give the same paths.

        Parameters
        ----------
        part : selects distinct sources. Parts are independent computations on one mesh with all points inserted.
        """
        if len(sources) != len(targets):
            raise FieldError(f"pairs need as many targets as sources, not {len(targets)} for {len(sources)}")
        points = _Points(self, concatenate([sources, targets]))
        starts, ends = points.vertices[: len(sources)], points.vertices[len(sources) :]
        paths: dict[int, SurfacePath] = {}
        for source in np.unique(starts)[part]:
            (group,) = np.nonzero(starts == source)
            arrivals = points.arrivals(np.array([source]), ends[group])
            paths |= {i: points.path(arrivals, int(ends[i]), targets.name(i)) for i in group.tolist()}
        return paths

    def through(self, stops: SurfacePoints, closed: bool = False) -> SurfacePath:
        """Return the path of shortest paths from each point to the next, if closed from the last to the first, too.

        Raises
        ------
        FieldError
            As `to_nearest` does, and if there are fewer than two points.
        """
        if len(stops) < 2:
            raise FieldError("a path through points needs at least two")
        order = np.arange(len(stops))
        starts, ends = (order, np.roll(order, -1)) if closed else (order[:-1], order[1:])
        return joined(self.between(stops[starts], stops[ends]))

    def exact(self) -> ExactDistance:
        """Return the solver for distances on the mesh."""
        self._solver = self._solver or ExactDistance(self.mesh)
        return self._solver


class _Points:
    """Points as vertices of a mesh, which is another one if some lie within faces."""

    def __init__(self, paths: ShortestPaths, points: SurfacePoints) -> None:
        self._mesh, self._ties = paths.mesh, paths.ties
        self._inserted: InsertedPoints | None = None
        if len(points.within_faces):
            self._inserted = insert_points(paths.mesh, points)
            self._solver, self.vertices = ExactDistance(self._inserted.mesh), self._inserted.vertices
        else:
            self._solver, self.vertices = paths.exact(), points.vertices

    def arrivals(self, sources: Ints, targets: Ints) -> Arrivals:
        """Return the straight lines by which the targets are reached, and all vertices on the paths there."""
        mesh = self._solver.mesh
        return self._solver.arrivals(vertex_points(mesh, sources), targets=_in_one_place(mesh, targets))

    def nearest_starts(self, sources: SurfacePoints, targets: SurfacePoints) -> SurfacePoints:
        """Return the point of the sources, filled regions among them, nearest to each target."""
        starts, ends = self.vertices[: len(sources)], self.vertices[len(sources) :]
        region = np.zeros(self._mesh.n_vertices, dtype=bool)
        region[sources.filled_vertices] = True
        inside = ends[((targets.weights == 0) | region[targets.corners]).all(axis=1)]
        filled = np.concatenate([starts[sources.filled], inside])
        named = np.unique(np.concatenate([starts, filled]))
        mesh = self._solver.mesh
        given = replace(vertex_points(mesh, named), filled=np.isin(named, filled))
        arrivals = self._solver.arrivals(given, targets=_in_one_place(mesh, ends))
        for i, v in enumerate(ends.tolist()):
            _require_path(arrivals, v, targets.name(i))
        faces, weights = nearest_starts(mesh, arrivals, ends)
        if self._inserted:
            weights = np.einsum("kc,kcx->kx", weights, self._inserted.corners[faces])
            faces = self._inserted.parents[faces]
        return face_points(self._mesh, faces, weights)

    def path(self, arrivals: Arrivals, v: int, name: str) -> SurfacePath:
        """Trace the path to a vertex back to its source."""
        _require_path(arrivals, v, name)
        path = traced_path(self._solver, arrivals, v, self._ties)
        return on_original(self._mesh, self._inserted, path) if self._inserted else path


def _in_one_place(mesh: TriangleMesh, vertices: Ints) -> Ints:
    """Add the vertices that very short edges join to given ones: a path may arrive through any of them."""
    joined_edges = mesh.edges[mesh.edge_lengths <= _ONE_PLACE * mesh.mean_edge_length]
    if not len(joined_edges):
        return vertices
    label = vertex_components(joined_edges, mesh.n_vertices)
    return np.flatnonzero(np.isin(label, label[vertices]))


def _require_path(arrivals: Arrivals, v: int, name: str) -> None:
    """Raise FieldError if a vertex has no distance."""
    if np.isinf(arrivals.distance[v]):
        raise FieldError(f"no path leads to {name}: it lies on another component than the sources")


def traced_path(solver: ExactDistance, arrivals: Arrivals, v: int, ties: bool = False) -> SurfacePath:
    """Return the shortest path to a vertex, from its source on; ties: whether to look for another one."""
    surface, parts = solver.surface, list[SurfacePath]()
    if arrivals.distance[v] == 0:
        corner = int(surface.corners[surface.starts[v]])
        return SurfacePath(solver.mesh, np.array([corner // 3]), np.eye(3)[[corner % 3]])
    passed: tuple[int, ...] = ()  # vertices in one place, joined by edges of zero length, are passed once
    while arrivals.distance[v] > 0:
        passed = (*passed, v)
        found = _traced(surface, arrivals, v)
        if not found or found[1] in passed:
            found = _beside(surface, arrivals, v, passed)
        for strip, origin in [found] if found else _along_edges(surface, arrivals, v):
            line = straightened(surface, strip)
            tied = ties and not parts and is_tied(surface, arrivals, v, line, origin, _traced)
            parts.append(replace(path_in_strip(solver.mesh, *line), tied=tied))
            v = origin
    return joined(parts[::-1])


def _traced(surface: Surface, arrivals: Arrivals, v: int, along_edges: bool = True) -> tuple[Strip, int] | None:
    """Return the last straight line to v, perhaps along an edge, by tracing it back; None if rounding loses it."""
    h, t, d = int(arrivals.halfedge[v]), arrivals.entry[v], arrivals.distance
    origin = int(arrivals.origin[v])
    if h < 0:
        return _edge(surface, origin, v), origin
    if along_edges and (end := arrivals.along_edge(surface, v)) is not None:
        return _edge(surface, end, v), end
    line = np.empty(256, dtype=CROSSING)
    while (count := line_to_origin(surface, h, t, origin, d[v] - d[origin], line)) < 0:
        line = np.empty(4 * len(line), dtype=CROSSING)
    if not count:
        return None
    leave, enter = line["enter"][count - 1 :: -1].tolist(), line["leave"][count - 1 :: -1].tolist()
    return Strip.between(surface, leave[0] // 3, leave, enter, origin, v), origin


def _beside(
    surface: Surface, arrivals: Arrivals, v: int, tried: tuple[int, ...], further: int = 2
) -> tuple[Strip, int] | None:
    """Return the last straight lines to v by straightening the path to a neighbor and along the edge from there."""
    d = arrivals.distance
    corners = surface.corners[surface.starts[v] : surface.starts[v + 1]]
    around = np.setdiff1d(surface.faces[corners // 3], tried)
    through = d[around] + np.linalg.norm(surface.points[around] - surface.points[v], axis=1)
    for k in np.argsort(through, kind="stable"):
        u = int(around[k])
        if through[k] <= d[v] * (1 + EQUAL):
            return _edge(surface, u, v), u
        found = _traced(surface, arrivals, u)
        if not found and further:
            found = _beside(surface, arrivals, u, (*tried, u), further - 1)
        if found and found[1] not in tried:
            strip, origin = found
            for face in (corners // 3).tolist():
                if u in surface.faces[face] and (longer := strip.extended(surface, u, face, v)):
                    longer, path = straightened(surface, longer)
                    if d[origin] + path.length <= d[v] * (1 + EQUAL):
                        return longer, origin
    return None


def _along_edges(surface: Surface, arrivals: Arrivals, v: int) -> list[tuple[Strip, int]]:
    """Return the edges to v from a vertex whose straight line is found, and that line, where slivers lose the one to v.

    The vertex is the one with the shortest way to the source, among those from which lines lead nearer to it.
    """
    d, reached = arrivals.distance, dict[int, int]()
    waiting = [(d[v], 0.0, v, -1)]
    while True:
        _, length, u, before = heappop(waiting)  # the source is in it at last
        if u in reached:
            continue
        reached[u] = before
        line = _traced(surface, arrivals, u, along_edges=False) if d[u] > 0 else None
        if d[u] == 0 or (line and d[line[1]] < d[v]):
            break
        around = np.unique(surface.faces[surface.corners[surface.starts[u] : surface.starts[u + 1]] // 3])
        lengths = length + np.linalg.norm(surface.points[around] - surface.points[u], axis=1)
        for w, far in zip(around.tolist(), lengths.tolist(), strict=True):
            heappush(waiting, (far + d[w], far, w, u))
    lines = [line] if line else []
    while u != v:
        lines.append((_edge(surface, u, reached[u]), u))
        u = reached[u]
    return lines[::-1]


def _edge(surface: Surface, u: int, v: int) -> Strip:
    """Return the strip of an edge."""
    corners = surface.corners[surface.starts[v] : surface.starts[v + 1]]
    face = next(f for f in (corners // 3).tolist() if u in surface.faces[f])
    return Strip.between(surface, face, [], [], u, v)
