"""The Poisson equation of stream functions, which are constant on each boundary loop."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.boundary_loops import loop_constant_basis
from geomhw.operators.laplacian import stiffness
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.nullspace import free_unknowns, without_mean


class StreamFunctionSolver:
    """Solve S ψ = b for ψ constant on each boundary loop: n x ∇ψ does not cross the boundary.

    There are k unknowns: one for each inner vertex and one for each boundary loop. EᵀSE is factored in the constructor,
    with E the 0/1 matrix, (n, k), from unknowns to vertices.

    Attributes
    ----------
    unknown_of : (n,) array, the unknown of each vertex.
    loops : the unknowns of the boundary loops.
    n_unknowns : k.

    Raises
    ------
    MeshError
        If a face has zero area.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._E, representative = loop_constant_basis(mesh)
        self._components = mesh.components[representative]
        self.n_unknowns = len(representative)
        self.unknown_of: Ints = self._E.indices
        self.loops: Ints = np.unique(self.unknown_of[mesh.boundary_vertices])
        isolated = np.flatnonzero(np.isin(representative, mesh.unreferenced_vertices))
        K = (self._E.T @ stiffness(mesh) @ self._E).tocsr()
        self._solve = DirectSolver(K, free_unknowns(self._components, isolated))

    def gather(self, b: Floats) -> Floats:
        """Return Eᵀb, (k,): the sum of b, (n,), over the vertices of each unknown."""
        return np.asarray(self._E.T @ b)

    def __call__(self, b: Floats) -> Floats:
        """Solve for ψ, (n,), zero at one vertex of each component.

        Parameters
        ----------
        b : (k,) array, the right-hand side for each unknown; its mean on each component is removed.
        """
        return np.asarray(self._E @ self._solve(without_mean(b, self._components)))
