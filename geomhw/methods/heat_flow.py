"""A short flow of heat over a mesh, right at any distance from where it starts."""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.mesh.arrays import Floats
from geomhw.mesh.distances import edge_path_distance
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.methods.time_step import time_step
from geomhw.operators.laplacian import lumped_mass, stiffness
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.wavefront import LogValues, in_reach, solve_decaying

#: What to do about a face without area, for whoever asked for heat.
REMEDY = "collapse it, remove it, or compute with --robust (robust=True)"


class HeatFlow:
    """One backward Euler step of the heat equation: (M + tS) u = u0, with u0 integrated over vertices [GIH, eq. 3].

    Factors on first use. time: as in `time_step`. MeshError if a face has no area, FieldError for a time that is none.
    """

    def __init__(self, mesh: PolyhedralSurface, time: str | float = "auto") -> None:
        mesh.require_area(REMEDY)
        self.mesh = mesh
        self.time = time_step(time, mesh.mean_edge_length)
        self.stiffness = stiffness(mesh)
        self.surface = np.ones(mesh.n_vertices, dtype=bool)
        self.surface[mesh.unreferenced_vertices] = False

    @cached_property
    def matrix(self) -> Any:
        """M + tS, (n, n), units length², symmetric positive definite on vertices that have faces."""
        return (lumped_mass(self.mesh) + self.time.t * self.stiffness).tocsr()

    @cached_property
    def _solver(self) -> DirectSolver:
        return DirectSolver(self.matrix, self.surface)

    def reached(self, impulse: NDArray[Any]) -> NDArray[np.bool_]:
        """Mask, (n,), of the vertices on a component where the impulse is not zero."""
        return np.isin(self.mesh.components, self.mesh.components[np.flatnonzero(impulse)])

    def from_impulse(self, impulse: Floats) -> LogValues:
        """u for u0 = impulse, (n,), zero but at the sources; in logarithms, so that it does not fade with distance."""
        with np.errstate(under="ignore"):
            u = self._solver(impulse)
        there = self.reached(impulse)
        if in_reach(u[there]):
            return LogValues.of(u)
        where = np.flatnonzero(there)
        travel = edge_path_distance(self.mesh, np.flatnonzero(impulse))[where] / np.sqrt(self.time.t)
        far = solve_decaying(self.matrix[where][:, where], impulse[where], u[where], travel)
        heat = LogValues.of(np.zeros(self.mesh.n_vertices))
        heat.log[where], heat.sign[where] = far.log, far.sign
        return heat
