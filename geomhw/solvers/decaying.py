"""Choice of the solver for systems whose solution decays: a factorization, or sweeps where they are faster."""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import ConvergenceError
from geomhw.options import SolverName
from geomhw.solvers.auto import FEW, iterates
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.log_scaled import LogValues, in_reach, solve_decaying, solve_scaled


class DecayingSolver:
    """Solve A u = b for u that decays away from the entries of b, over any number of orders of magnitude.

    Parameters
    ----------
    assemble : returns A, (n, n), such as M + tS; A is not kept.
    free : (n,) mask of the unknowns to solve for. The others are zero.
    solver, solves : as in `LaplaceSolver`; ``multigrid`` means sweeps here. ``auto`` factors where sweeps do not
        converge, and for the solutions after the first dozen.
    """

    def __init__(
        self, assemble: Callable[[], sp.csr_array], free: NDArray[np.bool_], solver: SolverName, solves: int
    ) -> None:
        self._assemble, self.free, self._solver = assemble, free, solver
        #: Whether sweeps are used.
        self.iterates, self._solved = iterates(solver, len(free), solves), 0

    @cached_property
    def factored(self) -> DirectSolver:
        """The factorization, made on first use, for solutions in doubles."""
        return DirectSolver(self._assemble(), self.free)

    def __call__(self, rhs: Floats, mask: NDArray[np.bool_], arrival: Callable[[], Floats]) -> LogValues:
        """Return u on the unknowns of a mask, (n,), and zero elsewhere.

        Parameters
        ----------
        rhs : b, (n,).
        arrival : returns (n,) values that grow about as -log u from zero at the sources: path lengths over √t.

        Raises
        ------
        ConvergenceError
            If no method allowed by ``solver`` converges.
        """
        where = np.flatnonzero(mask)
        self._solved += 1
        if self._solver == "auto" and self._solved > FEW:
            self.iterates = False
        if self.iterates and len(where):
            try:
                return self._by_sweeps(rhs, where, arrival())
            except ConvergenceError:
                if self._solver == "multigrid":
                    raise
                self.iterates = False
        with np.errstate(under="ignore"):
            u = self.factored(rhs)
        if in_reach(u[mask]):
            return LogValues.of(u)
        try:
            part = solve_decaying(self._submatrix(where), rhs[where], u[where], arrival()[where])
        except ConvergenceError:  # where parts of the mesh decay at very different rates
            if self._solver != "auto":
                raise
            return self._by_sweeps(rhs, where, arrival())
        return _padded(part, where, len(rhs))

    def scaled(self, matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats) -> NDArray[Any]:
        """Return exp(p) u for another, Hermitian system A u = b whose solution decays as exp(-p), as that of this one.

        Raises
        ------
        ConvergenceError
            If no method allowed by ``solver`` converges.
        """
        if self.iterates:
            from geomhw.solvers.heat_sweeps import solve_scaled_by_sweeps

            try:
                return solve_scaled_by_sweeps(matrix, rhs, potential)
            except ConvergenceError:
                if self._solver == "multigrid":
                    raise
                self.iterates = False
        return solve_scaled(matrix, rhs, potential)

    def _by_sweeps(self, rhs: Floats, where: Ints, arrival: Floats) -> LogValues:
        from geomhw.solvers.heat_sweeps import solve_by_sweeps

        return _padded(solve_by_sweeps(self._submatrix(where), rhs[where], arrival[where]), where, len(rhs))

    def _submatrix(self, where: Ints) -> sp.csr_array:
        A = self._assemble()
        return A if len(where) == A.shape[0] else A[where][:, where]


def _padded(part: LogValues, where: Ints, size: int) -> LogValues:
    """The values at some places, and zero elsewhere."""
    values = LogValues.of(np.zeros(size))
    values.log[where], values.sign[where] = part.log, part.sign
    return values
