"""One backward Euler step of the heat equation: (M + tS) u = u0."""

from collections.abc import Callable
from functools import cached_property
from typing import get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.diffusion_time import TimeStep, given_time
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import vertex_components
from geomhw.operators.laplacian import backward_euler, stiffness
from geomhw.options import Boundary, SolverName
from geomhw.solvers.decaying import DecayingSolver
from geomhw.solvers.log_scaled import REACH, LogValues


class HeatStep:
    """Solves (M + tS) u = u0 on one surface for any u0; factors on first use.

    Parameters
    ----------
    mesh : the surface.
    time : diffusion time t as in `time_step`, but not ``auto``.
    boundary : ``neumann`` (no heat leaves), ``dirichlet`` (the boundary is kept at zero) or ``average``, the mean of
        both solutions [GIH, sec. 3.4].
    boundary_vertices : where that condition holds; by default the boundary of the surface.
    solver, solves : as in `LaplaceSolver`. ``multigrid`` means sweeps that follow the heat.

    Raises
    ------
    MeshError
        If a face has zero area.
    ArgumentError
        For an unknown time, boundary condition or solver.

    References
    ----------
    [GIH, eq. 3]
    """

    def __init__(
        self,
        mesh: PolyhedralSurface,
        time: TimeStep | str | float = "h2",
        boundary: Boundary = "neumann",
        boundary_vertices: Ints | None = None,
        solver: SolverName = "auto",
        solves: int = 1,
    ) -> None:
        mesh.require_area("robust=True")
        if boundary not in get_args(Boundary):
            raise ArgumentError(
                f"there is no boundary condition '{boundary}'; choose from {', '.join(get_args(Boundary))}"
            )
        self.mesh, self.solver, self.solves = mesh, solver, solves
        self.time = time if isinstance(time, TimeStep) else given_time(time, mesh.mean_edge_length)
        self.stiffness = stiffness(mesh)
        self.surface = np.ones(mesh.n_vertices, dtype=bool)
        self.surface[mesh.unreferenced_vertices] = False
        inside = self.surface.copy()
        inside[mesh.boundary_vertices if boundary_vertices is None else boundary_vertices] = False
        self.boundary: Boundary = boundary if (inside != self.surface).any() else "neumann"
        self._conditions = []
        if self.boundary != "dirichlet":
            self._conditions.append(_Condition(self, self.surface, lambda: mesh.components))
        if self.boundary != "neumann":
            self._conditions.append(_Condition(self, inside, lambda: _components_within(mesh, inside)))

    @property
    def matrix(self) -> sp.csr_array:
        """M + tS, (n, n), assembled anew; units length², symmetric positive definite on vertices that have faces."""
        return backward_euler(self.mesh.vertex_areas, self.stiffness, self.time.t)

    @property
    def solution(self) -> DecayingSolver:
        """The solver of the first boundary condition."""
        return self._conditions[0].solve

    @property
    def iterates(self) -> bool:
        """Whether systems are solved by sweeps, without a factorization."""
        return self.solution.iterates

    def reached(self, impulse: NDArray[np.number]) -> NDArray[np.bool_]:
        """Mask, (n,), of the vertices on a component where the impulse is not zero."""
        return np.isin(self.mesh.components, self.mesh.components[np.flatnonzero(impulse)])

    def from_impulse(self, impulse: Floats, paths: Floats | None = None) -> LogValues:
        """Return u for u0 = impulse, (n,), integrated; in logarithms, so that it does not underflow with distance.

        Parameters
        ----------
        impulse : (n,) array, zero except at the sources.
        paths : `edge_path_distance` from the sources, (n,), if it is known.

        Raises
        ------
        ArgumentError
            If all sources lie on a boundary at temperature zero.
        ConvergenceError
            If heat does not reach the far side in double precision.
        """
        if self.boundary == "dirichlet" and not self._conditions[0].warmed(impulse):
            raise ArgumentError("no heat flows from sources on a boundary that is kept cold; take another condition")
        first, *second = (condition.from_impulse(impulse, paths) for condition in self._conditions)
        return first.mean_with(second[0]) if second else first

    def from_vertices(self, vertices: Ints) -> tuple[Floats, NDArray[np.bool_]]:
        """Return u from a unit impulse at each of k vertices, (n, k), and which columns, (k,), are accurate everywhere.

        A column is not where u underflows, or starts on a boundary at temperature zero.
        """
        found = [condition.from_vertices(vertices) for condition in self._conditions]
        heats, accurate = zip(*found, strict=True)
        return (heats[0] if len(heats) == 1 else (heats[0] + heats[1]) / 2), np.logical_and.reduce(accurate)

    def factor(self) -> None:
        """Factor now instead of on first use."""
        for condition in self._conditions:
            _ = condition.solve.factored


class _Condition:
    """The heat step under one boundary condition: its free vertices, (n,), and their connected components."""

    def __init__(self, step: HeatStep, free: NDArray[np.bool_], components: Callable[[], Ints]) -> None:
        self._mesh, self._step, self._free, self._components = step.mesh, step, free, components
        self.solve = DecayingSolver(lambda: step.matrix, free, step.solver, step.solves)

    @cached_property
    def _labels(self) -> Ints:
        return self._components()

    def warmed(self, impulse: Floats) -> bool:
        """Whether there is heat at a free vertex."""
        return bool(impulse[self._free].any())

    def from_impulse(self, impulse: Floats, paths: Floats | None) -> LogValues:
        """u on the components where heat is; zero elsewhere."""
        held = np.where(self._free, impulse, 0.0)
        sources = np.flatnonzero(held)
        there = np.isin(self._labels, self._labels[sources]) & self._free
        known = paths if self._free is self._step.surface else None

        def travel() -> Floats:
            """Path length in units of the decay length √t."""
            return (edge_path_distance(self._mesh, sources) if known is None else known) / np.sqrt(self._step.time.t)

        return self.solve(held, there, travel)

    def from_vertices(self, vertices: Ints) -> tuple[Floats, NDArray[np.bool_]]:
        """u from each vertex, (n, k), and whether its column stays in the range of doubles on its component, (k,)."""
        n, k = self._mesh.n_vertices, len(vertices)
        impulses = np.zeros((n, k))
        impulses[vertices, np.arange(k)] = self._free[vertices]
        with np.errstate(under="ignore"):
            heat = self.solve.factored(impulses)
        in_range = self._free[vertices]
        for label in np.unique(self._labels[vertices]):
            of, there = self._labels[vertices] == label, self._free & (self._labels == label)
            size = np.abs(heat if of.all() and there.all() else heat[np.ix_(there, of)])
            in_range[of] &= size.min(axis=0, initial=np.inf) > np.exp(-REACH) * size.max(axis=0, initial=0.0)
        return heat, in_range


def _components_within(mesh: PolyhedralSurface, inside: NDArray[np.bool_]) -> Ints:
    """Components that are connected by edges between vertices of a mask, (n,)."""
    return vertex_components(mesh.edges[inside[mesh.edges].all(axis=1)], mesh.n_vertices)
