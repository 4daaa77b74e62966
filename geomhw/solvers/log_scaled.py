"""Solutions that decay over hundreds of orders of magnitude, kept in logarithms.

The heat system (M + tS) u = b has a solution that falls like exp(-r/√t): double precision loses it some 700 lengths
√t from the source. Written as u = exp(-p) v, with p near the decay, the same system for v has entries of order one
wherever neighbors have similar p, and v stays in range: (A_ij exp(p_i - p_j)) v = exp(p) b.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError
from geomhw.solvers.direct import SparseLU
from geomhw.solvers.threads import single_threaded

#: Natural logarithms between which a double is trusted; the format itself ends at -708 and 709.
REACH = 600.0
#: Each round extends the range at least half as far again; enough for paths of 10¹² edges.
MAX_ROUNDS = 60


@dataclass(frozen=True)
class LogValues:
    """Numbers as sign · exp(log), so that none is too small: log is -inf where the value is zero."""

    log: Floats
    sign: Floats

    @property
    def plain(self) -> Floats:
        """The numbers as they are; below 1e-308 they fade to zero."""
        return np.asarray(self.sign * np.exp(self.log))

    @classmethod
    def of(cls, values: Floats, potential: Floats | float = 0.0) -> "LogValues":
        """exp(-potential) · values."""
        with np.errstate(divide="ignore"):
            return cls(np.log(np.abs(values)) - potential, np.sign(values))

    def mean_with(self, other: "LogValues") -> "LogValues":
        """Half the sum of both."""
        top = np.maximum(self.log, other.log)
        top = np.where(np.isfinite(top), top, 0.0)
        half = (self.sign * np.exp(self.log - top) + other.sign * np.exp(other.log - top)) / 2
        return LogValues.of(half, -top)


def in_reach(values: NDArray[Any]) -> bool:
    """Whether a decaying solution has stayed clear of underflow all the way."""
    size = np.abs(values)
    return bool(size.min(initial=np.inf) > np.exp(-REACH) * size.max(initial=0.0))


def scaled(matrix: sp.csr_array, potential: Floats) -> sp.csr_array:
    """diag(exp p) A diag(exp -p), formed entry by entry so that only differences of p between neighbors matter."""
    rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    factor = np.exp(potential[rows] - potential[matrix.indices])
    return sp.csr_array((matrix.data * factor, matrix.indices, matrix.indptr), shape=matrix.shape)


def solve_decaying(matrix: sp.csr_array, rhs: Floats, plain: Floats, travel: Floats) -> LogValues:
    """Solve A u = b where u falls off with ``travel``, at any extent.

    rhs: zero but at the sources. plain: the solution in ordinary doubles, right as far as it is in reach. travel:
    finite, (n,), zero at the sources, growing with -log u.

    In rounds: the part in reach tells how fast the solution decays; the rest is extrapolated from there, the system
    scaled by that guess and solved again, until all is in reach. ConvergenceError if that does not come about.
    """
    potential, v = np.zeros_like(travel), plain
    decay, known, rate = potential, np.zeros(len(travel), dtype=bool), 0.0
    for _ in range(MAX_ROUNDS):
        if np.isfinite(v).all():
            with np.errstate(divide="ignore"):
                log = np.log(np.abs(v))
            trusted = np.abs(log) < REACH
            if trusted.all():
                return LogValues.of(v, potential)
            # Trust grows outward from the sources: beyond the first vertex out of reach, nothing is known.
            known = trusted & (travel < travel[~trusted].min())
            decay = potential - np.where(known, log, 0.0)
            rate = _least_rate(decay, known, travel)
        else:
            rate *= 0.7  # the guess fell faster than the solution, which overflowed: guess again, flatter
        potential = np.where(known, decay, rate * travel)
        v = _solve_or_nan(matrix, rhs, potential)
    raise ConvergenceError("heat does not reach the far side of the mesh in double precision; take a larger time step")


def _least_rate(decay: Floats, known: NDArray[np.bool_], travel: Floats) -> float:
    """Slowest decay per travel in the outer half of the known part: a guess too flat underflows, which does no harm."""
    outer = known & (travel > 0) & (travel >= travel[known].max(initial=0.0) / 2)
    return float((decay[outer] / travel[outer]).min(initial=1.0))


def solve_scaled(matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats) -> NDArray[Any]:
    """v = exp(p) u, of order one where p is near the decay of u, for A u = b with b zero but where p is small."""
    source = rhs * np.exp(np.where(rhs != 0, potential, 0.0))
    with single_threaded():
        return SparseLU(scaled(matrix, potential))(source)


def _solve_or_nan(matrix: sp.csr_array, rhs: Floats, potential: Floats) -> Floats:
    """The scaled solution; not finite where that overflows."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        try:
            return np.asarray(solve_scaled(matrix, rhs, potential))
        except ConvergenceError:
            return np.full_like(rhs, np.nan)
