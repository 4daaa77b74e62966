"""Direct solvers behind one front door: factor in the constructor, solve in the call."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.errors import ConvergenceError
from geomhw.solvers.cholmod import Cholmod
from geomhw.solvers.cost_model import OCCASIONAL, FactorName, Work, cheapest
from geomhw.solvers.fronts import BlockCholesky
from geomhw.solvers.superlu import SuperLU
from geomhw.solvers.threads import single_threaded

_FACTORS: dict[FactorName, Callable[[sp.csr_array], Any]] = {
    "superlu": SuperLU,
    "blocks": BlockCholesky,
    "cholmod": Cholmod,
}


class DirectSolver:
    """Solves A x = b by a factorization, for A symmetric (Hermitian) and nearly always positive definite.

    free: the unknowns that are solved for, a boolean (n,) mask, by default all; the others are held at zero and their
    equations dropped. This grounds a semidefinite matrix (one vertex a component held) and drops empty rows. work: what
    is to come, by which the factorization is chosen that is cheapest in all; SuperLU steps in where the matrix turns
    out not to be positive definite. factorization: the one that was made.

    Raises ConvergenceError if the matrix is singular on the free unknowns.
    """

    factorization: FactorName = "superlu"

    def __init__(self, matrix: sp.csr_array, free: NDArray[np.bool_] | None = None, work: Work = OCCASIONAL) -> None:
        self._free = None if free is None or free.all() else np.flatnonzero(free)
        kept = matrix if self._free is None else matrix[self._free][:, self._free]
        self._dtype = kept.dtype
        if not kept.shape[0]:
            return
        self.factorization = cheapest(kept.shape[0], work)
        with single_threaded():
            try:
                self._solve = _FACTORS[self.factorization](kept)
            except ConvergenceError:
                if self.factorization == "superlu":
                    raise
                self.factorization = "superlu"
                self._solve = SuperLU(kept)

    def __call__(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """x for one right-hand side, (n,), or several, (n, k); zero where not free."""
        with single_threaded():
            if self._free is None:
                return np.asarray(self._solve(rhs))
            solution = np.zeros(rhs.shape, dtype=np.result_type(self._dtype, rhs.dtype))
            if self._free.size:
                self._solve(rhs, self._free, solution)
            return solution
