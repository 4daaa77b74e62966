"""The block Lanczos method for the largest eigenvalues of (A + M)⁻¹ M, with full orthogonalization.

Blocks find multiple eigenvalues, and use matrix products and triangular solves for several columns. For the hundred
smallest pairs of 41k vertices this takes half of the time of ARPACK.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError
from geomhw.solvers.direct import DirectSolver

#: Columns of a block.
BLOCK = 8
#: Residual of an eigenpair of the inverse, relative to its eigenvalue.
TOLERANCE = 1e-11
#: Blocks between two looks at the convergence.
LOOK = 4
#: Vectors of the basis, at most, over the pairs that are wanted.
LARGEST = 12
#: Factor by which short directions of a block may grow without a further orthogonalization.
GROWTH = 100.0


def block_lanczos(A: sp.csr_array, M: sp.csr_array, k: int, start: NDArray[Any]) -> tuple[Floats, NDArray[Any]]:
    """Return the k smallest eigenvalues of A φ = λ M φ, ascending, and M-orthonormal eigenvectors, (n, k).

    Parameters
    ----------
    A : (n, n) sparse array, symmetric or Hermitian, positive semidefinite.
    M : (n, n) sparse array, symmetric positive definite, with entries that sum to about 1.
    k : number of pairs, at most n / 4.
    start : (n, b) array, the first block.

    Raises
    ------
    ConvergenceError
        If A + M cannot be factored, or the iteration does not converge.

    References
    ----------
    Golub, Underwood: The Block Lanczos Method for Computing Eigenvalues. Mathematical Software III, 1977.
    Grimes, Lewis, Simon: A Shifted Block Lanczos Algorithm for Sparse Symmetric Eigenproblems, 1994.
    """
    inverse = DirectSolver(sp.csr_array(A + M))
    limit = min(LARGEST * k + 16 * start.shape[1], A.shape[0] - start.shape[1])
    basis = np.empty((A.shape[0], limit + start.shape[1]), dtype=A.dtype, order="F")
    projected = np.zeros((limit + start.shape[1],) * 2, dtype=A.dtype)
    (block, _), before, size, look = orthonormal(start.astype(A.dtype), M), 0, 0, 0
    while size < limit:
        last, before, size = before, size, size + block.shape[1]
        basis[:, before:size] = block
        image = inverse(M @ block)
        projected[:size, before:size] = _orthogonalize(image, basis[:, :size], M, last)
        block, growth = orthonormal(image, M)
        if growth > GROWTH:  # of the parts of the basis, too
            _orthogonalize(block, basis[:, :size], M, last)
            block, _ = orthonormal(block, M)
        rest = np.conj(block.T) @ (M @ image)
        look += 1
        if size >= k + 2 * BLOCK and look % LOOK == 0:
            upper = np.triu(projected[:size, :size])
            values, vectors = np.linalg.eigh(upper + np.conj(np.triu(upper, 1).T))
            values, vectors = values[::-1][:k], vectors[:, ::-1][:, :k]
            if (np.linalg.norm(rest @ vectors[before:size], axis=0) <= TOLERANCE * values).all():
                return 1 / values - 1, basis[:, :size] @ vectors
    raise ConvergenceError(f"{k} eigenpairs are not found with a basis of {limit} vectors; ask for fewer")


def orthonormal(block: NDArray[Any], M: sp.csr_array) -> tuple[NDArray[Any], float]:
    """Return an M-orthonormal basis of the columns, without those that depend on the others, and the factor by which
    the shortest direction has grown more than the longest.
    """
    growth = 1.0
    for _ in range(2):
        sizes, turns = np.linalg.eigh(np.conj(block.T) @ (M @ block))
        kept = sizes > 1e-14 * sizes[-1]
        growth *= float(np.sqrt(sizes[-1] / sizes[kept][0]))
        block = block @ (turns[:, kept] / np.sqrt(sizes[kept]))
    return block, growth


def _orthogonalize(block: NDArray[Any], basis: NDArray[Any], M: sp.csr_array, last: int) -> NDArray[Any]:
    """Make a block, in place, M-orthogonal to a basis; return its coefficients.

    Nearly all of its part in the basis is in the last two blocks of it, from a column on: it is removed first, so that
    one pass over the whole basis is as good as two [Parlett, The Symmetric Eigenvalue Problem, 1980, sec. 6.9].
    """
    coefficients = np.zeros((basis.shape[1], block.shape[1]), dtype=block.dtype)
    for begin in (last, 0):
        part = np.conj(basis[:, begin:].T) @ (M @ block)
        block -= basis[:, begin:] @ part
        coefficients[begin:] += part
    return coefficients
