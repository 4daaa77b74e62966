"""Factorization by SuperLU, which every scipy has: for any matrix of symmetric pattern and dominant diagonal."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from geomhw.errors import ConvergenceError
from geomhw.mesh.arrays import Ints

NO_SOLUTION = "the linear system has no finite solution; look for faces of nearly no area"
NOT_DEFINITE = "the matrix is not positive definite"


class SuperLU:
    """Solves A x = b, symmetric or not; ConvergenceError where A is singular."""

    def __init__(self, matrix: sp.csr_array) -> None:
        self._dtype = matrix.dtype
        try:
            # Symmetric mode keeps pivots on the diagonal: componentwise accurate for M-matrices, and less fill.
            self._lu = splu(
                matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise ConvergenceError(f"{NO_SOLUTION} ({error})") from error

    def __call__(self, rhs: NDArray[Any], places: Ints | None = None, into: NDArray[Any] | None = None) -> NDArray[Any]:
        """x for one right-hand side, (n,), or several, (n, k); ConvergenceError if it is not finite.

        places: (n,), where they stand in longer vectors; the solution is then put there.
        """
        b = rhs if places is None else rhs[places]
        x: NDArray[Any] = self._lu.solve(b.astype(np.result_type(self._dtype, rhs.dtype)))
        if not np.isfinite(x).all():
            raise ConvergenceError(NO_SOLUTION)
        if into is None:
            return x
        into[places] = x
        return into
