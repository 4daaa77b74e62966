"""Systems whose solution decays by many orders of magnitude: by factorization, or by sweeps where that is faster."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ConvergenceError
from geomhw.options import SolverName
from geomhw.solvers.auto import iterates
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.log_scaled import LogValues, in_reach, solve_decaying, solve_scaled


class DecayingSolver:
    """Solves A u = b for u that decays away from where b is not zero, at any extent.

    assemble: makes A, (n, n), such as M + tS, which is not kept. free: (n,), unknowns to solve for; the others are
    zero. asked, solves: as in `LaplaceSolver`; ``multigrid`` means sweeps that follow the decay, for which ``auto`` and
    ``direct`` factor where they are slower. iterates: whether sweeps are used.
    """

    def __init__(
        self, assemble: Callable[[], sp.csr_array], free: NDArray[np.bool_], asked: SolverName, solves: int
    ) -> None:
        self._assemble, self.free, self._asked = assemble, free, asked
        self.iterates = iterates(asked, len(free), solves)

    @cached_property
    def factored(self) -> DirectSolver:
        """The factorization, made on first use. It solves for several right-hand sides in plain doubles."""
        return DirectSolver(self._assemble(), self.free)

    @cached_property
    def relaxation(self) -> float:
        from geomhw.solvers.heat_sweeps import over_relaxation

        A = self._assemble()
        rows = A @ np.ones(A.shape[0])  # those of S sum to zero, so these are masses
        return over_relaxation(rows[self.free], A.diagonal()[self.free])

    def __call__(self, rhs: Floats, there: NDArray[np.bool_], travel: Callable[[], Floats]) -> LogValues:
        """u on the unknowns of a mask, (n,), and zero elsewhere.

        travel: makes (n,) values that grow with -log u from zero at the sources, in units of the decay length.
        ConvergenceError if no method asked for reaches the far side.
        """
        where = np.flatnonzero(there)
        if self.iterates and len(where):
            try:
                return self._by_sweeps(rhs, where, travel())
            except ConvergenceError:
                if self._asked == "multigrid":
                    raise
                self.iterates = False
        with np.errstate(under="ignore"):
            u = self.factored(rhs)
        if in_reach(u[there]):
            return LogValues.of(u)
        try:
            found = solve_decaying(self._part(where), rhs[where], u[where], travel()[where])
        except ConvergenceError:  # where parts of the mesh decay at very different rates
            if self._asked != "auto":
                raise
            return self._by_sweeps(rhs, where, travel())
        return _padded(found, where, len(rhs))

    def scaled(self, matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats) -> NDArray[Any]:
        """v = exp(p) u for another system A u = b whose solution decays as that of this one, exp(-p)."""
        if self.iterates:
            from geomhw.solvers.heat_sweeps import solve_scaled_by_sweeps

            try:
                return solve_scaled_by_sweeps(matrix, rhs, potential, self.relaxation)
            except ConvergenceError:
                if self._asked == "multigrid":
                    raise
                self.iterates = False
        return solve_scaled(matrix, rhs, potential)

    def _by_sweeps(self, rhs: Floats, where: Ints, travel: Floats) -> LogValues:
        from geomhw.solvers.heat_sweeps import solve_by_sweeps

        found = solve_by_sweeps(self._part(where), rhs[where], travel[where], self.relaxation)
        return _padded(found, where, len(rhs))

    def _part(self, where: Ints) -> sp.csr_array:
        A = self._assemble()
        return A if len(where) == A.shape[0] else A[where][:, where]


def _padded(part: LogValues, where: Ints, size: int) -> LogValues:
    """The values at some places, and zero elsewhere."""
    values = LogValues.of(np.zeros(size))
    values.log[where], values.sign[where] = part.log, part.sign
    return values
