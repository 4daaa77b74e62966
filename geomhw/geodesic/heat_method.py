"""Geodesic distance by the heat method [GIH, algorithm 1].

Let heat flow from the sources for a short time, keep only the direction in which it falls, and find the function whose
gradient points that way. Crane, Weischedel, Wardetzky: Geodesics in Heat, ACM Trans. Graph. 32(5), 2013.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.background import submit
from geomhw.errors import ConvergenceError
from geomhw.geodesic.auto_time import time_step
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.geodesic.poisson import DistancePoisson
from geomhw.geodesic.source_conditions import chord_to_nearest, known_distances, source_heat
from geomhw.geodesic.unit_field import unit_field
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.orientation import without_duplicate_faces
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence_of
from geomhw.options import Boundary, SolverName
from geomhw.results import Field, Result
from geomhw.stages import Stages

if TYPE_CHECKING:
    from geomhw.geodesic.exact import ExactDistance
    from geomhw.geodesic.many_sources import ManySources

#: Distances longer than an edge path by a smaller share are equal to it up to rounding.
ROUNDING = 1e-12
#: Sources in a block at most, and numbers in an array of a block: 64 MB.
BLOCK, LARGEST_BLOCK = 32, 1 << 23


def block_size(n: int) -> int:
    """How many source vertices to answer at once on n vertices."""
    return max(1, min(BLOCK, LARGEST_BLOCK // n))


class HeatDistance:
    """The heat method on one mesh for one diffusion time: factors on first use, then answers any sources.

    Parameters
    ----------
    mesh : the mesh. Duplicate faces are left out.
    time : diffusion time as in `time_step`.
    robust : whether to compute on the intrinsic Delaunay triangulation, where heat is nowhere negative and faces of
        zero area do no harm. h is then the mean edge length there.
    refine : whether to replace the distances by those of `ExactDistance`; by default with ``robust``.
    bound : whether to clamp plain distances to the shortest path along edges and, where they are not positive, to the
        straight line to the source; without, they are those of algorithm 1 as the paper has it.
    boundary : how heat meets the boundary, as in `HeatStep`; ``average`` is most accurate next to it.
    solver : ``direct`` factors once for all sources; ``multigrid`` iterates, faster for few sources on large meshes;
        ``auto`` chooses by the size of the mesh and the number of queries, and factors where iteration does not
        converge.
    queries : about how many sources will follow.

    Raises
    ------
    MeshError
        If a face has zero area, unless ``robust``.
    FieldError
        For an unknown time, boundary condition or solver.

    References
    ----------
    [GIH, algorithm 1]

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> result = HeatDistance(icosphere(3)).from_vertices([7])
    >>> round(float(result["distance"].max()), 2)
    3.09
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        time: str | float = "auto",
        robust: bool = False,
        refine: bool | None = None,
        boundary: Boundary = "neumann",
        solver: SolverName = "auto",
        queries: int = 1,
        bound: bool = True,
    ) -> None:
        self.mesh = mesh
        self.bound = bound
        self.stages = Stages()
        self.robust: RobustTriangulation | None = None
        self._refine = robust if refine is None else refine
        with self.stages("connectivity"):
            areas = None if robust else submit(lambda: (mesh.degenerate_faces, mesh.vertex_areas))
            self._single = without_duplicate_faces(mesh)
            if areas:
                areas.result()
        if robust:
            with self.stages("triangulation"):
                self.robust = RobustTriangulation.of(self._single)
        self._surface = self.robust.surface if self.robust else self._single
        with self.stages("assembly"):
            boundary_vertices = self._single.boundary_vertices
            self._heat = HeatStep(
                self._surface, time_step(time, self._surface), boundary, boundary_vertices, solver, queries
            )
        self._poisson = DistancePoisson(mesh, self._heat)

    @property
    def time(self) -> TimeStep:
        """The diffusion time, and why it was chosen."""
        return self._heat.time

    def from_vertices(self, sources: Sequence[int] | Ints) -> Result:
        """Return the distance from the nearest of the source vertices; fields as in `from_sources`."""
        return self.from_sources(vertex_points(self.mesh, sources))

    def from_sources(self, sources: SurfacePoints) -> Result:
        """Return the distance from the nearest of the sources: vertices, points within faces, segments, in any order.

        Only refined distances start at the edges and faces of a filled region; otherwise its vertices are the sources.

        Returns
        -------
        Result with these fields. Per vertex: ``heat`` u, with (M + tS) u = 1 at a single source, shared by the corners
        of its face if it lies within one; several source vertices are equally warm. ``divergence``, integrated, of the
        unit field. ``distance`` (length): exactly 0 at source vertices, the straight line at the corners of a face that
        holds a source, positive elsewhere, at most the shortest path along edges, inf on components without a source.
        Per face of the mesh: ``heat_gradient`` ∇u and ``direction`` X = -∇u/|∇u|, zero where no heat arrives, on faces
        of zero area, and between three source vertices.

        Raises
        ------
        ConvergenceError
            If heat does not reach the far side, or the distance is undefined beside faces of nearly zero area.
        """
        mesh, surface, stage = self.mesh, self._surface, self.stages
        sources = sources.unique()
        if not self._refine:
            self._poisson.solve.begin()
        with stage("paths along edges"):
            known = known_distances(mesh, sources)
            paths = edge_path_distance(surface, np.flatnonzero(np.isfinite(known)), known)
        with stage("heat"):  # I. (M + tS) u = u0
            u0 = source_heat(self._heat, sources, mesh)
            u = self._heat.from_impulse(u0, None if len(sources.within_faces) or len(sources.segments) else paths)
        with stage("directions and divergence"):  # II. X = -∇u/|∇u|
            gradients, X = unit_field(surface, u, sources.vertices)
            div = divergence_of(surface, X)
        findings: dict[str, Any] = {}
        with stage("distance"):  # III. Sφ = -Div X
            if self._refine:
                phi = np.asarray(self._exact.from_sources(sources)["distance"])
            else:
                phi = self._poisson(div, sources, known, u)
                phi, findings = bounded(
                    phi, paths, known > 0, lambda low: chord_to_nearest(mesh, sources, low), self.bound
                )
        with stage("results"):
            if surface is not mesh:
                gradients, X = unit_field(mesh, u, sources.vertices)
            fields = [
                Field("heat", "vertex", u.plain),
                Field("divergence", "vertex", div),
                Field("distance", "vertex", phi),
                Field("heat_gradient", "face", gradients),
                Field("direction", "face", X),
            ]
            cold = int(np.count_nonzero((u.sign <= 0) & np.isfinite(phi)))
            findings |= {"non_positive_heat": cold} if cold else {}
            return Result(mesh, fields, self._report(sources, phi) | findings, sources)

    def rows(self, queries: Sequence[SurfacePoints]) -> Floats:
        """Return the distances from each of k sets of sources, (k, n): those of `from_sources`, up to rounding.

        Sets of one vertex are solved in blocks where systems are factored, at a fraction of the time.
        """
        if self._refine:
            return self._exact.rows(queries)
        rows = np.empty((len(queries), self.mesh.n_vertices))
        single = [k for k, sources in enumerate(queries) if len(sources) == len(sources.vertices) == 1]
        left = set(range(len(queries)))
        if len(single) > 1 and self._many_sources:
            size = block_size(self.mesh.n_vertices)
            for start in range(0, len(single), size):
                block = np.array(single[start : start + size])
                phi, accurate = self._many_sources(np.array([queries[k].vertices[0] for k in block]))
                rows[block[accurate]] = phi.T
                left -= set(block[accurate].tolist())
        for k in sorted(left):
            rows[k] = self.from_sources(queries[k])["distance"]
        return rows

    def prepare(self) -> None:
        """Factor now what would be factored on first use."""
        if not self._refine and self._many_sources:
            self._heat.factor()

    def settings(self) -> dict[str, Any]:
        """Return how distances are computed, as plain values for a report."""
        return {
            "time": self.time.report(self._surface.mean_edge_length),
            "refined": self._refine,
            "bounded": self.bound,
            "boundary": self._heat.boundary,
            "solver": "multigrid" if self._heat.iterates else "direct",
            **({"robust": self.robust.report()} if self.robust else {}),
        }

    @cached_property
    def _many_sources(self) -> "ManySources | None":
        """Answers blocks of vertices; None where systems are solved by iteration."""
        if self._heat.iterates or not self._poisson.solve.factored:
            return None
        from geomhw.geodesic.many_sources import ManySources

        return ManySources(self.mesh, self._surface, self._heat, self._poisson, self.bound)

    @cached_property
    def _exact(self) -> "ExactDistance":
        from geomhw.geodesic.exact import ExactDistance

        return ExactDistance(self.mesh)

    def _report(self, sources: SurfacePoints, distance: Floats) -> dict[str, Any]:
        if np.isnan(distance).any():
            raise ConvergenceError("the distance came out undefined; look for faces of nearly no area")
        finite = np.isfinite(distance)
        farthest = int(np.where(finite, distance, -1.0).argmax())
        return {
            "sources": sources.report(),
            "farthest": {"vertex": farthest, "distance": float(distance[farthest])},
            "mean_distance": float(distance[finite].mean()),
            "unreachable_vertices": int(np.count_nonzero(~finite & self._heat.surface)),
            **self.settings(),
        }


