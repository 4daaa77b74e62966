"""The Poisson equation of stream functions: constant on each boundary loop, one unknown a loop."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.boundary_loops import loop_prolongation
from geomhw.operators.laplacian import stiffness
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.nullspace import balanced, free_unknowns


class LoopPoisson:
    """Solves S f = b for f constant on each boundary loop; factors in the constructor, solves in the call."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self._E, stand_in = loop_prolongation(mesh)
        self._components = mesh.components[stand_in]
        lone = np.flatnonzero(np.isin(stand_in, mesh.unreferenced_vertices))
        K = (self._E.T @ stiffness(mesh) @ self._E).tocsr()
        self._solve = DirectSolver(K, free_unknowns(self._components, lone))

    @property
    def n_unknowns(self) -> int:
        """One an inner vertex and one a boundary loop."""
        return len(self._components)

    @property
    def unknown_of(self) -> Ints:
        """Which unknown each vertex has, (n,): those of one boundary loop share theirs."""
        return self._E.indices

    def gathered(self, b: Floats) -> Floats:
        """The sum of b, (n,), over the vertices of each unknown, (k,)."""
        return np.asarray(self._E.T @ b)

    def __call__(self, gathered: Floats) -> Floats:
        """f, (n,), zero at one vertex a component, for a right-hand side a unknown, (k,), less its mean there."""
        return np.asarray(self._E @ self._solve(balanced(gathered, self._components)))
