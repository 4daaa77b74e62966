"""Choice of the solver for Laplace-like systems: a factorization, or multigrid where that is faster."""

from concurrent.futures import Future
from functools import cached_property
from typing import TYPE_CHECKING, get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.background import submit
from geomhw.errors import ArgumentError, ConvergenceError
from geomhw.options import SolverName
from geomhw.solvers.direct import DirectSolver

if TYPE_CHECKING:
    from geomhw.solvers.multigrid import MultigridSolver

#: ``auto`` factors systems with fewer unknowns: a solution exact up to rounding takes a tenth of a second there.
LARGE = 20_000
#: It factors larger ones for more solutions than this: on scans and spheres of 41k to 164k vertices, one factorization
#: then takes as long as iterating.
FEW = 12


def iterates(solver: SolverName, size: int, solves: int) -> bool:
    """Return whether to solve a system of that size, that many times, by iteration.

    Raises ArgumentError for an unknown solver name.
    """
    if solver not in get_args(SolverName):
        raise ArgumentError(f"there is no solver '{solver}'; choose from {', '.join(get_args(SolverName))}")
    return solver == "multigrid" or (solver == "auto" and size >= LARGE and solves <= FEW)


class LaplaceSolver:
    """Solve A x = b for a symmetric, positive definite A whose smoothest vectors are close to constant.

    Parameters
    ----------
    matrix, free : as in `DirectSolver`.
    solver : ``direct`` factors, ``multigrid`` iterates. ``auto`` takes the faster one, and factors where multigrid does
        not converge, and once it has iterated for as long as a factorization takes.
    solves : about how many right-hand sides will follow.

    Raises
    ------
    ArgumentError
        For an unknown solver name.
    ConvergenceError
        If the matrix is singular on the free unknowns, or ``multigrid`` does not converge.

    Examples
    --------
    >>> chain = sp.csr_array(sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(3, 3)))
    >>> LaplaceSolver(chain, np.array([False, True, True]))(np.array([0.0, 1.0, 1.0])).round(12)
    array([0., 1., 1.])
    """

    def __init__(
        self, matrix: sp.csr_array, free: NDArray[np.bool_], solver: SolverName = "auto", solves: int = 1
    ) -> None:
        self._matrix, self._free, self._solver = matrix, free, solver
        self._submitted: Future[MultigridSolver] | None = None
        self._iterate, self._solved = iterates(solver, matrix.shape[0], solves), 0

    def begin(self) -> None:
        """Set up multigrid in a background thread, if it will be used."""
        if self._iterate and not self._submitted:
            import geomhw.solvers.multigrid  # noqa: F401  before both threads need it

            self._submitted = submit(self._set_up)

    def _set_up(self) -> "MultigridSolver":
        from geomhw.solvers.multigrid import MultigridSolver

        return MultigridSolver(self._matrix, self._free)

    @cached_property
    def _multigrid(self) -> "MultigridSolver":
        return self._submitted.result() if self._submitted else self._set_up()

    @cached_property
    def _direct(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._free)

    @property
    def factored(self) -> DirectSolver | None:
        """The factorization, made on first use; None where the system is solved by iteration."""
        return None if self._iterate else self._direct

    def __call__(self, rhs: Floats, guess: Floats | None = None) -> Floats:
        """Return x, (n,), zero where not free; ``guess`` is an approximation of x, used by multigrid."""
        self._solved += 1
        if self._solver == "auto" and self._solved > FEW:
            self._iterate = False
        if self._iterate:
            try:
                return self._multigrid(rhs, guess)
            except ConvergenceError:
                if self._solver == "multigrid":
                    raise
                self._iterate = False
        return self._direct(rhs)
