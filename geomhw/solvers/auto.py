"""The choice of a solver for Laplace-like systems: by factorization, or by multigrid where that is faster."""

from concurrent.futures import Future
from functools import cached_property
from typing import TYPE_CHECKING, get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.background import submit
from geomhw.errors import ConvergenceError, FieldError
from geomhw.options import SolverName
from geomhw.solvers.direct import DirectSolver

if TYPE_CHECKING:
    from geomhw.solvers.multigrid import MultigridSolver

#: ``auto`` factors smaller systems, since a solution right to rounding is worth a tenth of a second,
LARGE = 20_000
#: and larger ones for more solutions than this: about where one factorization pays on scans and spheres of 41k to 164k.
FEW = 12


def iterates(asked: SolverName, size: int, solves: int) -> bool:
    """Whether to solve a system of that size, that many times, by iteration; FieldError for an unknown solver name."""
    if asked not in get_args(SolverName):
        raise FieldError(f"there is no solver '{asked}'; choose from {', '.join(get_args(SolverName))}")
    return asked == "multigrid" or (asked == "auto" and size >= LARGE and solves <= FEW)


class LaplaceSolver:
    """Solves A x = b by multigrid or by a factorization, as asked for or, with ``auto``, as is faster.

    ``auto`` factors where multigrid does not converge.

    Parameters
    ----------
    matrix, free : as in `DirectSolver`.
    asked : which solver.
    solves : about how many right-hand sides will follow.

    Raises
    ------
    ConvergenceError
        If the matrix is singular on the free unknowns, or multigrid was asked for and does not converge.
    """

    def __init__(
        self, matrix: sp.csr_array, free: NDArray[np.bool_], asked: SolverName = "auto", solves: int = 1
    ) -> None:
        self._matrix, self._free, self._asked = matrix, free, asked
        self._submitted: Future[MultigridSolver] | None = None
        self._iterate = iterates(asked, matrix.shape[0], solves)

    def _set_up(self) -> "MultigridSolver":
        from geomhw.solvers.multigrid import MultigridSolver

        return MultigridSolver(self._matrix, self._free)

    @cached_property
    def _multigrid(self) -> "MultigridSolver":
        return self._submitted.result() if self._submitted else self._set_up()

    def begin(self) -> None:
        """Set up multigrid on another core, if it will be used, while the caller goes on."""
        if self._iterate and not self._submitted:
            import geomhw.solvers.multigrid  # noqa: F401  before both threads need it

            self._submitted = submit(self._set_up)

    @cached_property
    def _direct(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._free)

    @property
    def factored(self) -> DirectSolver | None:
        """The factorization, made now if it does not exist; None where the system is solved by iteration."""
        return None if self._iterate else self._direct

    def __call__(self, rhs: Floats, guess: Floats | None = None) -> Floats:
        """Return x, (n,), zero where not free; ``guess``: an approximation of x, used by multigrid."""
        if self._iterate:
            try:
                return self._multigrid(rhs, guess)
            except ConvergenceError:
                if self._asked == "multigrid":
                    raise
                self._iterate = False
        return self._direct(rhs)
