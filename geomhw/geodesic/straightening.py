"""Curves on a surface, and the geodesics to which they shorten within their homotopy class.

Sharp, Crane: You Can Find Geodesic Paths in Triangle Meshes by Just Flipping Edges. ACM Trans. Graph. 39(6), 2020.
Xin, He, Fu: Efficiently Computing Exact Geodesic Loops within Finite Steps. IEEE TVCG 18(6), 2012.
"""

from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.geodesic.strips import (
    Crossings,
    Strip,
    crossings,
    fan_between,
    positions,
    rerouted,
    shortened_ends,
    straightened,
)
from geomhw.geodesic.surface_path import SurfacePath, joined, path_in_strip
from geomhw.geodesic.unfolded_faces import Surface, ends
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Bisections for the place of a loop on an edge, while its strip changes and at last.
FEW_BISECTIONS, BISECTIONS = 6, 60
#: A loop is shorter if it is so by more than this share.
SHORTER = 1e-14


def curve_through(mesh: TriangleMesh, points: SurfacePoints, closed: bool = False) -> SurfacePath:
    """Return the curve through points: straight within a face, by the shortest path to a point in no common face.

    Raises
    ------
    FieldError
        As `ShortestPaths.through` does.
    """
    if len(points) < 2:
        raise FieldError("a curve needs at least two points")
    paths, parts = ShortestPaths(mesh), []
    order = np.arange(len(points))
    for i, j in zip(order if closed else order[:-1], np.roll(order, -1), strict=False):
        pair = points[np.array([i, j])]
        support = np.unique(pair.corners[pair.weights > 0])
        shared = _faces_with(paths.exact().surface, support)
        if shared:
            names = mesh.faces[shared[0]]
            weights = [
                [w[corners == v].sum() for v in names] for corners, w in zip(pair.corners, pair.weights, strict=True)
            ]
            parts.append(SurfacePath(mesh, np.array(shared[:1] * 2), np.array(weights)))
        else:
            parts.append(paths.through(pair))
    return joined(parts)


