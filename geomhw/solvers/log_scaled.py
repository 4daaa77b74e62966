"""Solutions that decay over hundreds of orders of magnitude, stored as logarithms.

The solution u of the heat system (M + tS) u = b falls about as exp(-d/√t) with the distance d from the sources, and
underflows some 700 √t away. With u = exp(-p) v, the scaled system

    (a_ij exp(p_i - p_j)) v = exp(p) b

has a solution v of order one where p is close to -log u. `solve_decaying` finds p in rounds: where v is in range,
p - log|v| is -log u; p is extrapolated from there, and the system is scaled and solved again.

Own code, because no sparse solver of numpy or scipy works in logarithms or extended precision.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Complexes, Floats
from geomhw.errors import ConvergenceError
from geomhw.solvers.direct import SparseLU, single_threaded

#: Values from exp(-REACH) to exp(REACH) are in range; doubles end at exp(-708) and exp(709).
REACH = 600.0
#: Each round extends the part in range by at least half: enough for paths of 10¹² edges.
MAX_ROUNDS = 60


@dataclass(frozen=True)
class LogValues:
    """Numbers sign · exp(log), far below the smallest double; log is -inf for zero.

    The sign of a complex number z is z/|z|.
    """

    log: Floats
    sign: NDArray[Any]

    @property
    def plain(self) -> NDArray[Any]:
        """The numbers as doubles; those below 1e-308 underflow to zero."""
        return np.asarray(self.sign * np.exp(self.log))

    @classmethod
    def of(cls, values: NDArray[Any], potential: Floats | float = 0.0) -> "LogValues":
        """Return exp(-potential) · values."""
        sign = _unit(values) if np.iscomplexobj(values) else np.sign(values)
        with np.errstate(divide="ignore"):
            return cls(np.log(np.abs(values)) - potential, sign)

    def mean_with(self, other: "LogValues") -> "LogValues":
        """Return half the sum of both."""
        largest = np.maximum(self.log, other.log)
        largest = np.where(np.isfinite(largest), largest, 0.0)
        half = (self.sign * np.exp(self.log - largest) + other.sign * np.exp(other.log - largest)) / 2
        return LogValues.of(half, -largest)


def _unit(z: Complexes) -> Complexes:
    """z/|z|; zero stays zero. Scaled first, so that no square underflows."""
    size = np.maximum(np.abs(z.real), np.abs(z.imag))
    scaled_z = np.divide(z, size, out=np.zeros_like(z), where=size > 0)
    return np.asarray(np.divide(scaled_z, np.abs(scaled_z), out=scaled_z, where=size > 0))


def in_reach(values: NDArray[Any]) -> bool:
    """Return whether the smallest value is far from underflow, relative to the largest."""
    size = np.abs(values)
    return bool(size.min(initial=np.inf) > np.exp(-REACH) * size.max(initial=0.0))


def scaled(matrix: sp.csr_array, potential: Floats) -> sp.csr_array:
    """Return diag(exp p) A diag(exp -p), whose entries depend on differences of p only."""
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    factor = np.exp(potential[rows] - potential[matrix.indices])
    return sp.csr_array((matrix.data * factor, matrix.indices, matrix.indptr), shape=matrix.shape)


def solve_scaled(matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats) -> NDArray[Any]:
    """Return v = exp(p) u for A u = b, where p is close to -log|u|, and small where b is not zero."""
    source = rhs * np.exp(np.where(rhs != 0, potential, 0.0))
    with single_threaded():
        return SparseLU(scaled(matrix, potential))(source)


def solve_decaying(matrix: sp.csr_array, rhs: Floats, plain: Floats, arrival: Floats) -> LogValues:
    """Solve A u = b where u decays with the arrival.

    Parameters
    ----------
    rhs : b, (n,), zero except at the sources.
    plain : (n,), the solution in doubles, right where it is in range.
    arrival : (n,), finite, zero at the sources, growing about as -log u.

    Raises
    ------
    ConvergenceError
        If rounds end before all of v is in range.
    """
    potential, v = np.zeros_like(arrival), plain
    decay, known, rate = potential, np.zeros(len(arrival), dtype=bool), 0.0
    for _ in range(MAX_ROUNDS):
        if np.isfinite(v).all():
            with np.errstate(divide="ignore"):
                log = np.log(np.abs(v))
            in_range = np.abs(log) < REACH
            if in_range.all():
                return LogValues.of(v, potential)
            # The solution is known up to the first arrival at which it is out of range.
            known = in_range & (arrival < arrival[~in_range].min())
            decay = potential - np.where(known, log, 0.0)
            rate = _least_rate(decay, known, arrival)
        else:
            rate *= 0.7  # v overflowed: p grew faster than -log u
        potential = np.where(known, decay, rate * arrival)
        v = _solve_or_nan(matrix, rhs, potential)
    raise ConvergenceError("heat does not reach the far side of the mesh in double precision; take a larger time step")


def _least_rate(decay: Floats, known: NDArray[np.bool_], arrival: Floats) -> float:
    """Least decay per arrival in the outer half of the known part: a rate too small underflows, without harm."""
    outer = known & (arrival > 0) & (arrival >= arrival[known].max(initial=0.0) / 2)
    return float((decay[outer] / arrival[outer]).min(initial=1.0))


def _solve_or_nan(matrix: sp.csr_array, rhs: Floats, potential: Floats) -> Floats:
    """`solve_scaled`, NaN where it overflows."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        try:
            return np.asarray(solve_scaled(matrix, rhs, potential))
        except ConvergenceError:
            return np.full_like(rhs, np.nan)
