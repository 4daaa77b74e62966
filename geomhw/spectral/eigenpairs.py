"""The smallest eigenpairs of A φ = λ M φ, in a basis that does not depend on the run or the machine.

The count of eigenvalues below a bound, from the signs of pivots, says whether the iteration has found all of them.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, ConvergenceError
from geomhw.solvers.direct import SparseLU, single_threaded
from geomhw.spectral.block_lanczos import BLOCK, block_lanczos

#: Start vectors, at most, in blocks.
MOST_STARTS = 8
#: Pairs that are computed beyond those asked for, so that the last eigenspace is whole.
FURTHER = 8
#: Eigenvalues that differ by less than this, relative to the larger, have one eigenspace.
MULTIPLE = 1e-7
#: Rows whose weight in an eigenspace is the largest up to this, relative, tie.
TIE = 1e-6
#: Systems of at most this many unknowns, or six times the number of pairs, are solved as dense ones.
DENSE = 300


@dataclass(frozen=True)
class Eigenpairs:
    """Eigenvalues and eigenvectors of A φ = λ M φ.

    Attributes
    ----------
    values : (k,) array
        λ, ascending.
    vectors : (n, k) array
        φ in columns, orthonormal: φᵀMφ = 1.
    residuals : (k,) array
        ‖Aφ - λMφ‖ in the norm of the inverse lumped M, over λ + 1/ΣM. Dimensionless.
    """

    values: Floats
    vectors: NDArray[Any]
    residuals: Floats


def smallest_eigenpairs(A: sp.csr_array, M: sp.csr_array, k: int) -> Eigenpairs:
    """Compute the k smallest eigenpairs of A φ = λ M φ.

    Parameters
    ----------
    A : (n, n) sparse array, symmetric or Hermitian, positive semidefinite.
    M : (n, n) sparse array, symmetric positive definite.
    k : number of pairs, 1 to n.

    Returns
    -------
    Eigenpairs
        Eigenvectors are chosen as `canonical_basis` says; for the same matrices they agree between runs and machines.

    Raises
    ------
    ArgumentError
        If k is not between 1 and n.
    ConvergenceError
        If the matrix cannot be factored, or the iteration does not converge.

    Examples
    --------
    >>> chain = sp.csr_array(sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(3, 3)))
    >>> smallest_eigenpairs(chain, sp.csr_array(sp.eye_array(3)), 2).values.round(6)
    array([0.585786, 2.      ])
    """
    n = A.shape[0]
    if not 1 <= k <= n:
        raise ArgumentError(f"there are {n} eigenpairs; {k} cannot be computed")
    wanted = min(k + FURTHER, n)
    total = float(M.sum().real)
    M = sp.csr_array(M / total)
    values, vectors = _dense(A, M) if n <= max(DENSE, 6 * wanted) else _lanczos(A, M, wanted)
    order = np.argsort(values, kind="stable")[:wanted]
    values, vectors = np.maximum(values[order], 0.0), vectors[:, order]
    for begin, end in _multiplets(values):
        vectors[:, begin:end] = canonical_basis(vectors[:, begin:end], M)
    values, vectors = values[:k], vectors[:, :k]
    rest = A @ vectors - (M @ vectors) * values
    lumped = np.asarray(M.sum(axis=1)).ravel().real
    residuals = np.sqrt((np.abs(rest) ** 2 / lumped[:, None]).sum(axis=0)) / (values + 1)
    return Eigenpairs(values / total, vectors / np.sqrt(total), np.asarray(residuals))


def canonical_basis(vectors: NDArray[Any], M: sp.csr_array) -> NDArray[Any]:
    """Return the M-orthonormal basis of a space that is fixed by the space alone.

    The first vector is the one that is largest at a row, over all rows and unit vectors, and positive there; the next
    ones follow in the same way in the space orthogonal to it. Of rows that tie, the first counts.

    Parameters
    ----------
    vectors : (n, d) array, an M-orthonormal basis of the space.
    M : (n, n) sparse array.

    Returns
    -------
    (n, d) array
    """
    space = np.array(vectors)
    found = np.empty_like(space)
    for j in range(space.shape[1]):
        weights = (np.abs(space) ** 2).sum(axis=1)
        row = int(np.argmax(weights >= weights.max() * (1 - TIE)))
        direction = np.conj(space[row]) / np.sqrt(weights[row])
        found[:, j] = space @ direction
        # The rest of the space: a basis orthogonal to the direction.
        rest = np.linalg.qr(np.column_stack([direction, np.eye(len(direction))]))[0][:, 1 : len(direction)]
        space = space @ rest
    norms = np.sqrt(np.einsum("ij,ij->j", np.conj(found), M @ found).real)
    return np.asarray(found / norms)


def _multiplets(values: Floats) -> list[tuple[int, int]]:
    """Begin and end of the groups of nearly equal eigenvalues, for a mass of 1."""
    apart = np.diff(values) > MULTIPLE * (values[1:] + 1)
    bounds = [0, *(np.flatnonzero(apart) + 1).tolist(), len(values)]
    return list(pairwise(bounds))


def _dense(A: sp.csr_array, M: sp.csr_array) -> tuple[Floats, NDArray[Any]]:
    from scipy.linalg import eigh

    with single_threaded():
        values, vectors = eigh(A.toarray(), M.toarray())
    return np.asarray(values), np.asarray(vectors)


def _lanczos(A: sp.csr_array, M: sp.csr_array, k: int) -> tuple[Floats, NDArray[Any]]:
    """Block Lanczos, from as many further starts as eigenvalues below the largest are missing."""
    with single_threaded():
        for blocks in range(1, MOST_STARTS + 1):
            values, vectors = block_lanczos(A, M, k, start_vectors(A.shape[0], blocks * BLOCK))
            bound = gap_below(values)
            if below(A, M, bound) == np.count_nonzero(values < bound):
                return values, vectors
    raise ConvergenceError(f"{k} eigenpairs cannot be found, since too many eigenvalues are equal; ask for more")


def gap_below(values: Floats) -> float:
    """The middle of the widest gap, relative to the values, in the upper half of ascending eigenvalues.

    Where these are all equal, that of all values; where all are, a value below them.
    """
    half, gaps = len(values) // 2, np.diff(values) / (1 + values[1:])
    last = half + int(np.argmax(gaps[half:]))
    if gaps[last] <= MULTIPLE:
        last = int(np.argmax(gaps))
    if gaps[last] <= MULTIPLE:
        return float(values[0] - MULTIPLE * (1 + values[0]))
    return float(values[last] + values[last + 1]) / 2


def below(A: sp.csr_array, M: sp.csr_array, bound: float) -> int:
    """Count the eigenvalues of A φ = λ M φ below a bound: the negative pivots of A - bound M [Sylvester 1852]."""
    return SparseLU(sp.csr_array(A - bound * M)).negative_pivots


def start_vectors(n: int, count: int) -> Floats:
    """Return vectors, (n, count), with a part along every eigenvector, the same at each call."""
    return np.cos(np.outer(np.arange(n) ** 2 / 1.9, 1 + np.arange(count) / count) + np.arange(count))
