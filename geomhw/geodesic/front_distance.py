"""Distances on triangle meshes by a front that starts at any sources: what exact and approximate fronts share."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from math import inf
from os import cpu_count
from typing import TYPE_CHECKING, Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.distance_matrix import RowFiller, distance_pairs, symmetric_matrix
from geomhw.geodesic.unfolded_faces import surface_of
from geomhw.mesh.inserted_curves import insert_sources
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: No halfedges, or vertices.
NONE = np.empty(0, dtype=np.int64)


class FrontDistance(ABC):
    """Distance on one mesh by a front: links halfedges once, then answers any sources.

    Works on any triangle mesh. At an edge or a vertex, paths pass from one face to all others.

    Parameters
    ----------
    mesh : the mesh. Duplicate faces are left out.

    Attributes
    ----------
    mesh : the mesh.
    surface : its halfedges.

    Raises
    ------
    MeshError
        If a coordinate exceeds 1e30 or the mesh is smaller than 1e-30.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        assert mesh.edge_lengths.size  # checks the range of coordinates
        self._face_of = np.arange(mesh.n_faces)
        self._face_of[mesh.duplicate_faces[:, 0]] = mesh.duplicate_faces[:, 1]
        self.surface = surface_of(mesh, self._face_of == np.arange(mesh.n_faces))
        self._heights = np.zeros(mesh.n_vertices)

    @abstractmethod
    def settings(self) -> dict[str, Any]:
        """Return how distances are computed, as plain values for a report."""

    @abstractmethod
    def _row_filler(self) -> RowFiller:
        """Return how `pairs` computes rows."""

    @abstractmethod
    def _solved(self, sources: SurfacePoints, limit: float, targets: Ints, sides: Ints) -> tuple[Floats, Ints]:
        """Return distances, inf where there is no path or a distance is not wanted, and the vertices with one.

        sides: halfedges that are sources, too.
        """

    @abstractmethod
    def _before_threads(self) -> None:
        """Compute what threads share and must not compute at the same time."""

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

    def rows(
        self,
        queries: Sequence[SurfacePoints],
        limit: float = inf,
        targets: Sequence[Sequence[int] | Ints] | None = None,
    ) -> Floats:
        """Return the distances from each of k sets of sources, (k, n), computed in parallel.

        targets : for each set, the vertices whose distances are wanted, as in `from_sources`; by default all.
        """
        self._before_threads()
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
        >>> from geomhw.geodesic import ExactDistance
        >>> from geomhw.mesh import grid
        >>> near = ExactDistance(grid(2, 2)).matrix(limit=0.5)
        >>> near.nnz, near[4, 1]
        (33, np.float64(0.5))
        """
        return symmetric_matrix(*self.pairs(limit), self.mesh.n_vertices)

    def pairs(self, limit: float = inf, part: slice = slice(None)) -> tuple[Ints, Ints, Floats]:
        """Return rows, columns and values of `matrix`, one of each two equal entries, of a part of the sources."""
        self._before_threads()
        return distance_pairs(self.mesh, self.surface, self._row_filler(), checked_limit(limit), part)

    def placed(self, points: SurfacePoints) -> tuple[Floats, Ints]:
        """Return coordinates and faces of points within faces; for a duplicate face, the face that it repeats."""
        return points.positions(self.mesh), self._face_of[points.faces]

    def _distances(
        self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()
    ) -> tuple[Floats, Ints]:
        """Return the distances, inf beyond the limit or the targets, and the vertices with a distance, ascending."""
        wanted = vertex_points(self.mesh, targets).vertices if len(targets) else NONE
        if not len(sources.segments):
            return self._solved(sources, checked_limit(limit), wanted, NONE)
        n, found = self.mesh.n_vertices, insert_sources(self.mesh, sources)
        sides = found.sides(np.arange(len(found.chains)))
        inserted = type(self)(found.mesh)
        distance, vertices = inserted._solved(found.sources, checked_limit(limit), wanted, sides)
        return distance[:n], vertices[vertices < n]

    def _lines_from(self, sources: SurfacePoints, sides: Ints) -> Ints:
        """Return the halfedges from which a front starts: some sides, and those of filled regions."""
        sides = sides[self._face_of[sides // 3] == sides // 3]
        return np.union1d(self._filled_sides(sources.filled_vertices), sides)

    def _filled_sides(self, vertices: Ints) -> Ints:
        """Halfedges with both ends, but not the whole face, among the vertices of filled regions."""
        if not len(vertices):
            return vertices
        inside = np.zeros(self.mesh.n_vertices, dtype=bool)
        inside[vertices] = True
        corners = inside[self.mesh.faces]
        beside = (corners.sum(axis=1) == 2) & (self._face_of == np.arange(self.mesh.n_faces))
        return np.flatnonzero(beside[:, None] & ~corners)


def final_vertices(distance: Floats, reached: Ints, radius: float) -> Ints:
    """Return those of some vertices that have a distance within a radius, ascending; set other distances to inf."""
    vertices = np.sort(reached)
    final = distance[vertices] <= radius
    distance[vertices[~final]] = inf
    final_ones: Ints = vertices[final]
    return final_ones


def checked_limit(limit: float) -> float:
    """Return the limit as a float; raise ArgumentError unless it is 0 or more."""
    if not limit >= 0:
        raise ArgumentError(f"the limit of distances is a length, 0 or more, not {limit}")
    return float(limit)
