"""Conjugate gradients with an algebraic multigrid preconditioner (smoothed aggregation), for Laplace-like systems.

Aggregates of neighboring unknowns become the unknowns of a coarser system, and so on down to a system that is factored
[Vaněk, Mandel, Brezina 1996]. With J the 0/1 matrix from aggregates to unknowns and D the diagonal of row sums
Σ_j |a_ij|, interpolation is P = (I - ω D⁻¹ A) J and the coarser system Pᵀ A P. A W-cycle over all levels, smoothed by
Gauss-Seidel sweeps, approximates A⁻¹ in conjugate gradients [Saad 2003, alg. 9.1]. Work is linear in the number of
unknowns.

Own code, because pyamg has no wheel for Linux on ARM, and takes 2.8 times as long (armadillo, 43,243 vertices: 443 ms
against 156 ms on one core).

Vaněk, Mandel, Brezina: Algebraic Multigrid by Smoothed Aggregation, Computing 56, 1996.
Saad: Iterative Methods for Sparse Linear Systems, SIAM 2003.
"""

import math

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, dot
from geomhw.compiled import compiled
from geomhw.errors import ConvergenceError
from geomhw.solvers.direct import SparseLU, single_threaded
from geomhw.solvers.expm import absolute_row_sums

#: Bound on the error in the energy norm √(eᵀAe), as a share of that of the solution, as far as the preconditioner
#: measures it. For a function on a surface the energy norm is its largest value, up to a factor of about log n.
TOLERANCE = 1e-8
#: A residual of at most this many units in the last place of |A| |x| is rounding.
ROUNDING_UNITS = 16.0
MAX_ITERATIONS = 300
MAX_RESTARTS = 4
#: Systems of at most this many unknowns are factored.
COARSEST = 200
#: ω, which is 4/3 over the spectral radius of D⁻¹A [Vaněk, Mandel, Brezina 1996, eq. 6] for six equal weights a row.
OMEGA = 16 / 9


#: N of A = N + diag(d) in compressed rows, and d.
_Split = tuple[Ints, Ints, Floats, Floats]


class MultigridSolver:
    """Solve A x = b for a symmetric, positive definite A whose smoothest vectors are close to constant.

    Parameters
    ----------
    matrix : (n, n) sparse array.
    free : (n,) mask of the unknowns to solve for, by default all. The others are held at zero, which grounds a
        semidefinite matrix.

    Examples
    --------
    >>> chain = sp.csr_array(sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(3, 3)))
    >>> MultigridSolver(chain)(np.array([1.0, 0.0, 1.0])).round(12)
    array([1., 1., 1.])
    """

    def __init__(self, matrix: sp.csr_array, free: NDArray[np.bool_] | None = None) -> None:
        self._size = matrix.shape[0]
        self._free = np.arange(self._size) if free is None else np.flatnonzero(free)
        self._matrix = sp.csr_array(matrix.copy() if free is None else matrix[self._free][:, self._free])
        self._matrix.sort_indices()  # one order of summation for one matrix
        if self._free.size:
            self._cycle = _Cycle(self._matrix)

    def __call__(self, rhs: Floats, guess: Floats | None = None) -> Floats:
        """Return x, (n,), zero where not free.

        Parameters
        ----------
        rhs : b, (n,).
        guess : (n,), an approximation of x.

        Raises
        ------
        ConvergenceError
            If the iteration does not converge.
        """
        x = np.zeros(self._size)
        b = rhs[self._free]
        if b.any():
            with single_threaded():
                x[self._free] = self._solve(b, np.zeros_like(b) if guess is None else guess[self._free])
        return x

    def _solve(self, b: Floats, x: Floats) -> Floats:
        """The solution by conjugate gradients from a guess x, restarted until the true residual is small."""
        A, image = self._matrix, self._matrix @ x
        if (energy := dot(x, image)) > 0:
            scale = dot(b, x) / energy  # the multiple of the guess nearest to the solution
            x, image, energy = scale * x, scale * image, scale**2 * energy
        residual, norm = b - image, math.sqrt(max(energy, 0.0))
        for _ in range(MAX_RESTARTS):
            correction, recurred, norm, converged = self._conjugate_gradients(residual, norm)
            x = x + correction
            residual = b - A @ x  # the recurred one has drifted by rounding
            if (converged and _norm(residual - recurred) <= _norm(recurred)) or self._is_rounding(residual, x):
                return x
        raise ConvergenceError(
            "multigrid does not converge on this mesh; compute with solver='direct'", "solver='direct'"
        )

    def _is_rounding(self, residual: Floats, x: Floats) -> bool:
        return _norm(residual) <= ROUNDING_UNITS * float(np.finfo(float).eps) * _norm(abs(self._matrix) @ np.abs(x))

    def _conjugate_gradients(self, residual: Floats, guess_norm: float) -> tuple[Floats, Floats, float, bool]:
        """Correct a guess of that energy norm by A⁻¹r [Saad 2003, alg. 9.1].

        Returns the correction, the residual left, a lower bound on the energy norm of the solution, and whether rᵀBr,
        which estimates eᵀAe for the preconditioner B, is small beside it.
        """
        x, direction = np.zeros_like(residual), np.zeros_like(residual)
        rz_before, energy, converged = 1.0, 0.0, False
        for _ in range(MAX_ITERATIONS):
            z = self._cycle(residual)
            rz = dot(residual, z)
            norm = abs(guess_norm - math.sqrt(energy))
            converged = 0 < rz <= (TOLERANCE * norm) ** 2
            if converged:
                break
            direction = z + (rz / rz_before) * direction
            image = self._matrix @ direction
            curvature = dot(direction, image)
            if not curvature > 0:  # not definite, or down to rounding
                break
            step, rz_before = rz / curvature, rz
            x += step * direction
            residual = residual - step * image
            energy += step * rz
        return x, residual, norm, converged


