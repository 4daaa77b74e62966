"""Geodesic distance by the heat method [GIH, algorithm 1].

Let heat flow from the sources for a short time, keep only the direction in which it falls, and find the function whose
gradient points that way. Crane, Weischedel, Wardetzky: Geodesics in Heat, ACM Trans. Graph. 32(5), 2013.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, pieces
from geomhw.background import submit
from geomhw.errors import ConvergenceError
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_step import LEVEL, HeatStep
from geomhw.geodesic.many_sources import ManySources, block_size
from geomhw.geodesic.source_conditions import chord_to_nearest, held_distance, known_distances, source_heat
from geomhw.geodesic.unfolding import Unfolding
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.geometry import at_corners, lengths, unit
from geomhw.mesh.orientation import without_duplicate_faces
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.surface_points import SurfacePoints, vertex_points
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence_of
from geomhw.operators.gradient import corner_gradients
from geomhw.options import Boundary, SolverName
from geomhw.results import Field, Result
from geomhw.solvers.auto import LaplaceSolver
from geomhw.solvers.cost_model import Work
from geomhw.solvers.log_scaled import LogValues
from geomhw.solvers.nullspace import balanced, free_unknowns
from geomhw.stages import Stages

#: Beside a source on a coarse mesh, distances may come out a third shorter than the straight line; below this share of
#: it, they are wrong.
LEAST_CHORD_SHARE = 0.5


class HeatDistance:
    """Heat-method solver for one mesh and time: factors on first use, then answers any sources.

    time: as in `time_step`. robust: compute on the intrinsic Delaunay triangulation of the mesh, see
    `RobustTriangulation`, where heat is nowhere negative and faces without area do no harm; h is then the mean edge
    length there. refine: correct the distances by `Unfolding`; by default where robust is asked for. boundary: how heat
    meets the boundary, as in `HeatStep`; the mean of both conditions is best next to it. solver: ``direct`` factors,
    once for all sources; ``multigrid`` iterates, which on large meshes takes a fraction of that; ``auto`` goes by the
    size of the mesh and by how many queries are to come, and factors where iteration does not converge. Copies of faces
    are left out. stages: seconds by stage. MeshError if a face has no area and robust is not asked for, FieldError for
    a time, a condition or a solver that is none.

    >>> from geomhw.mesh.primitives import icosphere
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
    ) -> None:
        self.mesh = mesh
        self.stages = Stages()
        self._refine = robust if refine is None else refine
        with self.stages("connectivity"):
            # Areas do not wait for edges.
            areas = None if robust else submit(lambda: (mesh.degenerate_faces, mesh.vertex_areas))
            self._single = single = without_duplicate_faces(mesh)
            if areas:
                areas.result()
        self.robust: RobustTriangulation | None = None
        if robust:
            with self.stages("triangulation"):
                self.robust = RobustTriangulation.of(single)
        self._domain = self.robust.surface if self.robust else single
        work = Work(queries, min(queries, block_size(mesh.n_vertices)))
        with self.stages("assembly"):
            self._flow = HeatStep(self._domain, time, boundary, single.boundary_vertices, solver, work)

    @property
    def time(self) -> TimeStep:
        """The time that heat flows, and why."""
        return self._flow.time

    @cached_property
    def _free(self) -> NDArray[np.bool_]:
        return free_unknowns(self.mesh.components, self.mesh.unreferenced_vertices)

    @cached_property
    def _poisson_solver(self) -> LaplaceSolver:
        return LaplaceSolver(self._flow.stiffness, self._free, self._flow.solver, self._flow.work)

    @cached_property
    def _rows(self) -> ManySources | None:
        """What answers many vertices at once; nothing where systems are solved by iteration."""
        if self._flow.iterates or not self._poisson_solver.factored:
            return None
        return ManySources(self.mesh, self._domain, self._flow, self._poisson_solver)

    @cached_property
    def _unfolding(self) -> Unfolding:
        return Unfolding(self._domain, angle_defects(self._single))

    @cached_property
    def _unfolding_of_mesh(self) -> Unfolding:
        return Unfolding(self._single, angle_defects(self._single))

    def from_vertices(self, sources: Sequence[int] | Ints) -> Result:
        """Distance from the nearest of the source vertices; fields as in `from_sources`."""
        return self.from_sources(vertex_points(self.mesh, sources))

    def from_sources(self, sources: SurfacePoints) -> Result:
        """Distance from the nearest of the sources, vertices or points within faces, in any order.

        Fields, per vertex: ``heat`` u, with (M + tS) u = 1 at a single source, shared by the corners of its face if it
        lies in one, and of several vertices such that all are equally warm; ``divergence``, integrated, of the unit
        field; ``distance`` (length), exactly 0 at source vertices, straight at the corners of a face with a source in
        it, positive elsewhere and no longer than the shortest path along edges, inf on components without a source. Per
        face of the mesh: ``heat_gradient`` ∇u, ``direction`` -∇u/|∇u|, zero where no heat comes, where there is no
        area, and between three source vertices.
        """
        mesh, stage = self.mesh, self.stages
        wanted = sources[sources.distinct()[0]]
        self._poisson_solver.begin()
        with stage("paths along edges"):
            start = known_distances(mesh, wanted)
            paths = edge_path_distance(self._domain, np.flatnonzero(np.isfinite(start)), start)
        with stage("heat"):
            impulse = source_heat(self._flow, wanted)
            heat = self._flow.from_impulse(impulse, None if len(wanted.within_faces) else paths)
            reached = self._flow.reached(impulse)
        with stage("directions and divergence"):
            gradients, directions = _slopes(self._domain, heat, wanted.vertices)
            spread = divergence_of(self._domain, directions)
        with stage("distance"):
            distance = self._distance(spread, wanted, start, reached, heat)
            distance, raised = self._bounded(distance, wanted, start, paths)
        if self._refine:
            with stage("unfolding"):
                distance, raised = self._unfolded(wanted, distance), {}
        with stage("results"):
            if self._domain is not mesh:
                gradients, directions = _slopes(mesh, heat, wanted.vertices)
            fields = [
                Field("heat", "vertex", heat.plain),
                Field("divergence", "vertex", spread),
                Field("distance", "vertex", distance),
                Field("heat_gradient", "face", gradients),
                Field("direction", "face", directions),
            ]
            return Result(mesh, fields, self._report(wanted, distance) | raised)

    def rows(self, queries: Sequence[SurfacePoints]) -> Floats:
        """Distances from each of several sets of sources, (k, n): those of `from_sources`, to rounding.

        Sets of one vertex are solved for in blocks, where systems are factored, at a fraction of the time.
        """
        rows = np.empty((len(queries), self.mesh.n_vertices))
        single = [k for k, sources in enumerate(queries) if len(sources) == len(sources.vertices) == 1]
        left = set(range(len(queries)))
        size = block_size(self.mesh.n_vertices)
        if self._rows and len(single) > 1:
            for start in range(0, len(single), size):
                block = np.array(single[start : start + size])
                found, sound = self._rows(np.array([queries[k].vertices[0] for k in block]))
                rows[block[sound]] = found.T
                left -= set(block[sound].tolist())
            if self._refine:
                for k in set(single) - left:
                    rows[k] = self._unfolded(queries[k], rows[k])
        for k in sorted(left):
            rows[k] = self.from_sources(queries[k])["distance"]
        return rows

    def prepare(self) -> None:
        """Factor now what would be factored on first use."""
        if self._rows:
            self._flow.prepare()

    def _unfolded(self, sources: SurfacePoints, distance: Floats) -> Floats:
        """Distances corrected by unfolding."""
        # A face that holds a source is one of the mesh, and may be none of another triangulation.
        unfold = self._unfolding_of_mesh if self.robust and len(sources.within_faces) else self._unfolding
        chord = chord_to_nearest(self.mesh, sources)
        return np.maximum(unfold(known_distances(self.mesh, sources), distance), chord)

    def settings(self) -> dict[str, Any]:
        """What a report says of how distances are computed."""
        factored = self._flow.factorization
        return {
            "time": self.time.report(self._flow.mesh.mean_edge_length),
            "refined": self._refine,
            "boundary": self._flow.boundary,
            **({"solver": "direct", "factorization": factored} if factored else {"solver": "multigrid"}),
            **({"robust": self.robust.report()} if self.robust else {}),
        }

    def _distance(
        self, spread: Floats, sources: SurfacePoints, start: Floats, reached: Ints, heat: LogValues
    ) -> Floats:
        """φ with Sφ = -Div X, right at the sources."""
        mesh = self.mesh
        labels = mesh.components[sources.corners[:, 0]]
        if len(np.unique(labels)) == len(sources) == len(sources.vertices):
            # One vertex a component: any grounding will do, and the solution is shifted.
            # Heat falls about as exp(-φ/√t): Varadhan, On the behavior of the fundamental solution, 1967.
            guess = np.where(np.isfinite(heat.log), -np.sqrt(self.time.t) * heat.log, 0.0)
            self._shift(guess, np.flatnonzero(~self._free))
            phi = self._poisson_solver(balanced(-spread, mesh.components), guess)
            self._shift(phi, sources.vertices)
            phi[sources.vertices] = 0.0
        else:
            phi = held_distance(self._flow, spread, start, reached)
        phi[~reached] = np.inf
        return phi

    def _shift(self, values: Floats, vertices: Ints) -> None:
        """Shift values, (n,), in place, so as to be zero at these vertices, one a component."""
        zero = np.zeros(self.mesh.n_components + len(self.mesh.unreferenced_vertices))
        zero[self.mesh.components[vertices]] = values[vertices]
        values -= zero[self.mesh.components]

    def _bounded(
        self, distance: Floats, sources: SurfacePoints, start: Floats, paths: Floats
    ) -> tuple[Floats, dict[str, Any]]:
        """No longer than the shortest path along edges; and where the method errs below zero, as it can beside a
        source, no shorter than the chord: the report says at how many vertices, and how far below."""
        distance = np.minimum(distance, paths)
        low = (distance <= 0) & (start > 0)
        if not low.any():
            return distance, {}
        raised = {"vertices": int(np.count_nonzero(low)), "lowest": float(distance[low].min())}
        distance[low] = chord_to_nearest(self.mesh, sources, np.flatnonzero(low))
        return distance, {"below_zero": raised}

    def _report(self, sources: SurfacePoints, distance: Floats) -> dict[str, Any]:
        finite = np.isfinite(distance)
        if np.isnan(distance).any():
            raise ConvergenceError("the distance came out undefined; look for faces of nearly no area")
        farthest = int(np.where(finite, distance, -1.0).argmax())
        unreached = int(np.count_nonzero(~finite & self._flow.surface))
        chord = chord_to_nearest(self.mesh, sources)
        too_short = int(np.count_nonzero(distance < LEAST_CHORD_SHARE * chord))
        return {
            "sources": sources.report(),
            "farthest": {"vertex": farthest, "distance": float(distance[farthest])},
            "mean_distance": float(distance[finite].mean()),
            "unreachable_vertices": unreached,
            **self.settings(),
            **({"too_short_distances": too_short} if too_short else {}),
        }