def bounded(
    distance: Floats, paths: Floats, positive: NDArray[np.bool_], chord: Callable[[Ints], Floats], bound: bool = True
) -> tuple[Floats, dict[str, Any]]:
    """Clamp distances, (n,), to edge paths and, where they are not positive, to the chord; count both.

    positive: (n,) mask of the vertices whose distance is positive. chord: returns the distance in space from vertices
    to the nearest source. bound: whether to clamp, or only count.
    """
    long = (distance > paths * (1 + ROUNDING)) & np.isfinite(distance)
    low = (distance <= 0) & positive
    findings: dict[str, Any] = {}
    if long.any():
        excess = float((distance[long] / paths[long] - 1).max())
        findings["beyond_edge_paths"] = {"vertices": int(np.count_nonzero(long)), "most": excess}
    if low.any():
        findings["below_zero"] = {"vertices": int(np.count_nonzero(low)), "lowest": float(distance[low].min())}
    if not bound:
        return distance, findings
    distance = np.minimum(distance, paths)
    distance[low] = chord(np.flatnonzero(low))
    return distance, findings


def heat_distance(
    mesh: TriangleMesh,
    sources: Sequence[int] | Ints,
    time: str | float = "auto",
    robust: bool = False,
    refine: bool | None = None,
) -> Floats:
    """Return the geodesic distance from the nearest source vertex, (n,); for several queries keep a `HeatDistance`.

    Parameters
    ----------
    sources : source vertices, counted from 0.
    time, robust, refine : as in `HeatDistance`.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> heat_distance(grid(4, 4), [0], refine=True).max().round(6)
    np.float64(1.414214)
    """
    return np.asarray(HeatDistance(mesh, time, robust, refine).from_vertices(sources)["distance"])
