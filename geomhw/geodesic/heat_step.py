"""A short flow of heat over a mesh, right at any distance from where it starts."""

from functools import cached_property
from typing import Any, get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ConvergenceError, FieldError
from geomhw.geodesic.diffusion_time import time_step
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import vertex_components
from geomhw.operators.laplacian import backward_euler, stiffness
from geomhw.options import Boundary, SolverName
from geomhw.solvers.auto import iterates
from geomhw.solvers.cost_model import ONE, Work
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.heat_sweeps import over_relaxation, solve_by_sweeps, solve_scaled_by_sweeps
from geomhw.solvers.log_scaled import REACH, LogValues, in_reach, solve_decaying, solve_scaled

#: What to do about a face without area, for whoever asked for heat.
REMEDY = "collapse it, remove it, or compute with --robust (robust=True)"
#: Heat that differs by less than this share of itself over a face falls in no direction: what is left is rounding.
LEVEL = 1e-9


class HeatStep:
    """One backward Euler step of the heat equation: (M + tS) u = u0, with u0 integrated over vertices [GIH, eq. 3].

    Factors on first use. time: as in `time_step`. boundary: what holds at the rim, the vertices of the mesh's boundary;
    nothing where there are none. solver: ``direct`` by factorization; ``multigrid``, here by sweeps that follow the
    heat; or ``auto``, which goes by the size and by the work to come. MeshError if a face has no area, FieldError for a
    time or a boundary that is none.
    """

    def __init__(
        self,
        mesh: PolyhedralSurface,
        time: str | float = "auto",
        boundary: Boundary = "neumann",
        rim: Ints | None = None,
        solver: SolverName = "auto",
        work: Work = ONE,
    ) -> None:
        mesh.require_area(REMEDY)
        if boundary not in get_args(Boundary):
            raise FieldError(
                f"there is no boundary condition '{boundary}'; choose from {', '.join(get_args(Boundary))}"
            )
        self.mesh = mesh
        self.solver = solver
        self.work = work
        self.iterates = iterates(solver, mesh.n_vertices, work, "sweeps")
        self.time = time_step(time, mesh.mean_edge_length)
        self.stiffness = stiffness(mesh)
        self.surface = np.ones(mesh.n_vertices, dtype=bool)
        self.surface[mesh.unreferenced_vertices] = False
        self._inside = self.surface.copy()
        self._inside[mesh.boundary_vertices if rim is None else rim] = False
        self.boundary: Boundary = boundary if (self._inside != self.surface).any() else "neumann"

    @property
    def matrix(self) -> sp.csr_array:
        """M + tS, (n, n), not kept, units length², symmetric positive definite on vertices that have faces."""
        return backward_euler(self.mesh.vertex_areas, self.stiffness, self.time.t)

    @cached_property
    def _solvers(self) -> dict[bool, DirectSolver]:
        return {}

    def _solver(self, open_end: bool) -> DirectSolver:
        """The factorization with the rim free or held at zero, made once."""
        if open_end not in self._solvers:
            self._solvers[open_end] = DirectSolver(self.matrix, self.surface if open_end else self._inside, self.work)
        return self._solvers[open_end]

    @cached_property
    def relaxation(self) -> float:
        """ω by which sweeps settle soonest, as `over_relaxation` finds it."""
        masses = self.mesh.vertex_areas[self.surface]
        return over_relaxation(masses, masses + self.time.t * self.stiffness.diagonal()[self.surface])

    @cached_property
    def _components_inside(self) -> Ints:
        edges = self.mesh.edges
        return vertex_components(edges[self._inside[edges].all(axis=1)], self.mesh.n_vertices)

    def reached(self, impulse: NDArray[Any]) -> NDArray[np.bool_]:
        """Mask, (n,), of the vertices on a component where the impulse is not zero."""
        return np.isin(self.mesh.components, self.mesh.components[np.flatnonzero(impulse)])

    def from_impulse(self, impulse: Floats, paths: Floats | None = None) -> LogValues:
        """u for u0 = impulse, (n,), zero but at the sources; in logarithms, so that it does not fade with distance.

        paths: `edge_path_distance` from there, if it is known. FieldError where all sources are on a rim that is kept
        cold.
        """
        insulated = cold = None
        if self.boundary != "dirichlet":
            insulated = self._decaying(impulse, self.reached(impulse), self.surface, paths)
        if self.boundary != "neumann":
            inner = np.where(self._inside, impulse, 0.0)
            if self.boundary == "dirichlet" and not inner.any():
                raise FieldError("no heat flows from sources on a boundary that is kept cold; take another condition")
            labels = self._components_inside
            there = np.isin(labels, labels[np.flatnonzero(inner)]) & self._inside
            cold = self._decaying(inner, there, self._inside)
        if insulated is None or cold is None:
            return insulated or cold or LogValues.of(impulse)
        return insulated.mean_with(cold)

    def prepare(self) -> None:
        """Factor now what would be factored on first use."""
        for open_end in (True, False):
            if self.boundary != ("dirichlet" if open_end else "neumann"):
                self._solver(open_end)

    @property
    def factorization(self) -> str:
        """By what the system was factored, as `DirectSolver` names it; empty where it has not been."""
        return next((solver.factorization for solver in self._solvers.values()), "")

    def from_vertices(self, vertices: Ints) -> tuple[Floats, NDArray[np.bool_]]:
        """u from each of k vertices for itself, (n, k), and which of these, (k,), are right at every vertex: those that
        do not fade out of the reach of double precision, nor start on a rim that is kept cold."""
        n, k = self.mesh.n_vertices, len(vertices)
        impulses = np.zeros((n, k))
        impulses[vertices, np.arange(k)] = 1.0
        heats, sound = [], np.ones(k, dtype=bool)
        with np.errstate(under="ignore"):
            if self.boundary != "dirichlet":
                heats.append(self._solver(True)(impulses))
                sound &= _in_reach(heats[0], self.mesh.components, self.surface, vertices)
            if self.boundary != "neumann":
                impulses[~self._inside] = 0.0
                heats.append(self._solver(False)(impulses))
                sound &= _in_reach(heats[-1], self._components_inside, self._inside, vertices)
            return (heats[0] if len(heats) == 1 else (heats[0] + heats[1]) / 2), sound

    def _decaying(
        self, impulse: Floats, there: NDArray[np.bool_], free: NDArray[np.bool_], paths: Floats | None = None
    ) -> LogValues:
        """The solution on the part of the mesh where heat comes; zero where it is not free to be else."""

        def travel() -> Floats:
            """How far heat has come, in lengths √t."""
            known = edge_path_distance(self.mesh, np.flatnonzero(impulse)) if paths is None else paths
            return np.asarray(known[where] / np.sqrt(self.time.t))

        where = np.flatnonzero(there)
        if self.iterates and len(where):
            try:
                found = solve_by_sweeps(self._matrix_of(where), impulse[where], travel(), self.relaxation)
                return self._elsewhere_none(found, where)
            except ConvergenceError:
                if self.solver == "multigrid":
                    raise
                self.iterates = False
        with np.errstate(under="ignore"):
            u = self._solver(free is self.surface)(impulse)
        if in_reach(u[there]):
            return LogValues.of(u)
        A, away = self._matrix_of(where), travel()
        try:
            found = solve_decaying(A, impulse[where], u[where], away)
        except ConvergenceError:  # heat that decays here and there at different rates
            if self.solver != "auto":
                raise
            found = solve_by_sweeps(A, impulse[where], away, self.relaxation)
        return self._elsewhere_none(found, where)

    def _matrix_of(self, where: Ints) -> sp.csr_array:
        A = self.matrix
        return A if len(where) == len(self.surface) else A[where][:, where]

    def scaled(self, matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats) -> NDArray[Any]:
        """v = exp(p) u for A u = b, as `wavefront.solve_scaled`, where b diffuses as heat does and p = -log of that."""
        if self.iterates:
            try:
                return solve_scaled_by_sweeps(matrix, rhs, potential, self.relaxation)
            except ConvergenceError:
                if self.solver == "multigrid":
                    raise
                self.iterates = False
        return solve_scaled(matrix, rhs, potential)

    def _elsewhere_none(self, part: LogValues, where: Ints) -> LogValues:
        heat = LogValues.of(np.zeros(self.mesh.n_vertices))
        heat.log[where], heat.sign[where] = part.log, part.sign
        return heat


def _in_reach(heat: Floats, labels: Ints, part: NDArray[np.bool_], vertices: Ints) -> NDArray[np.bool_]:
    """Of each column, from one of the vertices, whether it is `in_reach` in the part with the label of that vertex."""
    sound = part[vertices]
    for label in np.unique(labels[vertices]):
        of, there = labels[vertices] == label, part & (labels == label)
        size = np.abs(heat if of.all() and there.all() else heat[np.ix_(there, of)])
        sound[of] &= size.min(axis=0, initial=np.inf) > np.exp(-REACH) * size.max(axis=0, initial=0.0)
    return sound
