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
#: Share of its squared length that a vector keeps, from which one orthogonalization is enough.
ENOUGH = 0.1


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
    block, size, look = orthonormal(start.astype(A.dtype), M), 0, 0
    while size < limit:
        before, size = size, size + block.shape[1]
        basis[:, before:size] = block
        image = inverse(M @ block)
        projected[:size, before:size] = _orthogonalize(image, basis[:, :size], M)
        block = orthonormal(image, M)
        # The parts of the basis in short columns have grown with them.
        _orthogonalize(block, basis[:, :size], M)
        block = orthonormal(block, M)
        rest = np.conj(block.T) @ (M @ image)
        look += 1
        if size >= k + 2 * BLOCK and look % LOOK == 0:
            upper = np.triu(projected[:size, :size])
            values, vectors = np.linalg.eigh(upper + np.conj(np.triu(upper, 1).T))
            values, vectors = values[::-1][:k], vectors[:, ::-1][:, :k]
            if (np.linalg.norm(rest @ vectors[before:size], axis=0) <= TOLERANCE * values).all():
                return 1 / values - 1, basis[:, :size] @ vectors
    raise ConvergenceError(f"{k} eigenpairs are not found with a basis of {limit} vectors; ask for fewer")


def orthonormal(block: NDArray[Any], M: sp.csr_array) -> NDArray[Any]:
    """Return an M-orthonormal basis of the columns, without those that depend on the others."""
    for _ in range(2):
        sizes, turns = np.linalg.eigh(np.conj(block.T) @ (M @ block))
        kept = sizes > 1e-14 * sizes[-1]
        block = block @ (turns[:, kept] / np.sqrt(sizes[kept]))
    return block


def _orthogonalize(block: NDArray[Any], basis: NDArray[Any], M: sp.csr_array) -> NDArray[Any]:
    """Make a block, in place, M-orthogonal to a basis; return its coefficients.

    A second pass follows where the first one leaves little [Daniel, Gragg, Kaufman, Stewart 1976].
    """
    coefficients = np.zeros((basis.shape[1], block.shape[1]), dtype=block.dtype)
    weighted = M @ block
    for _ in range(2):
        size = np.einsum("ij,ij->j", np.conj(block), weighted).real
        part = np.conj(basis.T) @ weighted
        block -= basis @ part
        coefficients += part
        weighted = M @ block
        if (np.einsum("ij,ij->j", np.conj(block), weighted).real > ENOUGH * size).all():
            break
    return coefficients
