"""The function φ whose gradient is closest to the unit field X: S φ = -Div X [GIH, algorithm 1, step III].

φ is determined up to a constant on each component. With one source vertex there, it is shifted to zero at the source;
otherwise distances known near the sources are Dirichlet conditions.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.solvers.auto import LaplaceSolver
from geomhw.solvers.log_scaled import LogValues
from geomhw.solvers.nullspace import free_unknowns, without_mean


class DistancePoisson:
    """Solve S φ = -Div X on one surface; factors on first use.

    Parameters
    ----------
    mesh : the mesh in space.
    step : the heat step on the mesh or an intrinsic triangulation of it; it provides S.
    """

    def __init__(self, mesh: TriangleMesh, step: HeatStep) -> None:
        self._mesh, self._step = mesh, step

    @cached_property
    def solve(self) -> LaplaceSolver:
        """The solver for S with one vertex of each component held at zero."""
        return LaplaceSolver(self._step.stiffness, self._free, self._step.solver, self._step.solves)

    @cached_property
    def _free(self) -> NDArray[np.bool_]:
        return free_unknowns(self._mesh.components, self._mesh.unreferenced_vertices)

    def __call__(self, div: Floats, sources: SurfacePoints, known: Floats, heat: LogValues) -> Floats:
        """Return φ, (n,); inf on components without a source.

        Parameters
        ----------
        div : Div X, (n,), integrated.
        known : (n,) array of distances for Dirichlet conditions, inf elsewhere, as in `known_distances`.
        heat : u, from which an iteration starts.
        """
        components = self._mesh.components
        of_sources = components[sources.corners[:, 0]]
        reached = np.isin(components, of_sources)
        if len(np.unique(of_sources)) == len(sources) == len(sources.vertices):
            # -√t log u tends to φ: Varadhan, On the behavior of the fundamental solution of the heat equation, 1967.
            guess = np.where(np.isfinite(heat.log), -np.sqrt(self._step.time.t) * heat.log, 0.0)
            self._shift(guess, np.flatnonzero(~self._free))
            phi = self.solve(without_mean(-div, components), guess)
            self._shift(phi, sources.vertices)
            phi[sources.vertices] = 0.0
        else:
            phi = self._with_known(div, known, reached)
        phi[~reached] = np.inf
        return phi

    def from_vertices(self, div: Floats, vertices: Ints) -> Floats:
        """Return φ, (n, k), inf on other components, for k unit fields with one source vertex each.

        The system has to be factored.

        Parameters
        ----------
        div : Div X, (n, k), integrated.
        vertices : (k,) array of source vertices.
        """
        assert self.solve.factored
        components, columns = self._mesh.components, np.arange(len(vertices))
        phi = self.solve.factored(without_mean(-div, components))
        phi -= phi[vertices, columns]
        phi[vertices, columns] = 0.0
        if self._mesh.n_components + len(self._mesh.unreferenced_vertices) > 1:
            phi[components[:, None] != components[vertices]] = np.inf
        return phi

    def _with_known(self, div: Floats, known: Floats, reached: NDArray[np.bool_]) -> Floats:
        """φ with the known distances as Dirichlet conditions; zero on components without a source."""
        S, held = self._step.stiffness, np.flatnonzero(np.isfinite(known))
        phi = np.where(np.isfinite(known), known, 0.0)
        free = free_unknowns(self._mesh.components, self._mesh.unreferenced_vertices, held=held) & reached
        return np.asarray(phi + LaplaceSolver(S, free, self._step.solver)(-div - S @ phi))

    def _shift(self, values: Floats, vertices: Ints) -> None:
        """Shift values, (n,), in place, to zero at vertices, at most one per component."""
        mesh = self._mesh
        zero = np.zeros(mesh.n_components + len(mesh.unreferenced_vertices))
        zero[mesh.components[vertices]] = values[vertices]
        values -= zero[mesh.components]
