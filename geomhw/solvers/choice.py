"""Which solver: one front door for systems that are solved for few right-hand sides."""

from functools import cached_property
from typing import Literal, get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.errors import ConvergenceError, FieldError
from geomhw.mesh.arrays import Floats
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.multigrid import MultigridSolver

#: auto is multigrid on meshes of so many vertices or more, and direct on smaller ones.
SolverName = Literal["auto", "multigrid", "direct"]
LARGE = 20_000


def iterates(asked: SolverName, size: int) -> bool:
    """Whether a system of that size is to be solved without factoring it; FieldError for a name that is none."""
    if asked not in get_args(SolverName):
        raise FieldError(f"there is no solver '{asked}'; choose from {', '.join(get_args(SolverName))}")
    return asked == "multigrid" or (asked == "auto" and size >= LARGE)


class LaplaceSolver:
    """Solves A x = b as `MultigridSolver` or `DirectSolver` do, whichever is asked for or, for ``auto``, is faster.

    ``auto`` turns to the factorization where multigrid does not converge. free: as in both.
    """

    def __init__(self, matrix: sp.csr_array, free: NDArray[np.bool_], asked: SolverName = "auto") -> None:
        self._matrix, self._free, self._asked = matrix, free, asked
        self._iterate = iterates(asked, matrix.shape[0])

    @cached_property
    def _multigrid(self) -> MultigridSolver:
        return MultigridSolver(self._matrix, self._free)

    @cached_property
    def _direct(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._free)

    def __call__(self, rhs: Floats) -> Floats:
        """x, (n,), zero where not free."""
        if self._iterate:
            try:
                return self._multigrid(rhs)
            except ConvergenceError:
                if self._asked == "multigrid":
                    raise
                self._iterate = False
        return self._direct(rhs)
