"""Fast approximate distance: fast marching that carries the direction and the curvature of the front along."""

from collections.abc import Sequence
from functools import partial
from math import inf, sqrt
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.distance_matrix import Rows, distance_pairs
from geomhw.geodesic.front import TOUCHED, Extent
from geomhw.geodesic.front_distance import FrontDistance, checked_limit
from geomhw.geodesic.marching import March, empty_march, propagate, reset
from geomhw.geodesic.marching_sources import start, start_from_edges, start_from_places
from geomhw.geodesic.unfolded_faces import Surface
from geomhw.geodesic.vertex_angles import VertexAngles, lay_out_all, no_angles
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh


class FastMarchingDistance(FrontDistance):
    """Approximate distance on one mesh, by one visit of each vertex. See `FrontDistance`.

    Exact up to rounding on flat surfaces. On scans and cortical surfaces the mean error is 0.02 to 0.15 %, a twentieth
    of that of fast marching with distances alone; it is largest where fronts meet, and on triangles 100 times longer
    than high. From one point, distances are at least those along the straight line, and from any sources at most those
    along edges. The time is proportional to the number of vertices, 0.7 to 1.6 µs each.

    References
    ----------
    Kimmel, Sethian: Computing Geodesic Paths on Manifolds. PNAS 95(15), 1998. Trettner, Bommes, Kobbelt: Geodesic
    Distance Computation via Virtual Source Propagation. Comput. Graph. Forum 40(5), 2021. Potter, Cameron: Jet Marching
    Methods for Solving the Eikonal Equation. SIAM J. Sci. Comput. 43(6), 2021.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> sphere = icosphere(4)
    >>> distance = FastMarchingDistance(sphere).from_vertices([0])["distance"]
    >>> round(float(distance.max()), 2)
    3.14
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        super().__init__(mesh)
        self._angles = no_angles(self.surface)

    def settings(self) -> dict[str, Any]:
        """Return how distances are computed, as plain values for a report."""
        return {"method": "fast-marching"}

    def rows(
        self,
        queries: Sequence[SurfacePoints],
        limit: float = inf,
        targets: Sequence[Sequence[int] | Ints] | None = None,
    ) -> Floats:
        """Return the distances from each of k sets of sources, (k, n); see `FrontDistance.rows`."""
        lay_out_all(self.surface, self._angles)
        return super().rows(queries, limit, targets)

    def pairs(self, limit: float = inf, part: slice = slice(None)) -> tuple[Ints, Ints, Floats]:
        """Return rows, columns and values of `matrix`, one of each two equal entries, of a part of the sources."""
        lay_out_all(self.surface, self._angles)
        rows = Rows(partial(empty_march, self.surface), partial(fill_marched_rows, self.surface, self._angles))
        return distance_pairs(self.mesh, self.surface, rows, checked_limit(limit), part)

    def _solved(self, sources: SurfacePoints, limit: float, targets: Ints, sides: Ints) -> tuple[Floats, Ints]:
        """Return the distances, and the vertices with one."""
        march = empty_march(self.surface)
        march = empty_march(self.surface)
        start(self.surface, self._angles, march, sources.vertices)
        start_from_edges(self.surface, self._angles, march, self._lines_from(sources, sides))
        places, faces = self.placed(sources.within_faces)
        start_from_places(self.surface, self._angles, march, places, faces)
        radius = propagate(self.surface, self._angles, march, Extent(limit, 0.0, self._heights), targets)
        vertices = np.sort(march.touched[: march.counts[TOUCHED]])
        final, points = march.distance[vertices] <= radius, self.mesh.vertices
        if len(sources) == 1 and not len(sides):
            chords = np.linalg.norm(points[vertices] - sources.positions(self.mesh), axis=1)
            march.distance[vertices] = np.maximum(march.distance[vertices], chords)
            final &= march.distance[vertices] <= limit
        march.distance[vertices[~final]] = inf
        return march.distance, vertices[final]


@compiled_in_place
def fill_marched_rows(
    surface: Surface,
    angles: VertexAngles,
    march: March,
    sources: Ints,
    extent: Extent,
    ranks: Ints,
    counts: Ints,
    columns: Ints,
    values: Floats,
    done: int,
    end: int,
) -> tuple[int, int]:
    """Append rows of distances until all sources are done or room for the next row is lacking; see `fill_rows`."""
    slack = 1e-9 * extent.limit
    while done < len(sources):
        v = sources[done]
        start(surface, angles, march, sources[done : done + 1])
        within = Extent(extent.limit, extent.heights[v] - slack, extent.heights)
        propagate(surface, angles, march, within, sources[:0])
        first = end
        x, y, z = surface.points[v]
        for w in march.touched[: march.counts[TOUCHED]]:
            if ranks[w] >= ranks[v]:
                p = surface.points[w]
                distance = max(march.distance[w], sqrt((p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2))
                if distance <= extent.limit:
                    if end < len(columns):
                        columns[end], values[end] = w, distance
                    end += 1
        reset(march)
        if end > len(columns):
            return done, first
        counts[done] = end - first
        done += 1
    return done, end
