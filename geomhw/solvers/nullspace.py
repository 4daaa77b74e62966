"""The null space of a semidefinite Laplacian: which unknowns to fix, and means to remove, component by component."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints


def free_unknowns(components: Ints, isolated: Ints, held: Ints | None = None) -> NDArray[np.bool_]:
    """Return a mask, (n,), of the unknowns to solve for: all but the isolated and the held.

    held: by default the first vertex of each component.
    """
    free = np.ones(len(components), dtype=bool)
    free[np.unique(components, return_index=True)[1] if held is None else held] = False
    free[isolated] = False
    return free


def without_mean(values: Floats, labels: Ints, weights: Floats | None = None, *, integrated: bool = False) -> Floats:
    """Subtract the mean over each component.

    Parameters
    ----------
    values : (n,) or (n, k) array.
    labels : (n,) array, the component of each entry.
    weights : (n,) array, by default ones. A component of weight zero keeps its values.
    integrated : whether values are integrals, already multiplied by the weights. The mean is Σ values / Σ weights, and
        weights times the mean is subtracted, so that the result sums to zero on each component. With weights of one,
        this is the right-hand side for which a Neumann problem has a solution.
    """
    n, count = len(values), int(labels.max(initial=-1)) + 1
    w = np.ones(n) if weights is None else weights
    integrals = values if integrated or weights is None else (values.T * w).T
    if count == 1:
        totals, sizes = integrals.sum(axis=0, keepdims=True), w.sum(keepdims=True)
    else:
        sums = sp.csr_array((np.ones(n), (labels, np.arange(n))), shape=(count, n))
        totals, sizes = sums @ integrals, sums @ w
    mean = np.divide(totals.T, sizes, out=np.zeros_like(totals.T), where=sizes > 0).T
    spread = mean if count == 1 else mean[labels]
    return np.asarray(values - ((spread.T * w).T if integrated else spread))
