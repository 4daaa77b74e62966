"""Sparse factorization: factor in the constructor, solve in the call."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu
from threadpoolctl import ThreadpoolController

from geomhw.errors import ConvergenceError

#: SuperLU calls BLAS for thousands of small blocks; threads for them cost ten times what they do.
_blas = ThreadpoolController()


def single_threaded() -> Any:
    """A context in which BLAS runs on one thread: faster for small blocks, and the same bits on every machine."""
    return _blas.limit(limits=1, user_api="blas")


_NO_SOLUTION = "the linear system has no finite solution; look for faces of nearly no area"


class DirectSolver:
    """Solves A x = b for a matrix with a symmetric pattern and dominant diagonal (SPD, or a scaled one), by SuperLU.

    free: the unknowns that are solved for, a boolean (n,) mask, by default all; the others are held at zero and their
    equations dropped. This grounds a semidefinite matrix (one vertex a component held) and drops empty rows.

    Raises ConvergenceError if the matrix is singular on the free unknowns.
    """

    def __init__(self, matrix: sp.csr_array, free: NDArray[np.bool_] | None = None) -> None:
        self._size = matrix.shape[0]
        self._free = np.arange(self._size) if free is None else np.flatnonzero(free)
        kept = matrix if free is None else matrix[self._free][:, self._free]
        self._dtype = kept.dtype
        if self._free.size == 0:
            return
        try:
            # Symmetric mode keeps pivots on the diagonal: componentwise accurate for M-matrices, and less fill.
            with single_threaded():
                self._lu = splu(
                    kept.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
                )
        except RuntimeError as error:
            raise ConvergenceError(f"{_NO_SOLUTION} ({error})") from error

    def __call__(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """x for one right-hand side, (n,), or several, (n, k); zero where not free."""
        solution = np.zeros(rhs.shape, dtype=np.result_type(self._dtype, rhs.dtype))
        if self._free.size:
            with single_threaded():
                solution[self._free] = self._lu.solve(rhs[self._free].astype(solution.dtype))
        if not np.isfinite(solution).all():
            raise ConvergenceError(_NO_SOLUTION)
        return solution
