"""Which unknowns of a semidefinite Laplacian to hold: one a component, and those that no face touches."""

import numpy as np
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
    """The right-hand side less its mean on each component: what a Neumann problem can answer."""
    counts = np.maximum(np.bincount(components), 1)
    mean = np.bincount(components, weights=rhs) / counts
    return np.asarray(rhs - mean[components])
