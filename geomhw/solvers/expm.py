"""exp(tA) b for sparse A, by products with A alone."""

import math

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError

#: Largest step times norm of one `taylor3` substep: on imaginary eigenvalues iy it grows by y⁴/8 a substep.
TAYLOR3_STEP = 0.2
#: Largest step times norm of one substep of the full series, which then ends within some 25 terms.
SERIES_STEP = 3.0
#: More substeps than this mean that the step, not the mesh, is wrong.
MAX_SUBSTEPS = 10_000


def norm_bound(matrix: sp.csr_array) -> float:
    """Largest absolute row sum, an upper bound on the modulus of every eigenvalue."""
    return float(absolute_row_sums(matrix).max(initial=0.0))


def absolute_row_sums(matrix: sp.csr_array) -> Floats:
    """Σ_j |A_ij|, (n,), without a matrix of absolute values."""
    filled = np.flatnonzero(np.diff(matrix.indptr))
    sums = np.zeros(matrix.shape[0])
    sums[filled] = np.add.reduceat(np.abs(matrix.data), matrix.indptr[filled]) if len(filled) else 0.0
    return sums


def substeps(norm: float, t: float, limit: float) -> int:
    """How many parts to split t into so that each times the norm is within the limit; ConvergenceError for too many."""
    need = abs(t) * norm / limit
    if not math.isfinite(need) or need > MAX_SUBSTEPS:
        raise ConvergenceError(
            f"a step of {abs(t):g} crosses the mesh's smallest cells {need:.3g} times; take a shorter step"
        )
    return max(1, math.ceil(need))


def taylor3(matrix: sp.csr_array, t: float, values: Floats, *, norm: float | None = None) -> Floats:
    """(I + sA + s²A²/2)ᵏ b with s = t/k, the three terms of the course handout; k = 1 unless t is large.

    norm: the matrix's `norm_bound`, where it is at hand.
    """
    k = substeps(norm_bound(matrix) if norm is None else norm, t, TAYLOR3_STEP)
    s = t / k
    for _ in range(k):
        once = matrix @ values
        values = values + s * once + (s * s / 2) * (matrix @ once)
    return values


def expm(
    matrix: sp.csr_array, t: float, values: Floats, tolerance: float = 1e-15, *, norm: float | None = None
) -> Floats:
    """exp(tA) b to that tolerance of the largest entry of b, by the series in substeps; norm as in `taylor3`."""
    k = substeps(norm_bound(matrix) if norm is None else norm, t, SERIES_STEP)
    s = t / k
    for _ in range(k):
        term, total = values, values.copy()
        size = np.abs(values).max(initial=0.0)
        for order in range(1, 60):
            term = (s / order) * (matrix @ term)
            total += term
            if np.abs(term).max(initial=0.0) <= tolerance * size:
                break
        else:
            raise ConvergenceError("the exponential series did not end; take a shorter step")
        values = total
    return values