def _slopes(surface: PolyhedralSurface, heat: LogValues, vertices: Ints) -> tuple[Floats, Floats]:
    """∇u and -∇u/|∇u| per face, (m, 3) each; the latter zero where u is flat but for rounding, as between three source
    vertices."""
    named = np.zeros(surface.n_vertices, dtype=bool)
    named[vertices] = True
    gradients, directions = np.empty((2, 3, surface.n_faces)).transpose(0, 2, 1)
    for faces in pieces(surface.n_faces):
        slopes, scale = _scaled_slopes(surface, faces, heat)
        np.multiply(slopes, np.exp(scale)[:, None], out=gradients[faces])
        flat = lengths(slopes) * np.sqrt(surface.face_areas[faces]) < LEVEL
        slopes[flat | at_corners(named, surface.faces[faces]).all(axis=1)] = 0.0
        directions[faces] = unit(np.negative(slopes, out=slopes))
    return gradients, directions


def _scaled_slopes(surface: PolyhedralSurface, faces: slice, heat: LogValues) -> tuple[Floats, Floats]:
    """exp(-s) ∇u on some faces, (k, 3), and s, (k,): u is scaled face by face to order one."""
    corners = at_corners(heat.log, surface.faces[faces])
    a, b, c = corners.T
    largest = np.maximum(np.maximum(a, b), c)
    warm = np.isfinite(largest)
    if not warm.all():
        corners[~warm], largest[~warm] = -np.inf, 0.0
    corners -= largest[:, None]
    relative = np.exp(corners, out=corners)
    relative *= at_corners(heat.sign, surface.faces[faces])
    return corner_gradients(surface, faces, relative), largest


def heat_distance(
    mesh: TriangleMesh,
    sources: Sequence[int] | Ints,
    time: str | float = "auto",
    robust: bool = False,
    refine: bool | None = None,
) -> Floats:
    """Geodesic distance from the nearest source vertex, (n,); for several questions keep a `HeatDistance`."""
    return np.asarray(HeatDistance(mesh, time, robust, refine).from_vertices(sources)["distance"])
