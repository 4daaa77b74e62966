"""Exact geodesic distance on a polyhedral surface: windows of straight lines, propagated over edges.

Mitchell, Mount, Papadimitriou: The Discrete Geodesic Problem. SIAM J. Comput. 16(4), 1987.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.geodesic.window_propagation import WAITING, Front, Surface, propagate
from geomhw.geodesic.windows import WINDOW
from geomhw.mesh.surface_points import SurfacePoints, vertex_points
from geomhw.mesh.topology import counting_order
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

#: Windows for which there is room at first.
ROOM = 4096


@dataclass(frozen=True)
class Arrivals:
    """Exact distances, and the straight line by which each vertex is reached.

    Attributes
    ----------
    distance : (n,) array
        Distance from the nearest source; inf where no path leads or distances are not final.
    origin : (n,) integer array
        The vertex at which the last straight line of the shortest path starts, or -1-k for source k, counted among those
        within faces. Sources are their own origin. Undefined where the distance is inf, as the following.
    halfedge : (n,) integer array
        3f+k where the line arrives through face f, over the edge opposite its corner k; -1 where it stays in a face of
        its origin.
    entry : (n,) array
        Where it crosses that edge: distance from the edge's lower vertex.
    """

    distance: Floats
    origin: Ints
    halfedge: Ints
    entry: Floats


class ExactDistance:
    """Exact polyhedral distance on one mesh: connects halfedges once, then answers any sources.

    Works on any triangle mesh. Paths pass from one face to all others at an edge and at a vertex. The time grows with
    the number of windows, about 25 a vertex on scans, 100 on a sphere of 41k vertices; the memory with those on the front.

    Parameters
    ----------
    mesh : the mesh. Duplicate faces are left out.

    References
    ----------
    Mitchell, Mount, Papadimitriou 1987; window lists cross faces at once as in Qin et al. 2016.

    Examples
    --------
    The shortest way between opposite corners of a unit cube crosses two of its faces.

    >>> from geomhw.mesh import TriangleMesh
    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> mesh = TriangleMesh(square, [[0, 1, 2], [0, 2, 3]])
    >>> ExactDistance(mesh).from_vertices([1])["distance"].round(6).tolist()
    [1.0, 0.0, 1.0, 1.414214]
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self._face_of = np.arange(mesh.n_faces)
        self._face_of[mesh.duplicate_faces[:, 0]] = mesh.duplicate_faces[:, 1]
        self._surface = _surface(mesh, self._face_of == np.arange(mesh.n_faces))

    def from_vertices(
        self, sources: Sequence[int] | Ints, limit: float = inf, targets: Sequence[int] | Ints = ()
    ) -> Result:
        """Return the distance from the nearest of the source vertices; as `from_sources`."""
        return self.from_sources(vertex_points(self.mesh, sources), limit, targets)

    def from_sources(self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()) -> Result:
        """Return the distance from the nearest of the sources, vertices or points in faces or on edges.

        Parameters
        ----------
        sources : the sources, in any order.
        limit : distances beyond are inf, and cost nothing.
        targets : vertices whose distances are wanted; once they are final, farther vertices are inf, and cost nothing.

        Returns
        -------
        Result with the field ``distance`` (length) per vertex: 0 at source vertices, inf on components without a source.

        Raises
        ------
        FieldError
            If a source or target is no vertex of the surface, or the limit is negative.
        """
        distance = self.arrivals(sources, limit, targets).distance
        finite = np.isfinite(distance)
        farthest = int(np.where(finite, distance, -1.0).argmax())
        report = {
            "sources": sources.report(),
            "farthest": {"vertex": farthest, "distance": float(distance[farthest])},
            "mean_distance": float(distance[finite].mean()),
        }
        return Result(self.mesh, [Field("distance", "vertex", distance)], report)

    def arrivals(self, sources: SurfacePoints, limit: float = inf, targets: Sequence[int] | Ints = ()) -> Arrivals:
        """Return distances as `from_sources`, with the straight line by which each vertex is reached."""
        if not limit >= 0:
            raise FieldError(f"the limit of distances is a length from 0 on, not {limit}")
        wanted = vertex_points(self.mesh, targets).vertices if len(targets) else np.empty(0, dtype=np.int64)
        points = sources.within_faces
        places, faces = points.positions(self.mesh), self._face_of[points.faces]
        front = _front(self._surface, sources.vertices, len(points))
        while (radius := propagate(self._surface, front, places, faces, limit, wanted)) < 0:
            front = front._replace(windows=np.concatenate([front.windows, np.empty_like(front.windows)]))
        front.distance[front.distance > radius] = inf
        return Arrivals(front.distance, front.origin, front.halfedge, front.entry)


def _surface(mesh: TriangleMesh, single: Any) -> Surface:
    """Link the halfedges round each edge and list those opposite each vertex; only of faces in the mask, (m,)."""
    edge, vertex = mesh.edge_table.of_faces.ravel(), mesh.faces.ravel()
    by_edge, by_vertex = (order[single[order // 3]] for order in (counting_order(edge), counting_order(vertex)))
    first = np.flatnonzero(np.diff(edge[by_edge], prepend=-1))
    following = np.append(by_edge[1:], 0)
    following[np.append(first[1:], len(by_edge)) - 1] = by_edge[first]
    across = np.arange(len(edge), dtype=by_edge.dtype)
    across[by_edge] = following
    starts = np.append(0, np.cumsum(np.bincount(vertex[by_vertex], minlength=mesh.n_vertices)))
    sides = int(np.diff(first, append=len(by_edge)).max())
    kinds = np.zeros(mesh.n_vertices, dtype=np.int8)
    return Surface(mesh.vertices, mesh.faces, across, by_vertex, starts, kinds, sides)


def _front(surface: Surface, vertices: Ints, k: int) -> Front:
    """The front at the sources: vertices, and k points in faces. Most memory is reserved only, until it is written to."""
    n, h = len(surface.points), surface.faces.size
    vertices = np.unique(vertices)
    items = np.concatenate([h + vertices, h + n + np.arange(k)]).astype(np.int32)
    distance, origin = np.full(n, inf), np.empty(n, dtype=np.int32)
    distance[vertices], origin[vertices] = 0.0, vertices
    front = Front(
        distance,
        origin,
        np.empty(n, dtype=np.int32),
        np.empty(n),
        np.zeros(h, dtype=np.int32),
        np.zeros(h, dtype=np.int32),
        np.zeros(ROOM, dtype=WINDOW),
        np.zeros(4, dtype=np.int64),
        np.empty(h + n + k),
        np.empty(h + n + k, dtype=np.int32),
        np.zeros(h + n + k, dtype=np.int32),
    )
    front.halfedge[vertices], front.entry[vertices] = -1, 0.0
    front.keys[: len(items)], front.items[: len(items)] = 0.0, items
    front.places[items] = 1 + np.arange(len(items))
    front.counts[WAITING] = len(items)
    return front
