"""Systems M + tK for tangent vectors: conjugate gradients, preconditioned by multigrid for each component in space."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Complexes, Floats
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.poisson import DirichletProblem, conjugate_gradients, preconditioner_name
from geomhw.operators.parallel_transport import from_frames, in_frames


class TangentSystem:
    """Solves A x = b for tangent vectors as complex numbers; a `Solve` of `heat_step`.

    K differs from the Laplacian of each component in world axes by the curvature alone. So a multigrid cycle for
    M + tS on each of the three components, projected to the tangent planes, is the preconditioner.

    Parameters
    ----------
    scalar : returns M + tS, (k, k + g).
    frames : (k, 2, 3) array of tangent frames.
    """

    def __init__(self, scalar: Callable[[], sp.csr_array], frames: Floats) -> None:
        self._scalar, self._frames = scalar, frames

    def __call__(
        self,
        mesh: LocalMesh,
        matrix: sp.csr_array,
        rhs: Complexes,
        held: NDArray[np.bool_],
        values: Complexes,
        tolerance: float,
    ) -> tuple[Complexes, dict[str, Any]]:
        """As `solve_laplace`."""
        problem = DirichletProblem(mesh, self._scalar(), held)
        preconditioner = mesh.ranks.petsc.PC().create(mesh.ranks.comm)
        problem.precondition(preconditioner)
        preconditioner.setFromOptions()
        petsc, size = mesh.ranks.petsc, (2 * mesh.n_own, 2 * mesh.n_vertices)
        operator = petsc.Mat().createPython((size, size), _Operator(mesh, matrix, held), comm=mesh.ranks.comm)
        operator.setUp()

        def precondition(chosen: Any) -> None:
            chosen.setType("python")
            chosen.setPythonContext(_BySpaceComponent(problem, preconditioner, self._frames))

        left = np.where(held, 0.0, rhs - matrix @ mesh.with_ghosts(values))
        x, report = conjugate_gradients(mesh.ranks, operator, left.view(float), tolerance, precondition, "tangent_")
        report["preconditioner"] = preconditioner_name(preconditioner)
        for item in (operator, preconditioner, problem.matrix):
            item.destroy()
        return np.where(held, values, x.view(complex)), report


class _Operator:
    """Multiplies tangent vectors, real and imaginary parts in turn, by A without rows and columns of held ones."""

    def __init__(self, mesh: LocalMesh, matrix: sp.csr_array, held: NDArray[np.bool_]) -> None:
        self._mesh, self._matrix, self._held = mesh, matrix, held

    def mult(self, _: Any, given: Any, product: Any) -> None:
        """Set the product for a given vector."""
        z = given.getArray(readonly=1).view(complex)
        free = self._matrix @ self._mesh.with_ghosts(np.where(self._held, 0.0, z))
        product.setArray(np.where(self._held, z, free).view(float))


class _BySpaceComponent:
    """Applies a scalar preconditioner to each component in space of tangent vectors, and projects."""

    def __init__(self, problem: DirichletProblem, scalar: Any, frames: Floats) -> None:
        self._scalar, self._frames = scalar, frames
        self._given, self._found = problem.matrix.createVecLeft(), problem.matrix.createVecRight()

    def apply(self, _: Any, given: Any, found: Any) -> None:
        """Set the vector found for a given one."""
        vectors = from_frames(self._frames, given.getArray(readonly=1).view(complex))
        for column in vectors.T:
            self._given.setArray(column)
            self._scalar.apply(self._given, self._found)
            column[:] = self._found.getArray(readonly=1)
        found.setArray(in_frames(self._frames, vectors).view(float))
