"""Exact geodesic distance on polyhedral surfaces by windows of straight lines [Mitchell, Mount, Papadimitriou 1987]."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.distance_matrix import RowFiller, exact_rows
from geomhw.geodesic.front import ROOM, Extent, Front, empty_front, reached, start, with_more_room
from geomhw.geodesic.front_distance import NONE, FrontDistance, checked_limit, final_vertices
from geomhw.geodesic.unfolded_faces import Surface, triangle
from geomhw.geodesic.window_propagation import propagate, start_from_edges
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints

#: Distances, and places on an edge, that agree up to this share are equal.
EQUAL = 1e-12


@dataclass(frozen=True)
class Arrivals:
    """Exact distances, and the straight line by which each vertex is reached.

    Attributes
    ----------
    distance : (n,) array
        Distance from the nearest source; inf where there is no path, or beyond the limit or the targets.
    origin : (n,) integer array
        The vertex at which the last straight line of the shortest path starts, or -1-i for source i of the k within
        faces, or -1-k-h if it starts perpendicular to an edge of a filled region, the side h = 3f+c of face f opposite
        its corner c. Source vertices are their own origin, and vertices at distance inf.
    halfedge : (n,) integer array
        3f+k where the line arrives through face f, over the edge opposite its corner k; -1 where it stays in a face of
        its origin.
    entry : (n,) array
        Where the line crosses that edge: the distance from the edge's lower vertex.
    """

    distance: Floats
    origin: Ints
    halfedge: Ints
    entry: Floats

    def along_edge(self, surface: Surface, v: int) -> int | None:
        """Return the vertex from which a line over an edge comes along another edge; None if it crosses the edge."""
        face = triangle(surface, int(self.halfedge[v]))
        for end, place, length in ((face.low, 0.0, face.left), (face.high, face.base, face.right)):
            at_end = abs(self.entry[v] - place) <= EQUAL * face.base
            if at_end and self.distance[end] + length <= self.distance[v] * (1 + EQUAL):
                return int(end)
        return None


class ExactDistance(FrontDistance):
    """Exact polyhedral distance on one mesh, by windows of straight lines. See `FrontDistance`.

    The time is proportional to the number of windows: about 25 a vertex on scans, 100 on a sphere of 41k vertices.

    References
    ----------
    Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987. Xin, Wang: Improving
    Chen and Han's Algorithm on the Discrete Geodesic Problem. ACM Trans. Graph. 28(4), 2009. Qin, Han, Yu, Yu, Zhang:
    Fast and Exact Discrete Geodesic Computation Based on Triangle-Oriented Wavefront Propagation. ACM Trans. Graph.
    35(4), 2016.

    Examples
    --------
    >>> from geomhw.mesh import TriangleMesh
    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> mesh = TriangleMesh(square, [[0, 1, 2], [0, 2, 3]])
    >>> ExactDistance(mesh).from_vertices([1])["distance"].round(6).tolist()
    [1.0, 0.0, 1.0, 1.414214]
    """

    def from_lines(self, vertices: Ints, halfedges: Ints) -> Floats:
        """Return the distances from vertices and from edges, sides 3f + k of faces f, (n,)."""
        return self._solved(vertex_points(self.mesh, vertices), inf, NONE, halfedges)[0]

    def arrivals(self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()) -> Arrivals:
        """Return distances as `from_sources` does, with the straight line by which each vertex is reached.

        Segments between points are no sources here.
        """
        wanted = vertex_points(self.mesh, targets).vertices if len(targets) else NONE
        front, _ = self._front(sources, checked_limit(limit), wanted, NONE)
        outside = np.flatnonzero(np.isinf(front.distance))
        front.origin[outside], front.halfedge[outside], front.entry[outside] = outside, -1, 0.0
        return Arrivals(front.distance, front.origin, front.halfedge, front.entry)

    def settings(self) -> dict[str, Any]:
        """Return how distances are computed, as plain values for a report."""
        return {"method": "exact"}

    def _before_threads(self) -> None:
        """Do nothing: what is computed when first needed are single numbers."""

    def _row_filler(self) -> RowFiller:
        """Return how `pairs` computes rows."""
        return exact_rows(self.surface)

    def _solved(self, sources: SurfacePoints, limit: float, targets: Ints, sides: Ints) -> tuple[Floats, Ints]:
        """Return the distances, and the vertices with one."""
        front, vertices = self._front(sources, limit, targets, sides)
        return front.distance, vertices

    def _front(self, sources: SurfacePoints, limit: float, targets: Ints, sides: Ints) -> tuple[Front, Ints]:
        """Return the front when distances are final, up to the limit or the targets, and its vertices, ascending."""
        points = sources.within_faces
        front = empty_front(self.surface, len(points))
        start(front, sources.vertices, len(points))
        if len(halfedges := self._lines_from(sources, sides)):
            while len(front.windows) < 2 * len(halfedges) + ROOM:
                front = with_more_room(front)
            start_from_edges(self.surface, front, halfedges, len(points))
        places, faces = self.placed(points)
        extent = Extent(limit, 0.0, self._heights)
        while (radius := propagate(self.surface, front, places, faces, extent, targets)) < 0:
            front = with_more_room(front)
        return front, final_vertices(front.distance, reached(front), radius)
