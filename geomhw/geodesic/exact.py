"""Exact geodesic distance on polyhedral surfaces by windows of straight lines [Mitchell, Mount, Papadimitriou 1987]."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import inf
from os import cpu_count
from typing import TYPE_CHECKING, Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.distance_matrix import distance_pairs, symmetric_matrix
from geomhw.geodesic.front import ROOM, Extent, Front, empty_front, reached, start, with_more_room
from geomhw.geodesic.unfolded_faces import Surface, surface_of, triangle
from geomhw.geodesic.window_propagation import propagate, start_from_edges
from geomhw.mesh.inserted_curves import insert_sources
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: Distances, and places on an edge, that agree up to this share are equal.
EQUAL = 1e-12
#: No halfedges.
NO_SIDES = np.empty(0, dtype=np.int64)


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


class ExactDistance:
    """Exact polyhedral distance on one mesh: links halfedges once, then answers any sources.

    Works on any triangle mesh. At an edge or a vertex, paths pass from one face to all others. The time is
    proportional to the number of windows: about 25 a vertex on scans, 100 on a sphere of 41k vertices.

    Parameters
    ----------
    mesh : the mesh. Duplicate faces are left out.

    Raises
    ------
    MeshError
        If a coordinate exceeds 1e30 or the mesh is smaller than 1e-30.

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

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        assert mesh.edge_lengths.size  # checks the range of coordinates
        self._face_of = np.arange(mesh.n_faces)
        self._face_of[mesh.duplicate_faces[:, 0]] = mesh.duplicate_faces[:, 1]
        self._surface = surface_of(mesh, self._face_of == np.arange(mesh.n_faces))
        self._heights = np.zeros(mesh.n_vertices)

    def from_vertices(
        self, sources: Sequence[int] | Ints, limit: float = inf, targets: Sequence[int] | Ints = ()
    ) -> Result:
        """Return the distance from the nearest of the source vertices; as `from_sources`."""
        return self.from_sources(vertex_points(self.mesh, sources), limit, targets)

    def from_sources(self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()) -> Result:
        """Return the distance from the nearest source: points, segments between points, filled regions.

        Parameters
        ----------
        sources : the sources, in any order.
        limit : largest distance (length). Larger ones are inf; time is spent within the limit only.
        targets : vertices whose distances are wanted. Once they are final, all larger distances are inf.

        Returns
        -------
        Result with the field ``distance`` (length) per vertex: 0 at source vertices, inf where there is no path.

        Raises
        ------
        FieldError
            If a source or target is not a vertex of the surface, or the limit is negative.
        """
        distance, vertices = self._distances(sources, limit, targets)
        found = distance[vertices]
        report: dict[str, Any] = {"sources": sources.report(), "farthest": None, "mean_distance": None}
        if len(vertices):
            farthest = int(found.argmax())
            report["farthest"] = {"vertex": int(vertices[farthest]), "distance": float(found[farthest])}
            report["mean_distance"] = float(found.mean())
        far = self.mesh.n_vertices - len(self.mesh.unreferenced_vertices) - len(vertices)
        cut = limit < inf or len(targets) > 0
        report |= {"vertices_beyond" if cut else "unreachable_vertices": far, **self.settings()}
        return Result(self.mesh, [Field("distance", "vertex", distance)], report, sources)

    def from_lines(self, vertices: Ints, halfedges: Ints) -> Floats:
        """Return the distances from vertices and from edges, sides 3f + k of faces f, (n,)."""
        return self._solved(vertex_points(self.mesh, vertices), sides=halfedges)[0].distance

    def arrivals(self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()) -> Arrivals:
        """Return distances as `from_sources` does, with the straight line by which each vertex is reached.

        Segments between points are no sources here.
        """
        front, _ = self._solved(sources, limit, targets)
        outside = np.flatnonzero(np.isinf(front.distance))
        front.origin[outside], front.halfedge[outside], front.entry[outside] = outside, -1, 0.0
        return Arrivals(front.distance, front.origin, front.halfedge, front.entry)

    def _distances(
        self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()
    ) -> tuple[Floats, Ints]:
        """Return the distances, inf beyond the limit or the targets, and the vertices with a distance, ascending."""
        if not len(sources.segments):
            front, vertices = self._solved(sources, limit, targets)
            return front.distance, vertices
        n, found = self.mesh.n_vertices, insert_sources(self.mesh, sources)
        sides = found.sides(np.arange(len(found.chains)))
        front, vertices = ExactDistance(found.mesh)._solved(found.sources, limit, targets, sides)
        return front.distance[:n], vertices[vertices < n]

    def _solved(
        self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = (), sides: Ints = NO_SIDES
    ) -> tuple[Front, Ints]:
        """Return the front when distances are final, up to the limit or the targets, and its vertices, ascending.

        sides: halfedges that are sources, too.
        """
        wanted = vertex_points(self.mesh, targets).vertices if len(targets) else np.empty(0, dtype=np.int64)
        points = sources.within_faces
        front = empty_front(self._surface, len(points))
        start(front, sources.vertices, len(points))
        sides = sides[self._face_of[sides // 3] == sides // 3]
        if len(halfedges := np.union1d(self._filled_sides(sources.filled_vertices), sides)):
            while len(front.windows) < 2 * len(halfedges) + ROOM:
                front = with_more_room(front)
            start_from_edges(self._surface, front, halfedges, len(points))
        places, faces = self.placed(points)
        front, radius = self._propagated(front, places, faces, _checked(limit), wanted)
        vertices = np.sort(reached(front))
        final = front.distance[vertices] <= radius
        front.distance[vertices[~final]] = inf
        return front, vertices[final]

    def rows(
        self,
        queries: Sequence[SurfacePoints],
        limit: float = inf,
        targets: Sequence[Sequence[int] | Ints] | None = None,
    ) -> Floats:
        """Return the distances from each of k sets of sources, (k, n), computed in parallel.

        targets : for each set, the vertices whose distances are wanted, as in `from_sources`; by default all.
        """
        rows = np.empty((len(queries), self.mesh.n_vertices))

        def compute(k: int) -> None:
            rows[k] = self._distances(queries[k], limit, targets[k] if targets else ())[0]

        with ThreadPoolExecutor(cpu_count()) as threads:
            list(threads.map(compute, range(len(queries))))
        return rows

    def matrix(self, limit: float = inf) -> "csr_array":
        """Return the distances between all vertices at most a limit apart.

        Returns
        -------
        (n, n) sparse array, symmetric. The distances on the diagonal, and between vertices at the same place, are
        stored zeros: an entry is stored exactly where the distance is within the limit.

        Examples
        --------
        >>> from geomhw.mesh import grid
        >>> near = ExactDistance(grid(2, 2)).matrix(limit=0.5)
        >>> near.nnz, near[4, 1]
        (33, np.float64(0.5))
        """
        return symmetric_matrix(*self.pairs(limit), self.mesh.n_vertices)

    def pairs(self, limit: float = inf, part: slice = slice(None)) -> tuple[Ints, Ints, Floats]:
        """Return rows, columns and values of `matrix`, one of each two equal entries, of a part of the sources."""
        return distance_pairs(self.mesh, self._surface, _checked(limit), part)

    @property
    def surface(self) -> Surface:
        """The halfedges of the mesh, for tracing lines."""
        return self._surface

    def placed(self, points: SurfacePoints) -> tuple[Floats, Ints]:
        """Return coordinates and faces of points within faces; for a duplicate face, the face that it repeats."""
        return points.positions(self.mesh), self._face_of[points.faces]

    def settings(self) -> dict[str, Any]:
        """Return how distances are computed, as plain values for a report."""
        return {"method": "exact"}

    def _filled_sides(self, vertices: Ints) -> Ints:
        """Halfedges with both ends, but not the whole face, among the vertices of filled regions."""
        if not len(vertices):
            return vertices
        inside = np.zeros(self.mesh.n_vertices, dtype=bool)
        inside[vertices] = True
        corners = inside[self.mesh.faces]
        beside = (corners.sum(axis=1) == 2) & (self._face_of == np.arange(self.mesh.n_faces))
        return np.flatnonzero(beside[:, None] & ~corners)

    def _propagated(
        self, front: Front, places: Floats, faces: Ints, limit: float, targets: Ints
    ) -> tuple[Front, float]:
        """Propagate a front with sources at places within faces; return it, and the radius of final distances."""
        extent = Extent(limit, 0.0, self._heights)
        while (radius := propagate(self._surface, front, places, faces, extent, targets)) < 0:
            front = with_more_room(front)
        return front, radius


def _checked(limit: float) -> float:
    """Return the limit as a float; raise ArgumentError unless it is 0 or more."""
    if not limit >= 0:
        raise ArgumentError(f"the limit of distances is a length, 0 or more, not {limit}")
    return float(limit)
