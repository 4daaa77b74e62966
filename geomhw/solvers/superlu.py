"""Factorization by SuperLU, which every scipy has: for any matrix of symmetric pattern and dominant diagonal."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from geomhw.errors import ConvergenceError
from geomhw.solvers.factorization import NO_SOLUTION, Factorization


class SuperLU(Factorization):
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

    def _solved(self, b: NDArray[Any]) -> NDArray[Any]:
        x: NDArray[Any] = self._lu.solve(b.astype(np.result_type(self._dtype, b.dtype)))
        return x
