"""The function φ with S φ = -Div X and known values: conjugate gradients with algebraic multigrid, by PETSc."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.errors import ConvergenceError

#: Residual of the preconditioned system over that of zero, at which iteration ends, and iterations at most.
TOLERANCE, MOST_ITERATIONS = 1e-11, 500
#: Options of hypre's BoomerAMG for stiffness matrices of surfaces.
BOOMERAMG = {
    "strong_threshold": 0.25,
    "coarsen_type": "HMIS",
    "interp_type": "ext+i",
    "P_max": 4,
    "relax_type_all": "symmetric-SOR/Jacobi",
}


def solve_laplace(
    mesh: LocalMesh,
    matrix: sp.csr_array,
    rhs: Floats,
    held: Ints,
    values: Floats,
    *,
    isolated: Ints | None = None,
    tolerance: float = TOLERANCE,
) -> tuple[Floats, dict[str, Any]]:
    """Solve A x = b for a symmetric positive semidefinite A, with x known at held vertices.

    Parameters
    ----------
    matrix : A, (k, k + g), the rows of this rank.
    rhs : b, (k,).
    held : (k,) mask of known values; values : (k,), x there, zero elsewhere. Every component needs one.
    isolated : (k,) mask of unknowns without an equation, which are zero.
    tolerance : of the preconditioned residual, relative to that of zero.

    Returns
    -------
    x, (k,), and the number of iterations and the preconditioner, for a report.

    Raises
    ------
    ConvergenceError
        If the iteration does not converge.
    """
    petsc, ranks, k = mesh.ranks.petsc, mesh.ranks, mesh.n_own
    if isolated is not None:
        held = held | isolated
    fixed, known = mesh.with_ghosts(held), mesh.with_ghosts(values)
    rhs = np.where(held, 0.0, rhs - matrix @ known)
    A = _with_identity(matrix, fixed)
    columns = mesh.numbers[A.indices].astype(petsc.IntType)
    sizes = ((k, mesh.n_vertices), (k, mesh.n_vertices))
    csr = (A.indptr.astype(petsc.IntType), columns, A.data)
    M = petsc.Mat().createAIJ(sizes, csr=csr, comm=ranks.comm)
    del A, columns, csr
    solver = petsc.KSP().create(ranks.comm)
    solver.setOperators(M)
    solver.setType("cg")
    name = _precondition(solver, petsc)
    solver.setTolerances(rtol=tolerance, atol=0.0, max_it=MOST_ITERATIONS)
    b, x = M.createVecLeft(), M.createVecRight()
    b.setArray(rhs)
    solver.setFromOptions()
    solver.solve(b, x)
    found, reason, iterations = x.getArray().copy(), solver.getConvergedReason(), solver.getIterationNumber()
    for item in (solver, M, b, x):
        item.destroy()
    if reason <= 0:
        raise ConvergenceError(
            f"the Poisson equation is not solved after {iterations} iterations (PETSc's reason {reason}); "
            "look for faces of nearly no area"
        )
    found[held] = values[held]
    return found, {"iterations": iterations, "preconditioner": name}


def _with_identity(matrix: sp.csr_array, fixed: Ints) -> sp.csr_array:
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


def _precondition(solver: Any, petsc: Any) -> str:
    """Choose BoomerAMG, or GAMG where PETSc is without hypre; return its name."""
    preconditioner = solver.getPC()
    try:
        preconditioner.setType("hypre")
        preconditioner.setHYPREType("boomeramg")
    except petsc.Error:
        preconditioner.setType("gamg")
        return "gamg"
    options = petsc.Options()
    for name, value in BOOMERAMG.items():
        options.setValue(f"pc_hypre_boomeramg_{name}", value)
    return "boomeramg"