def _faces_with(surface: Surface, vertices: "np.ndarray") -> list[int]:
    """Return the faces that have all of some vertices."""
    v = int(vertices[0])
    around = (surface.corners[surface.starts[v] : surface.starts[v + 1]] // 3).tolist()
    return [f for f in around if set(vertices.tolist()) <= set(surface.faces[f].tolist())]


def straighten(path: SurfacePath, closed: bool = False) -> SurfacePath:
    """Shorten a curve to a geodesic within its homotopy class, with fixed ends, or as a loop.

    Parameters
    ----------
    path : SurfacePath
        If closed, it ends where it starts.
    closed : bool
        Whether the ends may move together.

    Returns
    -------
    SurfacePath
        A locally shortest path: straight across edges, with an angle of at least π on both sides at the vertices where
        it turns. A loop that shrinks to a point gives a path of one point.

    Raises
    ------
    FieldError
        If a closed curve passes a vertex where fans of faces meet, at which it is fixed.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> flat = grid(2, 2)
    >>> straighten(curve_through(flat, vertex_points(flat, [0, 1, 2, 5, 8]))).positions.tolist()
    [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [1.0, 1.0, 0.0]]
    """
    surface = ExactDistance(path.mesh).surface
    if not closed:
        parts = [straightened(surface, strip) for strip in _strips(surface, path)]
        return joined([path_in_strip(path.mesh, *part) for part in parts])
    if not np.allclose(path.positions[0], path.positions[-1], rtol=0, atol=1e-9 * max(path.length, 1e-300)):
        raise FieldError("a closed curve must end where it starts")
    return _Loop.of(surface, path).straightened(path)


def _strips(surface: Surface, path: SurfacePath) -> list[Strip]:
    """Return the strips of a curve: one, unless it passes vertices where fans of faces meet, at which it is fixed."""
    strips: list[Strip] = []
    first, leave, enter, start = int(path.faces[0]), list[int](), list[int](), path.weights[0]
    for k in range(1, len(path.faces) - 1):
        f, g, weights = int(path.faces[k - 1]), int(path.faces[k]), path.weights[k]
        if f == g:
            continue
        turn = _turn(surface, f, g, weights)
        if turn is None:
            v = surface.faces[g, int(weights.argmax())]
            strips.append(Strip(first, leave, enter, start, (surface.faces[f] == v).astype(float)))
            first, leave, enter, start = g, [], [], weights
        else:
            leave, enter = leave + turn[0], enter + turn[1]
    last = enter[-1] // 3 if enter else first
    assert last == path.faces[-1]
    return [*strips, Strip(first, leave, enter, start, path.weights[-1])]


def _turn(surface: Surface, f: int, g: int, weights: Floats) -> tuple[list[int], list[int]] | None:
    """Return the edges that a curve crosses from face f to face g at a point of both, given in g."""
    names = surface.faces[g]
    if (weights > 0).sum() == 1:
        return fan_between(surface, int(names[weights.argmax()]), f, g)
    enter = 3 * g + int(np.flatnonzero(weights == 0)[0])
    leave = next(side for side in range(3 * f, 3 * f + 3) if ends(surface, side) == ends(surface, enter))
    return [leave], [enter]


class _Loop(NamedTuple):
    """The edges that a closed curve crosses, in a circle."""

    surface: Surface
    leave: list[int]
    enter: list[int]

    @classmethod
    def of(cls, surface: Surface, path: SurfacePath) -> "_Loop":
        """Return the loop of a closed curve."""
        strips = _strips(surface, path)
        last, first = int(path.faces[-2] if len(path.faces) > 1 else path.faces[-1]), int(path.faces[0])
        turn = ([], []) if first == last else _turn(surface, last, first, path.weights[0])
        if len(strips) > 1 or turn is None:
            raise FieldError("the closed curve passes a vertex where fans of faces meet; straighten it as an open one")
        return cls(surface, strips[0].leave + turn[0], strips[0].enter + turn[1])._reduced()

    def _reduced(self) -> "_Loop":
        """Return the loop without edges crossed twice in a row."""
        leave, enter = list(self.leave), list(self.enter)
        k = 0
        while len(leave) > 1 and k < len(leave):
            j = (k + 1) % len(leave)
            if leave[j] == enter[k]:
                if enter[j] == leave[k]:
                    for i in sorted((j, k), reverse=True):
                        del leave[i], enter[i]
                else:
                    enter[k] = enter[j]
                    del leave[j], enter[j]
                k = 0
            else:
                k += 1
        return _Loop(self.surface, leave, enter)

    def straightened(self, path: SurfacePath) -> SurfacePath:
        """Return the closed geodesic; at a point of the path if there are no edges."""
        loop, best, anchored = self, np.inf, -1
        while True:
            point = loop._point()
            if point is not None or not loop.leave:
                if point is None:
                    return SurfacePath(path.mesh, path.faces[:1], path.weights[:1])
                corner = int(self.surface.corners[self.surface.starts[point]])
                return SurfacePath(path.mesh, np.array([corner // 3]), np.eye(3)[[corner % 3]])
            loop = loop._anchored_off(anchored)
            strip, found, share = loop._shortest(FEW_BISECTIONS)
            moved = rerouted(self.surface, strip, found)
            if moved is None or found.length >= best * (1 - SHORTER):
                strip, found, share = loop._shortest(BISECTIONS)
                moved = rerouted(self.surface, strip, found)
            if moved and found.length < best * (1 - SHORTER):
                best, anchored = found.length, -1
                loop = _Loop(self.surface, loop.leave[:1] + moved.leave, loop.enter[:1] + moved.enter)._reduced()
                continue
            low, high = ends(self.surface, loop.leave[0])
            at = low if share == 0 else high if share == 1 else -1
            if at >= 0 and anchored < 0:
                anchored = at
                continue
            strip = shortened_ends(self.surface, strip)
            return path_in_strip(path.mesh, strip, crossings(self.surface, strip))

    def _point(self) -> int | None:
        """Return the vertex of all edges, if there is one: the loop shrinks to it."""
        common = set.intersection(*(set(ends(self.surface, side)) for side in self.leave)) if self.leave else set()
        return min(common) if common else None

    def _anchored_off(self, v: int) -> "_Loop":
        """Return the loop from an edge on that does not end at a vertex."""
        k = next(k for k, side in enumerate(self.leave) if v not in ends(self.surface, side))
        return _Loop(self.surface, self.leave[k:] + self.leave[:k], self.enter[k:] + self.enter[:k])

    def _shortest(self, bisections: int) -> tuple[Strip, Crossings, float]:
        """Return the loop cut open at its first edge, the shortest path in it, and where that crosses the edge.

        The length is a convex function of this place; its derivative is zero where the loop is straight.
        """
        low, high = 0.0, 1.0
        for share in (low, high):
            strip, found, slope = self._at(share)
            if (slope >= 0) == (share == 0):
                return strip, found, share
        for _ in range(bisections):
            share = (low + high) / 2
            strip, found, slope = self._at(share)
            low, high = (low, share) if slope > 0 else (share, high)
        return strip, found, share

    def _at(self, share: float) -> tuple[Strip, Crossings, float]:
        """Return the strip through a place on the first edge, the path in it, and the slope of its length."""
        surface, out, into = self.surface, self.leave[0], self.enter[0]
        low, high = ends(surface, out)
        start, end = (
            np.where(surface.faces[side // 3] == low, 1 - share, np.where(surface.faces[side // 3] == high, share, 0.0))
            for side in (into, out)
        )
        strip = Strip(into // 3, self.leave[1:], self.enter[1:], start, end)
        found = crossings(surface, strip)
        x = positions(surface, strip, found)
        edge = surface.points[high] - surface.points[low]
        steps = np.diff(x, axis=0)
        long = np.flatnonzero(np.linalg.norm(steps, axis=1) > 1e-12 * np.linalg.norm(edge))
        if not len(long):
            return strip, found, 0.0
        first, last = (steps[k] / np.linalg.norm(steps[k]) for k in (long[0], long[-1]))
        return strip, found, float((last - first) @ edge)
