"""A color carried by the flow that keeps its bounds."""

import numpy as np
import scipy.sparse as sp

from geomhw.mesh.arrays import Floats
from geomhw.solvers.exponential import exponential, norm_bound, substeps

#: Step times norm of D after which colors are held to their neighbors again: they have come about one edge.
RING_STEP = 1.5
#: Colors need no more digits than this.
DYE_TOLERANCE = 1e-7


def carry_dye(D: sp.csr_array, color: Floats, dt: float) -> Floats:
    """exp(-dt D) color, (n,) or (n, k), each value held within those of the one-ring that it came from.

    The exponential alone rings at edges of the color; held so, nothing leaves its bounds [Bermejo, Staniforth 1992].
    """
    parts = substeps(norm_bound(D), dt, RING_STEP)
    for _ in range(parts):
        low, high = _ring_range(D, color)
        color = np.clip(exponential(D, -dt / parts, color, DYE_TOLERANCE), low, high)
    return color


def _ring_range(D: sp.csr_array, color: Floats) -> tuple[Floats, Floats]:
    """Least and largest value at each vertex and its neighbors; of the vertex alone where it has none."""
    around = color[D.indices]
    busy = np.diff(D.indptr) > 0
    starts = D.indptr[:-1][busy]
    low, high = color.copy(), color.copy()
    low[busy] = np.minimum.reduceat(around, starts, axis=0)
    high[busy] = np.maximum.reduceat(around, starts, axis=0)
    return low, high
