"""Direct solution of sparse systems by LU factorization: factor in the constructor, solve in the call.

SuperLU in symmetric mode factors P A Pᵀ = L U, where P is a reverse Cuthill-McKee permutation. It makes SuperLU's own
minimum-degree ordering eight times as fast on a subdivided sphere of 40,962 vertices, and costs nothing on a scan.

Own triangular solves for many right-hand sides (`triangular`), because SuperLU takes three times as long for each.
"""

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu
from threadpoolctl import ThreadpoolController

from geomhw.arrays import Ints
from geomhw.errors import ConvergenceError

#: Right-hand sides from which compiled loops are faster than SuperLU, the time to load them included.
BLOCK = 8
#: A row with more entries than this times the square root of the size is dense (the rule of Amestoy, Davis, Duff 1996).
DENSE = 10
#: Solvers call BLAS for thousands of small blocks; to start threads for them takes ten times as long as the work.
_blas = ThreadpoolController()
NO_SOLUTION = "the linear system has no finite solution; look for faces of nearly no area"


def single_threaded() -> Any:
    """Return a context in which BLAS runs on one thread: faster for small blocks, and deterministic."""
    return _blas.limit(limits=1, user_api="blas")


def permuted(matrix: sp.csr_array, order: Ints) -> sp.csr_array:
    """Return A[order][:, order], (n, n), with rows unsorted, in 60 % of the time of both indexings."""
    rows = matrix[order]
    rank = np.empty(len(order), dtype=rows.indices.dtype)
    rank[order] = np.arange(len(order))
    return sp.csr_array((rows.data, rank[rows.indices], rows.indptr), shape=rows.shape)


class SparseLU:
    """Solve A x = b for a square sparse A with a symmetric pattern and a nonzero diagonal.

    Pivots stay on the diagonal: componentwise accurate for M-matrices, and less fill.

    Raises
    ------
    ConvergenceError
        If A is singular.
    """

    def __init__(self, matrix: sp.csr_array) -> None:
        self._dtype = np.result_type(matrix.dtype, float)
        self._order: Ints = reverse_cuthill_mckee(sp.csr_array(matrix), symmetric_mode=True)
        dense = (np.diff(matrix.indptr) > DENSE * len(self._order) ** 0.5)[self._order]
        if dense.any():
            self._order = _dense_last(matrix, self._order[~dense], self._order[dense])
        self._rank = np.argsort(self._order)
        try:
            self._lu = _factored(permuted(matrix, self._order), "NATURAL" if dense.any() else "MMD_AT_PLUS_A")
        except RuntimeError as error:
            raise ConvergenceError(f"{NO_SOLUTION} ({error})") from error

    def __call__(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """Return x for one right-hand side, (n,), or several, (n, k); raise ConvergenceError if it is not finite."""
        if rhs.dtype.kind == "c" and self._dtype.kind != "c":
            return np.asarray(self(rhs.real) + 1j * self(rhs.imag))
        b = rhs.astype(self._dtype, copy=False)
        if b.ndim == 2 and b.shape[1] >= BLOCK:
            return self._block(b)
        x = np.empty(b.shape, self._dtype)
        x[self._order] = self._lu.solve(b[self._order])
        return _finite(x)

    @property
    def negative_pivots(self) -> int:
        """How many pivots are negative: of a Hermitian matrix, as many as eigenvalues."""
        return int(np.count_nonzero(self._lu.U.diagonal().real < 0))

    def _block(self, b: NDArray[Any]) -> NDArray[Any]:
        """Solve for all columns of b, (n, k), in one pass over the factors."""
        from geomhw.solvers.triangular import solve_lower, solve_upper

        L, U = self._factors
        y = np.take(b, self._order[np.argsort(self._lu.perm_r)], axis=0)
        solve_lower(L.indptr, L.indices, L.data, y)
        solve_upper(U.indptr, U.indices, U.data, y)
        return _finite(np.take(y, self._lu.perm_c[self._rank], axis=0))

    @cached_property
    def _factors(self) -> tuple[sp.csc_array, sp.csr_array]:
        """L in columns and U in rows, with sorted indices."""
        L, U = self._lu.L, self._lu.U.tocsr()
        L.sort_indices()
        U.sort_indices()
        return L, U


def _factored(matrix: sp.csr_array, ordering: str) -> Any:
    return splu(matrix.tocsc(), permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _dense_last(matrix: sp.csr_array, sparse: Ints, dense: Ints) -> Ints:
    """Return the minimum-degree order of the sparse rows, then the dense ones, which take SuperLU quadratic time."""
    pattern = sp.csr_array(abs(matrix[sparse][:, sparse]), dtype=float, copy=True)
    pattern.data[:] = -1.0
    pattern += sp.diags_array(np.diff(pattern.indptr) + 1.0)
    order = np.argsort(_factored(pattern, "MMD_AT_PLUS_A").perm_c)
    return np.concatenate([sparse[order], dense])


def _finite(x: NDArray[Any]) -> NDArray[Any]:
    if not np.isfinite(x).all():
        raise ConvergenceError(NO_SOLUTION)
    return x


class DirectSolver:
    """Solve A x = b for a symmetric or Hermitian A that is definite, or definite on its free unknowns.

    Parameters
    ----------
    matrix : (n, n) sparse array.
    free : (n,) mask of the unknowns to solve for, by default all. The others are held at zero and their equations
        dropped. This grounds a semidefinite matrix (one vertex held per component) and drops empty rows.

    Raises
    ------
    ConvergenceError
        If the matrix is singular on the free unknowns.

    Examples
    --------
    >>> chain = sp.csr_array(sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(3, 3)))
    >>> DirectSolver(chain)(np.array([1.0, 0.0, 1.0])).round(12)
    array([1., 1., 1.])
    """

    def __init__(self, matrix: sp.csr_array, free: NDArray[np.bool_] | None = None) -> None:
        self._free = None if free is None or free.all() else np.flatnonzero(free)
        kept = matrix if self._free is None else matrix[self._free][:, self._free]
        self._dtype = kept.dtype
        if kept.shape[0]:
            with single_threaded():
                self._solve = SparseLU(kept)

    def __call__(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """Return x for one right-hand side, (n,), or several, (n, k); zero where not free."""
        with single_threaded():
            if self._free is None:
                return self._solve(rhs)
            solution = np.zeros(rhs.shape, dtype=np.result_type(self._dtype, rhs.dtype))
            if self._free.size:
                solution[self._free] = self._solve(rhs[self._free])
            return solution
