"""The function φ with S φ = -Div X and known values: conjugate gradients with algebraic multigrid, by PETSc."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.ranks import Ranks
from geomhw.errors import ConvergenceError

#: Residual of the preconditioned system over that of zero, at which iteration ends, and iterations at most.
TOLERANCE, MOST_ITERATIONS = 1e-11, 500
#: Options of hypre's BoomerAMG for stiffness matrices of surfaces.
BOOMERAMG = {
    "strong_threshold": 0.25,
    "coarsen_type": "PMIS",
    "interp_type": "ext+i",
    "P_max": 4,
    "truncfactor": 0.2,
    "relax_type_all": "symmetric-SOR/Jacobi",
}


class DirichletProblem:
    """A x = b for a symmetric positive semidefinite A, with x known at held vertices; A is copied to PETSc.

    Parameters
    ----------
    matrix : A, (k, k + g), the rows of this rank.
    held : (k,) mask of known values. Every component needs one, and every vertex without an equation is one.
    """

    def __init__(self, mesh: LocalMesh, matrix: sp.csr_array, held: NDArray[np.bool_]) -> None:
        petsc, k = mesh.ranks.petsc, mesh.n_own
        self._held, self._ranks = held, mesh.ranks
        A = _with_identity(matrix, mesh.with_ghosts(held))
        columns = mesh.numbers_of(A.indices).astype(petsc.IntType)
        sizes = ((k, mesh.n_vertices), (k, mesh.n_vertices))
        csr = (A.indptr.astype(petsc.IntType, copy=False), columns, A.data)
        #: A in PETSc, without the rows and columns of held vertices.
        self.matrix = petsc.Mat().createAIJ(sizes, csr=csr, comm=mesh.ranks.comm)

    def solve(self, rhs: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, dict[str, Any]]:
        """Return x, (k,), zero where held, and the number of iterations and the preconditioner, for a report.

        Parameters
        ----------
        rhs : b less the share of known values, (k,).
        tolerance : of the preconditioned residual, relative to that of zero.

        Raises
        ------
        ConvergenceError
            If the iteration does not converge.
        """
        x, report = conjugate_gradients(
            self._ranks, self.matrix, np.where(self._held, 0.0, rhs), tolerance, self.precondition
        )
        self.matrix.destroy()
        x[self._held] = 0.0  # GAMG leaves rounding errors there
        return x, report

    def precondition(self, preconditioner: Any) -> None:
        """Set a PETSc preconditioner to BoomerAMG, or GAMG where PETSc is without hypre."""
        petsc = self._ranks.petsc
        preconditioner.setOperators(self.matrix)
        try:
            preconditioner.setType("hypre")
            preconditioner.setHYPREType("boomeramg")
        except petsc.Error:
            preconditioner.setType("gamg")
            return
        options = petsc.Options()
        for name, value in BOOMERAMG.items():
            if not options.hasName(option := f"pc_hypre_boomeramg_{name}"):  # PETSC_OPTIONS decide
                options.setValue(option, value)


def conjugate_gradients(
    ranks: Ranks, matrix: Any, rhs: Floats, tolerance: float, precondition: Callable[[Any], None], prefix: str = ""
) -> tuple[Floats, dict[str, Any]]:
    """Solve A x = b for the rows of a rank; return x, and iterations and preconditioner for a report.

    Parameters
    ----------
    matrix : A as a matrix of PETSc, symmetric and positive definite.
    rhs : b in the rows of this rank.
    tolerance : of the preconditioned residual, relative to that of zero.
    precondition : sets a preconditioner of PETSc; PETSC_OPTIONS may replace it.
    prefix : of the names of options of PETSc.

    Raises
    ------
    ConvergenceError
        If the iteration does not converge.
    """
    solver = ranks.petsc.KSP().create(ranks.comm)
    solver.setOptionsPrefix(prefix)
    solver.setOperators(matrix)
    solver.setType("cg")
    precondition(solver.getPC())
    solver.setTolerances(rtol=tolerance, atol=0.0, max_it=MOST_ITERATIONS)
    b, x = matrix.createVecLeft(), matrix.createVecRight()
    b.setArray(rhs)
    solver.setFromOptions()
    solver.solve(b, x)
    found, reason, iterations = x.getArray().copy(), solver.getConvergedReason(), solver.getIterationNumber()
    name = preconditioner_name(solver.getPC())
    for item in (solver, b, x):
        item.destroy()
    if reason == ranks.petsc.KSP.ConvergedReason.DIVERGED_INDEFINITE_MAT:
        raise ConvergenceError(
            "the system of a time step is not positive definite, since very obtuse angles have negative cotan weights; "
            "take a shorter time"
        )
    if reason <= 0:
        raise ConvergenceError(
            f"a linear system is not solved after {iterations} iterations (PETSc's reason {reason}); "
            "look for faces of nearly no area"
        )
    return found, {"iterations": iterations, "preconditioner": name}


def preconditioner_name(preconditioner: Any) -> str:
    """Return the name of a PETSc preconditioner, for a report."""
    kind = str(preconditioner.getType())
    return str(preconditioner.getHYPREType()) if kind == "hypre" else kind


def solve_laplace(
    mesh: LocalMesh,
    matrix: sp.csr_array,
    rhs: Floats,
    held: NDArray[np.bool_],
    values: Floats,
    tolerance: float = TOLERANCE,
) -> tuple[Floats, dict[str, Any]]:
    """Solve A x = b with x known at held vertices, ``values`` there and zero elsewhere, (k,); as `DirichletProblem`."""
    left = rhs - matrix @ mesh.with_ghosts(values)
    x, report = DirichletProblem(mesh, matrix, held).solve(left, tolerance)
    return np.where(held, values, x), report


def _with_identity(matrix: sp.csr_array, fixed: NDArray[np.bool_]) -> sp.csr_array:
    """The matrix without the rows and columns of fixed unknowns, and with 1 on their diagonal."""
    rows = np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))
    cut, diagonal = fixed[rows] | fixed[matrix.indices], rows == matrix.indices
    data = np.where(cut, 0.0, matrix.data)
    data[cut & diagonal] = 1.0
    A = sp.csr_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)
    empty = np.ones(matrix.shape[0], dtype=bool)
    empty[rows[diagonal]] = False
    if empty.any():  # vertices without faces
        A = A + sp.diags_array(empty.astype(float), shape=matrix.shape, format="csr")
    return A
