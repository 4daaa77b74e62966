"""Which solver: one front door for systems that are solved for few right-hand sides."""

from concurrent.futures import Future
from functools import cached_property
from typing import get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.background import submit
from geomhw.errors import ConvergenceError, FieldError
from geomhw.options import SolverName
from geomhw.solvers.cost_model import ONE, Kind, Work, cheapest, seconds
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.multigrid import MultigridSolver

#: But with fewer unknowns it always factors: right to rounding is worth a tenth of a second.
LARGE = 20_000


def iterates(asked: SolverName, size: int, work: Work, by: Kind) -> bool:
    """Whether a system of that size is to be solved without factoring it, ``by`` multigrid or sweeps.

    FieldError for a name that is none.
    """
    if asked not in get_args(SolverName):
        raise FieldError(f"there is no solver '{asked}'; choose from {', '.join(get_args(SolverName))}")
    if asked != "auto" or size < LARGE:
        return asked == "multigrid"
    return seconds(by, size, work) < seconds(cheapest(size, work), size, work)


class LaplaceSolver:
    """Solves A x = b as `MultigridSolver` or `DirectSolver` do, whichever is asked for or, for ``auto``, is faster.

    ``auto`` turns to the factorization where multigrid does not converge. free: as in both. work: what is to come.
    """

    def __init__(
        self, matrix: sp.csr_array, free: NDArray[np.bool_], asked: SolverName = "auto", work: Work = ONE
    ) -> None:
        self._matrix, self._free, self._asked, self._work = matrix, free, asked, work
        self._begun: Future[MultigridSolver] | None = None
        self._iterate = iterates(asked, matrix.shape[0], work, "multigrid")

    @cached_property
    def _multigrid(self) -> MultigridSolver:
        return self._begun.result() if self._begun else MultigridSolver(self._matrix, self._free)

    def begin(self) -> None:
        """Set up multigrid, where that is to come, on another core, while the caller goes on with something else."""
        if self._iterate and not self._begun:
            import pyamg.aggregation  # noqa: F401  for both threads

            self._begun = submit(lambda: MultigridSolver(self._matrix, self._free))

    @cached_property
    def _direct(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._free, self._work)

    @property
    def factored(self) -> DirectSolver | None:
        """The factorization, made now if need be; None where the system is solved without one."""
        return None if self._iterate else self._direct

    def __call__(self, rhs: Floats, guess: Floats | None = None) -> Floats:
        """x, (n,), zero where not free. guess: as `MultigridSolver` takes it."""
        if self._iterate:
            try:
                return self._multigrid(rhs, guess)
            except ConvergenceError:
                if self._asked == "multigrid":
                    raise
                self._iterate = False
        return self._direct(rhs)