class _Cycle:
    """One symmetric W-cycle: an approximation of A⁻¹b.

    All neighbors join an aggregate: cotan weights vary with the shapes of faces, not with a direction of strong
    coupling.
    """

    def __init__(self, A: sp.csr_array) -> None:
        self._levels: list[tuple[sp.csr_array, _Split, sp.csc_array, sp.csr_array]] = []
        while A.shape[0] > COARSEST:
            R = _restriction(A)
            if not R.nnz or R.shape[0] >= A.shape[0]:  # unknowns without neighbors do not aggregate
                break
            diagonal = A.diagonal()
            rows = np.repeat(np.arange(len(diagonal), dtype=A.indices.dtype), np.diff(A.indptr))
            N = np.where(A.indices == rows, 0.0, A.data)
            self._levels.append((A, (A.indptr, A.indices, N, diagonal), R.T, R))
            A = sp.csr_array(R @ A @ R.T)
            A.sort_indices()
        self._coarsest = SparseLU(A)

    def __call__(self, b: Floats, level: int = 0) -> Floats:
        """Return x, of the size of b, on a level."""
        if level == len(self._levels):
            return self._coarsest(b)
        _, split, P, R = self._levels[level]
        x, left = np.empty_like(b), np.empty_like(b)
        _sweep_from_zero(*split, x, b, left)
        residual = R @ left
        coarse = self(residual, level + 1)
        if level + 1 < len(self._levels):
            coarse += self(residual - self._levels[level + 1][0] @ coarse, level + 1)
        x += P @ coarse
        _sweep_back(*split, x, b)
        return x


@compiled
def _sweep_from_zero(
    indptr: Ints, indices: Ints, data: Floats, diagonal: Floats, x: Floats, b: Floats, residual: Floats
) -> None:
    """Sweep x_i ← (b - N x)_i / d_i over ascending rows, from x = 0; also compute b - A x.

    A = N + diag(d) is symmetric with sorted rows. Entries before the diagonal suffice: row i of the residual is -Σ_j>i
    a_ij x_j.
    """
    for i in range(len(b)):
        start = end = np.uintp(indptr[i])
        stop, total = np.uintp(indptr[i + 1]), b[i]
        while end < stop and indices[end] < i:
            total -= data[end] * x[np.uintp(indices[end])]
            end += np.uintp(1)
        x[i] = total / diagonal[i]
        residual[i] = 0.0
        for k in range(start, end):
            residual[np.uintp(indices[k])] -= data[k] * x[i]


@compiled
def _sweep_back(indptr: Ints, indices: Ints, data: Floats, diagonal: Floats, x: Floats, b: Floats) -> None:
    """Sweep x_i ← (b - N x)_i / d_i for A = N + diag(d) over descending rows, in place."""
    for i in range(len(b) - 1, -1, -1):
        total = b[i]
        # With unsigned indices numba does not test whether they count from the end: half of the time.
        for k in range(np.uintp(indptr[i]), np.uintp(indptr[i + 1])):
            total -= data[k] * x[np.uintp(indices[k])]
        x[i] = total / diagonal[i]


def _restriction(A: sp.csr_array) -> sp.csr_array:
    """Pᵀ, (coarse, n), of P = (I - ω D⁻¹ A) J."""
    J = _aggregates(A)
    smoothed = A @ J
    scale = OMEGA / np.maximum(absolute_row_sums(A), np.finfo(float).tiny)
    smoothed.data *= np.repeat(scale, np.diff(smoothed.indptr))
    return sp.csr_array(J - smoothed).T.tocsr()


def _aggregates(A: sp.csr_array) -> sp.csr_array:
    """J, (n, coarse), with a 1 where an unknown belongs to an aggregate; isolated unknowns belong to none."""
    labels = np.zeros(A.shape[0], dtype=A.indices.dtype)
    count = _label_aggregates(A.indptr, A.indices, labels)
    rows = np.flatnonzero(labels >= 0)
    return sp.csr_array((np.ones(len(rows)), (rows, labels[rows])), shape=(len(labels), count))


@compiled
def _label_aggregates(indptr: Ints, indices: Ints, label: Ints) -> int:
    """Label unknowns, (n,), zero before, by aggregate from 0, -1 where isolated; the number of aggregates.

    An unknown whose neighbors are all free forms an aggregate with them. Others join a neighbor's, or form more
    [Vaněk, Mandel, Brezina 1996, alg. 2].
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
                    label[i] = -label[indices[p]]  # negative: the next ones do not join through this one
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
