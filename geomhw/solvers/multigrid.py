"""Laplace-like systems by conjugate gradients with a multigrid preconditioner: linear in size, nothing is factored.

Smoothed aggregation [Vaněk, Mandel, Brezina 1996] by pyamg. Where one right-hand side or few are asked for, this takes
a fraction of what a factorization does, from some thousand unknowns on.
"""

import math
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.errors import ConvergenceError
from geomhw.mesh.arrays import Floats, dot
from geomhw.solvers.threads import single_threaded

#: The error, measured as sqrt(eᵀAe), ends at this share of the solution, as far as the preconditioner tells: for a
#: function on a surface that is its largest value, up to a factor of the size of log n.
TOLERANCE = 3e-9
#: Or where rounding of A x keeps the residual up: at so many units in the last place of |A| |x|.
ROUNDING_UNITS = 16.0
MAX_ITERATIONS = 300
#: Systems of so many unknowns are factored, and larger ones made coarser.
COARSEST = 200
#: Damping of the step that smooths what is interpolated, over Gershgorin's bound of the radius: where weights are equal
#: and six, that is 4/3 over the radius itself, which is best [Vaněk, Mandel, Brezina 1996, eq. 6].
OMEGA = 16 / 9
MAX_RESTARTS = 4


class MultigridSolver:
    """Solves A x = b for a symmetric, positive definite A whose smoothest vectors are close to constant.

    free: the unknowns that are solved for, (n,), by default all; the others are held at zero, which grounds a
    semidefinite matrix.
    """

    def __init__(self, matrix: sp.csr_array, free: NDArray[np.bool_] | None = None) -> None:
        self._size = matrix.shape[0]
        self._free = np.arange(self._size) if free is None else np.flatnonzero(free)
        self._matrix = matrix.copy() if free is None else matrix[self._free][:, self._free]
        self._matrix.sort_indices()  # one order of work, whatever the history of the matrix
        if self._free.size:
            self._levels: Any = _smoothed_aggregation(sp.csr_matrix(self._matrix)).aspreconditioner(cycle="W")

    def __call__(self, rhs: Floats) -> Floats:
        """x, (n,), zero where not free; ConvergenceError if the iteration stops short."""
        x = np.zeros(self._size)
        b = rhs[self._free]
        if not b.any():
            return x
        inner = np.zeros_like(b)
        with single_threaded():
            residual, enough = b, 0.0
            for _ in range(MAX_RESTARTS):
                gained, energy = self._conjugate_gradients(residual, enough)
                inner += gained
                enough = max(enough, TOLERANCE**2 * energy)
                # What the iteration carries along is not quite what is left.
                residual = b - self._matrix @ inner
                left = abs(dot(residual, self._levels @ residual))
                if (enough > 0 and left <= 4 * enough) or self._is_rounding(residual, inner):
                    x[self._free] = inner
                    return x
        raise ConvergenceError("multigrid does not converge on this mesh; compute with --solver direct")

    def _is_rounding(self, residual: Floats, x: Floats) -> bool:
        return _norm(residual) <= ROUNDING_UNITS * float(np.finfo(float).eps) * _norm(abs(self._matrix) @ np.abs(x))

    def _conjugate_gradients(self, residual: Floats, enough: float) -> tuple[Floats, float]:
        """x and xᵀAx, preconditioned, from zero [Saad 2003, alg. 9.1], until rᵀBr, which estimates eᵀAe, is small."""
        x, direction, former, energy = np.zeros_like(residual), np.zeros_like(residual), 1.0, 0.0
        for _ in range(MAX_ITERATIONS):
            smoothed = self._levels @ residual
            weight = dot(residual, smoothed)
            if weight <= max(enough, TOLERANCE**2 * energy):
                break
            direction = smoothed + (weight / former) * direction
            image = self._matrix @ direction
            bend = dot(direction, image)
            if not bend > 0:  # not definite, or down to rounding
                break
            step, former = weight / bend, weight
            x += step * direction
            residual = residual - step * image
            energy += step * weight
        return x, energy


def _smoothed_aggregation(A: sp.csr_matrix) -> Any:
    """Ever coarser systems: unknowns joined with all of their neighbors, and what is constant on them smoothed.

    No entry is taken as weak: cotan weights vary with the shapes of faces, not with a direction of decay. Constants
    are not improved, and D is that of Gershgorin, which draws no random vectors.
    """
    from pyamg import MultilevelSolver
    from pyamg.aggregation import standard_aggregation
    from pyamg.relaxation.smoothing import change_smoothers

    levels = [MultilevelSolver.Level()]
    levels[0].A = A
    while A.shape[0] > COARSEST:
        joined = standard_aggregation(A)[0].astype(float)
        if joined.shape[1] >= A.shape[0]:
            break
        weights = (OMEGA / np.maximum(np.asarray(abs(A).sum(axis=1)).ravel(), np.finfo(float).tiny))[:, None]
        levels[-1].P = sp.csr_matrix(joined - (A @ joined).multiply(weights))
        levels[-1].R = levels[-1].P.T.tocsr()
        A = sp.csr_matrix(levels[-1].R @ A @ levels[-1].P)
        A.sort_indices()
        levels.append(MultilevelSolver.Level())
        levels[-1].A = A
    solver = MultilevelSolver(levels, coarse_solver="splu")
    change_smoothers(solver, ("gauss_seidel", {"sweep": "forward"}), ("gauss_seidel", {"sweep": "backward"}))
    return solver


def _norm(vector: Floats) -> float:
    return math.sqrt(dot(vector, vector))
