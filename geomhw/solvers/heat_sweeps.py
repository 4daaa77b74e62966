"""The heat system by sweeps that follow the heat: linear in size, right at any extent.

What is to be known at a vertex comes from those nearer to the source. So unknowns are put in the order in which heat
arrives and solved for in blocks of some rings, by over-relaxed sweeps in that order [Young 1971], the last rings of
each once more with the next one; how the solution decays in one block tells what to begin with in the next.

Written as u = exp(-l) v, with l near the decay but in steps, the system for v (`log_scaled`) differs from
that for u only where a step lies between two neighbors, and v stays in range.

Young: Iterative Solution of Large Linear Systems, Academic Press 1971.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, dot
from geomhw.errors import ConvergenceError
from geomhw.solvers.gauss_seidel import diagonal_first, sweep
from geomhw.solvers.log_scaled import LogValues
from geomhw.solvers.permutation import permuted

#: Width of a block, in lengths √t,
BLOCK = 30.0
#: and of that part of it that is solved for once more with the next one: what lies beyond, at first held at zero,
#: changes a solution by exp(-2 · 20) before that.
OVERLAP = 20.0
#: A block is done when a sweep changes no value by more than this share of itself,
TOLERANCE = 1e-10
#: or, where it happens to be small, of this share of the largest in the block.
SMALL = 1e-6
MAX_SWEEPS = 400
#: Sweeps between two looks at how much one changes, from shortly before as many as in the last block on.
BETWEEN = 4
#: Relaxation beyond this lets errors grow on the way before they decay.
MOST_RELAXED = 1.6
#: What is left of an equation in the end, as a share of its terms; more than that is no solution.
RESIDUAL = 1e-6
#: Rounds of sweeps over blocks with such equations, before that is said.
MAX_ROUNDS = 20
#: Unknowns of a block, or about as many, that tell how fast heat decays.
SAMPLES = 1000
#: Natural logarithms in a step of the scale: a block spans less, mostly.
STEP = 64.0
NO_END = "sweeps of the heat equation do not converge on this mesh; compute with solver='direct'"


def over_relaxation(masses: Floats, diagonal: Floats) -> float:
    """ω that settles M + tS soonest, 1 for none; masses, diagonal: of M and M + tS, (n,) [Young 1971, ch. 6].

    Each row of tS sums to zero, so the share of its own equation that is not a vertex's mass bounds the spectrum of the
    Jacobi iteration where weights are positive. Three vertices in four may have less than is taken here.
    """
    share = 1.0 - np.quantile(masses / diagonal, 0.25)
    return float(min(2.0 / (1.0 + np.sqrt(1.0 - share**2)), MOST_RELAXED))


def solve_by_sweeps(matrix: sp.csr_array, rhs: Floats, travel: Floats, omega: float) -> LogValues:
    """Solve A u = b where u falls off with ``travel``, for A symmetric and positive definite.

    rhs: (n,), zero but at the sources. travel: (n,), finite, zero at the sources, growing about like -log u. omega: as
    `over_relaxation` finds it. ConvergenceError where a block does not settle.
    """
    blocks, rate = _Blocks(matrix, rhs, travel, omega), 1.0
    del matrix  # of no more use, and large
    for former, low, high in blocks.bounds():
        if low:
            rate = blocks.rate(former, low) or rate
        blocks.guess(rate, low, high)
        blocks.settle(former, low, high)
    blocks.finish()
    return LogValues.of(blocks.in_given_order(blocks.v), STEP * blocks.in_given_order(blocks.steps))


def solve_scaled_by_sweeps(matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats, omega: float) -> NDArray[Any]:
    """v = exp(p) u, of order one where p is near the decay of u, for A u = b with b zero but where p is small.

    As `wavefront.solve_scaled`, for a Hermitian A, real or complex. ConvergenceError where a block does not settle.
    """
    blocks = _Blocks(matrix, rhs, potential - potential.min(initial=0.0), omega)
    blocks.expect(potential[blocks.order], 0, len(potential))
    for former, low, high in blocks.bounds():
        blocks.settle(former, low, high)
    blocks.finish()
    return blocks.in_given_order(blocks.v / blocks.typical)


class _Blocks:
    """Unknowns of A u = b in the order in which heat arrives, in blocks of ``BLOCK`` lengths.

    v, (n,): exp(``STEP`` · steps) u, zero beyond the blocks that are done. typical, (n,): about how large it is.
    """

    def __init__(self, matrix: sp.csr_array, rhs: NDArray[Any], travel: Floats, omega: float) -> None:
        arrival = travel.astype(np.float32)
        self.order = _order(arrival)
        self.travel = arrival[self.order].astype(float)
        A = self._matrix = permuted(matrix, self.order)
        diagonal_first(A)
        #: A relaxed sweep is one of Gauss and Seidel with the diagonal over ω, and the rest of it kept as it was.
        self._diagonals = A.indptr[:-1]
        self._kept = (1.0 - 1.0 / omega) * A.data[self._diagonals]
        A.data[self._diagonals] /= omega
        #: For each unknown, the first and the last that heat comes to of itself and its neighbors.
        n, kind = len(travel), np.result_type(matrix.dtype, rhs.dtype, float)
        every = np.arange(n, dtype=A.indices.dtype)
        self._before = np.minimum(A.indices[np.minimum(self._diagonals + 1, A.nnz - 1)], every)
        self._after = np.maximum(A.indices[A.indptr[1:] - 1], every)
        self._sides = rhs[self.order].astype(kind)
        self.v, self._moved = np.zeros((2, n), dtype=kind)
        self._needed = 0  # sweeps, in the last block
        self.steps, self.typical = np.zeros(n, dtype=np.int32), np.zeros(n)

    def bounds(self) -> Iterator[tuple[int, int, int]]:
        """Where the block before starts, and this one, and where it ends."""
        p = self.travel
        former = low = 0
        for high in np.unique(np.append(np.searchsorted(p, np.arange(BLOCK, p[-1], BLOCK)), len(p))).tolist():
            yield former, low, high
            former, low = low, high

    def rate(self, low: int, high: int) -> float:
        """By how much -log u grows with travel on the way to low to high, at least squares; 0 if that is unknown."""
        here = slice(low, high, (high - low) // SAMPLES + 1)
        before = self._before[here]
        ahead = self.travel[here] - self.travel[before]
        growth = self._decay(here) - self._decay(before)
        told = np.isfinite(growth)
        width = dot(ahead[told], ahead[told])
        return min(max(dot(growth[told], ahead[told]) / width, 0.1), 3.0) if width > 0 else 0.0

    def guess(self, rate: float, low: int, high: int) -> None:
        """Begin with a guess of v low to high from those before, each from where its own heat comes."""
        if not low:
            self.expect(self.travel[:high], low, high)
            return
        origin = self._before[low:high].copy()
        within = np.flatnonzero(origin >= low)
        while within.size:
            former = origin[within]
            origin[within] = further = origin[former - low]
            within = within[(further != former) & (further >= low)]
        first = origin.min()
        decay = self._decay(slice(first, low))
        origin[(origin >= low) | ~np.isfinite(decay[np.minimum(origin, low - 1) - first])] = low - 1
        ahead = self.travel[low:high] - self.travel[origin]
        self.expect(decay[origin - first] + rate * ahead, low, high)
        self.v[low:high] = np.sign(self.v[origin]) * self.typical[low:high]

    def expect(self, decay: Floats, low: int, high: int) -> None:
        """Choose the scale of v for unknowns low to high from about what -log u is there."""
        steps = np.rint(decay / STEP)
        self.steps[low:high] = steps
        self.typical[low:high] = np.exp(STEP * steps - decay)

    def _decay(self, at: Ints | slice) -> Floats:
        """-log u."""
        with np.errstate(divide="ignore"):
            return np.asarray(STEP * self.steps[at] - np.log(np.abs(self.v[at])))

    def settle(self, former: int, low: int, high: int) -> None:
        """Solve for the unknowns low to high, and again for the last ones from ``former`` on, with all others held."""
        self._scale(former, low, low, high)
        self._scale(low, high, 0, high)
        hot = low + np.flatnonzero(self._sides[low:high])
        self._sides[hot] *= np.exp(STEP * self.steps[hot])
        self._relax(self._again(former, low), high, self._again(low, high))

    def _again(self, low: int, high: int) -> int:
        """From where on the unknowns low to high are solved for once more, with those that come next."""
        if high == len(self.travel):
            return high
        return max(low, int(np.searchsorted(self.travel, self.travel[high] - OVERLAP)))

    def _relax(self, low: int, high: int, last: int) -> None:
        """Sweep over the unknowns low to high until those before the last stay as they are."""
        here, typical = self.v[low:last], self.typical[low:last]
        done, until = 0, max(self._needed - BETWEEN, BETWEEN)
        while done < MAX_SWEEPS:
            for _ in range(done + 1, until):
                self._sweep(low, high)
            old = here.copy()
            self._sweep(low, high)
            done, until = until, until + BETWEEN
            old -= here
            size, change = np.abs(here) / typical, np.abs(old) / typical
            largest = size.max(initial=0.0)
            if (change <= TOLERANCE * (size + SMALL * largest)).all():
                self._needed = done
                return
            if not np.isfinite(largest):
                break
        raise ConvergenceError(NO_END, "solver='direct'")

    def _scale(self, low: int, high: int, first: int, last: int) -> None:
        """Bring entries of rows low to high, in columns first to last, from the equations for u to those for v."""
        if low == high:
            return
        A, before, after = self._matrix, self._before[low:high], self._after[low:high]
        # Most rows are far from any two neighbors in different steps.
        reach = slice(before.min(), min(after.max() + 1, last))
        changes = reach.start + np.flatnonzero(np.diff(self.steps[reach]))
        if not changes.size:
            return
        rows = low + np.flatnonzero((before <= changes[-1]) & (after > changes[0]))
        low, high = rows[0], rows[-1] + 1
        within = slice(A.indptr[low], A.indptr[high])
        columns = A.indices[within]
        steps = np.repeat(self.steps[low:high], np.diff(A.indptr[low : high + 1])) - self.steps[columns]
        between = np.flatnonzero((steps != 0) & (columns >= first) & (columns < last))
        A.data[within][between] *= np.exp(STEP * steps[between])

    def _sweep(self, low: int, high: int) -> None:
        here = slice(low, high)
        np.multiply(self._kept[here], self.v[here], out=self._moved[here])
        np.subtract(self._sides[here], self._moved[here], out=self._moved[here])
        sweep(self._matrix, self.v, self._moved, low, high)

    def finish(self) -> None:
        """Sweep again where v does not solve its equations: where heat comes from further on, as it may where fronts
        meet. ConvergenceError if that does not help."""
        for former, low, high in self.bounds():
            if (self._after[former:low] >= high).any():
                self._scale(former, low, high, len(self.v))
        for _ in range(MAX_ROUNDS):
            wrong = self._wrong()
            if not wrong.any():
                return
            for former, _, high in reversed(list(self.bounds())):
                if wrong[former:high].any():
                    self._relax(former, high, high)
        raise ConvergenceError(NO_END, "solver='direct'")

    def _wrong(self) -> NDArray[np.bool_]:
        """Unknowns whose equations do not hold, (n,)."""
        A, v = self._matrix, self.v
        left = np.abs(A @ v + self._kept * v - self._sides)
        wrong = ~(left <= RESIDUAL * np.abs(A.data[self._diagonals] * v))
        if wrong.any():  # mostly, one term tells
            wrong[wrong] = ~(left[wrong] <= RESIDUAL * (abs(A[wrong]) @ np.abs(v)))
        return wrong

    def in_given_order(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values, (n,), back in the order of A."""
        back = np.empty_like(values)
        back[self.order] = values
        return back


def _order(values: NDArray[np.float32]) -> Ints:
    """Stable ``argsort`` of values from 0 on, in linear time: by both halves of their bits, which order as they do."""
    bits = values.view(np.uint32)
    by_low = np.argsort(bits.astype(np.uint16), kind="stable")
    return by_low[np.argsort((bits >> 16).astype(np.uint16)[by_low], kind="stable")]
