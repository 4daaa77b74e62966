"""Exact distances from sources that are added one at a time; each new front ends where it improves nothing."""

from math import inf

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.front import ROOM, Extent, Front, clear_windows, empty_front, push, start, with_more_room
from geomhw.geodesic.window_propagation import propagate, start_from_edges
from geomhw.mesh.surface_points import SurfacePoints

_NO_TARGETS = np.empty(0, dtype=np.int64)


class GrowingSources:
    """Exact distance from a growing set of sources.

    The front of a new source starts from the distances so far. Its windows are cut where these are shorter, so that its
    time is proportional to the region in which the new source is the nearest.

    solver: distances on the mesh. points: the sources. limit: the largest distance.
    """

    def __init__(self, solver: ExactDistance, points: SurfacePoints, limit: float = inf) -> None:
        within = points.within_faces
        self._surface, self._points = solver.surface, points
        self._front = empty_front(self._surface, len(within))
        self._places, self._faces = solver.placed(within)
        self._number = np.cumsum(points.faces >= 0) - 1
        self._extent = Extent(limit, 0.0, np.zeros(solver.mesh.n_vertices))

    @property
    def distance(self) -> Floats:
        """Distance of each vertex from the sources so far, (n,), which further sources change in place."""
        return self._front.distance

    def add(self, i: int) -> None:
        """Add source i."""
        front = self._front
        clear_windows(front)
        if self._points.faces[i] < 0:
            start(front, self._points.corners[i, :1], 0)
        else:
            push(front, len(front.waiting) + len(front.distance) + int(self._number[i]), 0.0)
        self._propagate(front)

    def add_lines(self, vertices: Ints, halfedges: Ints) -> None:
        """Add a source that consists of vertices and of edges, the sides of faces."""
        front = self._front
        clear_windows(front)
        while len(front.windows) < 2 * len(halfedges) + ROOM:
            front = with_more_room(front)
        start(front, vertices, 0)
        start_from_edges(self._surface, front, halfedges, len(self._faces))
        self._propagate(front)

    def _propagate(self, front: Front) -> None:
        """Process all events."""
        self._front = front
        while propagate(self._surface, front, self._places, self._faces, self._extent, _NO_TARGETS) < 0:
            front = self._front = with_more_room(front)
