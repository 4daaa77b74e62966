"""Which unknowns of a semidefinite Laplacian to hold: one a component, and those that no face touches."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints


def free_unknowns(components: Ints, isolated: Ints, held: Ints | None = None) -> NDArray[np.bool_]:
    """Mask, (n,), of the unknowns to solve for: all but the isolated and the held.

    held: by default the first vertex of each component.
    """
    free = np.ones(len(components), dtype=bool)
    free[np.unique(components, return_index=True)[1] if held is None else held] = False
    free[isolated] = False
    return free


def balanced(rhs: Floats, components: Ints) -> Floats:
    """The right-hand sides, (n,) or (n, k), less their mean on each component: what a Neumann problem can answer."""
    count = int(components.max(initial=-1)) + 1
    if count == 1:
        return np.asarray(rhs - rhs.mean(axis=0))
    sums = sp.csr_array((np.ones(len(rhs)), (components, np.arange(len(rhs)))), shape=(count, len(rhs)))
    counts = np.maximum(np.bincount(components), 1)
    return np.asarray(rhs - ((sums @ rhs).T / counts).T[components])
