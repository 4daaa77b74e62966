"""Laplace-like systems by conjugate gradients with a multigrid preconditioner: linear in size, nothing is factored.

Smoothed aggregation [Vaněk, Mandel, Brezina 1996]. For one right-hand side or a few this takes a fraction of the time
of a factorization, from some thousand unknowns on.
"""

import math

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, dot
from geomhw.compiled import compiled
from geomhw.errors import ConvergenceError, Remedy
from geomhw.solvers.direct import SparseLU
from geomhw.solvers.gauss_seidel import diagonal_first, sweep
from geomhw.solvers.threads import single_threaded

#: The error, measured as sqrt(eᵀAe), ends at this share of the solution, as far as the preconditioner tells: for a
#: function on a surface that is its largest value, up to a factor of the size of log n.
TOLERANCE = 1e-8
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
        self._matrix = sp.csr_array(matrix.copy() if free is None else matrix[self._free][:, self._free])
        self._matrix.sort_indices()  # one order of work, whatever the history of the matrix
        if self._free.size:
            self._cycle = _Cycle(self._matrix)

    def __call__(self, rhs: Floats, guess: Floats | None = None) -> Floats:
        """x, (n,), zero where not free; ConvergenceError if the iteration stops short.

        guess: (n,), about x, and zero where that is held, to go on from.
        """
        x = np.zeros(self._size)
        b = rhs[self._free]
        if not b.any():
            return x
        with single_threaded():
            inner = np.zeros_like(b) if guess is None else guess[self._free]
            image = self._matrix @ inner
            if (energy := dot(inner, image)) > 0:
                share = dot(b, inner) / energy  # nearest to x of all multiples
                inner, image, energy = share * inner, share * image, share**2 * energy
            residual, size = b - image, math.sqrt(max(energy, 0.0))
            for _ in range(MAX_RESTARTS):
                gained, carried, size, settled = self._conjugate_gradients(residual, size)
                inner += gained
                # What the iteration carries along is not quite what is left.
                residual = b - self._matrix @ inner
                settled &= _norm(residual - carried) <= _norm(carried)
                if settled or self._is_rounding(residual, inner):
                    x[self._free] = inner
                    return x
        remedy: Remedy = "solver='direct'"
        raise ConvergenceError(f"multigrid does not converge on this mesh; compute with {remedy}", remedy)

    def _is_rounding(self, residual: Floats, x: Floats) -> bool:
        return _norm(residual) <= ROUNDING_UNITS * float(np.finfo(float).eps) * _norm(abs(self._matrix) @ np.abs(x))

    def _conjugate_gradients(self, residual: Floats, known: float) -> tuple[Floats, Floats, float, bool]:
        """x with A x = r, preconditioned, from zero [Saad 2003, alg. 9.1], until rᵀBr, which estimates eᵀAe, is small
        beside the energy of a guess, known as sqrt(gᵀAg), and x together. What is left of r, the root of that energy,
        no less than the least that it can be, and whether the error is small."""
        x, direction, former, energy, settled = np.zeros_like(residual), np.zeros_like(residual), 1.0, 0.0, False
        for _ in range(MAX_ITERATIONS):
            smoothed = self._cycle(residual)
            weight = dot(residual, smoothed)
            size = abs(known - math.sqrt(energy))
            settled = 0 < weight <= (TOLERANCE * size) ** 2
            if settled:
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
        return x, residual, size, settled


class _Cycle:
    """One W-cycle over ever coarser systems, symmetric: x, about A⁻¹b, from b.

    Coarser unknowns are those of all neighbors joined, with what is constant on them smoothed. No entry is taken as
    weak: cotan weights vary with the shapes of faces, not with a direction of decay. The smoothing step is that of
    Gershgorin's bound, which draws no random vectors.
    """

    def __init__(self, A: sp.csr_array) -> None:
        self._levels: list[tuple[sp.csr_array, sp.csc_array, sp.csr_array]] = []
        while A.shape[0] > COARSEST:
            R = _restriction(A)
            if not R.nnz or R.shape[0] >= A.shape[0]:  # unknowns without neighbors are not joined
                break
            coarse = sp.csr_array(R @ A @ R.T)
            coarse.sort_indices()
            diagonal_first(A)
            self._levels.append((A, R.T, R))  # one array for both
            A = coarse
        self._coarsest = SparseLU(A)

    def __call__(self, b: Floats, level: int = 0) -> Floats:
        """x, of the size of b."""
        if level == len(self._levels):
            return self._coarsest(b)
        A, P, R = self._levels[level]
        x = np.zeros_like(b)
        sweep(A, x, b, 0, len(b))
        rest = R @ (b - A @ x)
        coarse = self(rest, level + 1)
        if level + 1 < len(self._levels):
            coarse += self(rest - self._levels[level + 1][0] @ coarse, level + 1)
        x += P @ coarse
        sweep(A, x, b, len(b) - 1, -1, -1)
        return x


def _restriction(A: sp.csr_array) -> sp.csr_array:
    """From residuals to those of joined unknowns, (coarse, n): the transpose of (1 - ω A) J, ω by Gershgorin."""
    joined = _aggregates(A)
    sizes = sp.csr_array((np.abs(A.data), A.indices, A.indptr), shape=A.shape) @ np.ones(A.shape[0])
    omega = OMEGA / np.maximum(sizes, np.finfo(float).tiny)
    return sp.csr_array(joined - (A @ joined).multiply(omega[:, None])).T.tocsr()


def _aggregates(A: sp.csr_array) -> sp.csr_array:
    """0/1 matrix, (n, coarse), from aggregates of neighboring unknowns to the unknowns; isolated ones have none."""
    label = np.zeros(A.shape[0], dtype=A.indices.dtype)
    count = _aggregate(A.indptr, A.indices, label)
    of = np.flatnonzero(label >= 0)
    return sp.csr_array((np.ones(len(of)), (of, label[of])), shape=(len(label), count))


@compiled
def _aggregate(indptr: Ints, indices: Ints, label: Ints) -> int:
    """Label unknowns, (n,), zero before, by aggregate from 0, -1 where isolated [Vaněk, Mandel, Brezina 1996, alg. 2].

    An unknown whose neighbors are all free forms an aggregate with them; the rest joins one next to it, or forms more.
    """
    n, count, isolated = len(label), 0, len(label) + 1
    for i in range(n):
        if label[i] != 0:
            continue
        alone, free = True, True
        for p in range(indptr[i], indptr[i + 1]):
            if indices[p] != i:
                alone = False
                free = free and label[indices[p]] == 0
        if alone:
            label[i] = isolated
        elif free:
            count += 1
            label[i] = count
            for p in range(indptr[i], indptr[i + 1]):
                label[indices[p]] = count
    for i in range(n):
        if label[i] == 0:
            for p in range(indptr[i], indptr[i + 1]):
                if 0 < label[indices[p]] <= n:
                    label[i] = -label[indices[p]]  # negative: no reason for others to join
                    break
    for i in range(n):
        if label[i] == 0:
            count += 1
            label[i] = count
            for p in range(indptr[i], indptr[i + 1]):
                if label[indices[p]] == 0:
                    label[indices[p]] = count
    for i in range(n):
        label[i] = -1 if label[i] == isolated else abs(label[i]) - 1
    return count


def _norm(vector: Floats) -> float:
    return math.sqrt(dot(vector, vector))
