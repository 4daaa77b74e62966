"""Fast approximate distance: fast marching that carries the direction and the curvature of the front along."""

from functools import partial
from typing import Any

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.distance_matrix import RowFiller, append_row
from geomhw.geodesic.front import TOUCHED, Extent, extent_above
from geomhw.geodesic.front_distance import FrontDistance, final_vertices
from geomhw.geodesic.marching import March, empty_march, propagate, raise_to_chords, reset
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

    def _before_threads(self) -> None:
        """Lay out the angles at all vertices."""
        lay_out_all(self.surface, self._angles)

    def _row_filler(self) -> RowFiller:
        """Return how `pairs` computes rows."""
        return RowFiller(partial(empty_march, self.surface), partial(fill_marched_rows, self.surface, self._angles))

    def _solved(self, sources: SurfacePoints, limit: float, targets: Ints, sides: Ints) -> tuple[Floats, Ints]:
        """Return the distances, and the vertices with one."""
        march = empty_march(self.surface)
        start(self.surface, self._angles, march, sources.vertices)
        start_from_edges(self.surface, self._angles, march, self._lines_from(sources, sides))
        places, faces = self.placed(sources.within_faces)
        start_from_places(self.surface, self._angles, march, places, faces)
        radius = propagate(self.surface, self._angles, march, Extent(limit, 0.0, self._heights), targets)
        vertices = final_vertices(march.distance, march.touched[: march.counts[TOUCHED]], radius)
        if len(sources) == 1 and not len(sides):
            raise_to_chords(self.surface, march, *sources.positions(self.mesh)[0])
            vertices = final_vertices(march.distance, vertices, limit)
        return march.distance, vertices


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
    while done < len(sources):
        v = sources[done]
        start(surface, angles, march, sources[done : done + 1])
        propagate(surface, angles, march, extent_above(extent, v), sources[:0])
        x, y, z = surface.points[v]
        raise_to_chords(surface, march, x, y, z)
        added = append_row(march, 0, extent.limit, ranks, ranks[v], columns, values, end)
        reset(march)
        if end + added > len(columns):
            return done, end
        counts[done] = added
        done, end = done + 1, end + added
    return done, end
