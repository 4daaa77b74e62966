"""The heat system by sweeps that follow the heat: linear in size, right at any extent.

Scaled by a decay close to its own (`geomhw.solvers.wavefront`), the system (M + tS) u = b has a solution of order one,
and what is to be known at a vertex comes from those nearer to the source. So unknowns are put in the order in which
heat arrives and solved for in blocks of a few rings, by over-relaxed sweeps in that order [Young 1971], each block once
more with the next one; how the solution decays in one block scales the next.

Young: Iterative Solution of Large Linear Systems, Academic Press 1971.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.errors import ConvergenceError
from geomhw.mesh.arrays import Floats, Ints, dot
from geomhw.solvers.wavefront import LogValues

#: Width of a block, in lengths √t: what lies beyond changes a solution by exp(-2 · 20) there.
BLOCK = 20.0
#: A block is done when a sweep changes no value by more than this share of itself,
TOLERANCE = 1e-10
#: or, where it happens to be small, of this share of the largest in the block.
SMALL = 1e-6
MAX_SWEEPS = 400
#: Sweeps between two looks at how much one changes.
BETWEEN = 4
#: Relaxation beyond this lets errors grow on the way before they decay.
MOST_RELAXED = 1.6
#: What is left of an equation in the end, as a share of its terms; more than that is no solution.
RESIDUAL = 1e-6
ROWS_AT_ONCE = 1 << 17
NO_END = "heat does not settle in sweeps on this mesh; compute with --solver direct"


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
    blocks = _Blocks(matrix, rhs, travel, omega)
    potential, rate = blocks.travel.copy(), 1.0
    for back, low, high in blocks.bounds():
        if low:
            rate = blocks.rate(potential, back, low) or rate
            blocks.extend(potential, rate, low, high)
        blocks.settle(potential, back, high)
    blocks.check(potential)
    return LogValues.of(blocks.in_given_order(blocks.v), blocks.in_given_order(potential))


def solve_scaled_by_sweeps(matrix: sp.csr_array, rhs: NDArray[Any], potential: Floats, omega: float) -> NDArray[Any]:
    """v = exp(p) u, of order one where p is near the decay of u, for A u = b with b zero but where p is small.

    As `wavefront.solve_scaled`, for a Hermitian A, real or complex. ConvergenceError where a block does not settle.
    """
    blocks = _Blocks(matrix, rhs, potential - potential.min(initial=0.0), omega)
    ordered = potential[blocks.order]
    for back, _, high in blocks.bounds():
        blocks.settle(ordered, back, high)
    blocks.check(ordered)
    return blocks.in_given_order(blocks.v)


class _Blocks:
    """Unknowns of A u = b in the order in which heat arrives, in blocks of ``BLOCK`` lengths; v, (n,), is scaled."""

    def __init__(self, matrix: sp.csr_array, rhs: NDArray[Any], travel: Floats, omega: float) -> None:
        self.order = np.argsort(travel, kind="stable")
        self.travel = travel[self.order]
        self._matrix = _permuted(matrix, self.order)
        #: A relaxed sweep is one of Gauss and Seidel with the diagonal over ω, and the rest of it kept as it was.
        self._kept = (1.0 - 1.0 / omega) * self._matrix.diagonal()
        self._matrix.setdiag(self._matrix.diagonal() / omega)
        #: For each unknown, the first that heat comes to of itself and its neighbors.
        self._before = self._matrix.indices[self._matrix.indptr[:-1]]
        self._rows = np.repeat(np.arange(len(travel)), np.diff(self._matrix.indptr))
        kind = np.result_type(matrix.dtype, rhs.dtype, float)
        self._rhs = rhs[self.order].astype(kind)
        self._scaled_rhs, self.v = np.zeros((2, len(travel)), dtype=kind)

    def bounds(self) -> Iterator[tuple[int, int, int]]:
        """Where the block before starts, and this one, and where it ends."""
        p = self.travel
        back = low = 0
        for high in np.unique(np.append(np.searchsorted(p, np.arange(BLOCK, p[-1], BLOCK)), len(p))).tolist():
            yield back, low, high
            back, low = low, high

    def rate(self, potential: Floats, low: int, high: int) -> float:
        """By how much -log u grows with travel on the way to low to high, at least squares; 0 if that is unknown."""
        here = np.arange(low, high)
        before = self._before[low:high]
        ahead = self.travel[here] - self.travel[before]
        growth = self._decay(potential, here) - self._decay(potential, before)
        told = np.isfinite(growth)
        width = dot(ahead[told], ahead[told])
        return min(max(dot(growth[told], ahead[told]) / width, 0.1), 3.0) if width > 0 else 0.0

    def extend(self, potential: Floats, rate: float, low: int, high: int) -> None:
        """Guess potential and sign of unknowns low to high from those before, each from where its own heat comes."""
        origin = self._before[low:high]
        while not ((further := np.where(origin < low, origin, origin[np.maximum(origin - low, 0)])) == origin).all():
            origin = further
        decay = self._decay(potential, origin)
        lost = (origin >= low) | ~np.isfinite(decay)
        origin, decay = np.where(lost, low - 1, origin), np.where(lost, self._decay(potential, low - 1), decay)
        potential[low:high] = decay + rate * (self.travel[low:high] - self.travel[origin])
        self.v[low:high] = np.sign(self.v[origin])

    def _decay(self, potential: Floats, at: Ints | int) -> Floats:
        """-log u."""
        with np.errstate(divide="ignore"):
            return np.asarray(potential[at] - np.log(np.abs(self.v[at])))

    def check(self, potential: Floats) -> None:
        """ConvergenceError unless v solves its equations."""
        A = self._matrix
        for low in range(0, len(self.v), ROWS_AT_ONCE):
            high = min(low + ROWS_AT_ONCE, len(self.v))
            within = slice(A.indptr[low], A.indptr[high])
            columns = A.indices[within]
            terms = A.data[within] * np.exp(potential[self._rows[within]] - potential[columns]) * self.v[columns]
            starts = A.indptr[low:high] - A.indptr[low]
            left = np.add.reduceat(terms, starts) + self._kept[low:high] * self.v[low:high] - self._scaled_rhs[low:high]
            if not (np.abs(left) <= RESIDUAL * np.add.reduceat(np.abs(terms), starts)).all():
                raise ConvergenceError(NO_END)

    def settle(self, potential: Floats, low: int, high: int) -> None:
        """Solve for the unknowns low to high with those before held, in v, to that potential, (n,), in this order."""
        A = self._matrix
        hot = low + np.flatnonzero(self._rhs[low:high])
        self._scaled_rhs[hot] = self._rhs[hot] * np.exp(potential[hot])
        within = slice(A.indptr[low], A.indptr[high])
        columns = A.indices[within]
        shift = np.where(columns < high, potential[self._rows[within]] - potential[columns], -np.inf)
        data = A.data[within] * np.exp(shift)
        # All that the kernel sees begins at the first unknown that these rows speak of: no work on the rest.
        first = min(low, int(columns.min()))
        starts = A.indptr[first : high + 1] - A.indptr[low]
        columns = np.where(columns < high, columns, first) - columns.dtype.type(first)
        equations = _Equations(starts, columns, data, self._kept[first:high], self._scaled_rhs[first:high])
        equations.settle(self.v[first:high], low - first)

    def in_given_order(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values, (n,), back in the order of A."""
        back = np.empty_like(values)
        back[self.order] = values
        return back


def _permuted(matrix: sp.csr_array, order: Ints) -> sp.csr_array:
    """A[order][:, order], sorted; half of the time of that."""
    rows = matrix[order]
    place = np.empty(len(order), dtype=rows.indices.dtype)
    place[order] = np.arange(len(order))
    permuted = sp.csr_array((rows.data, place[rows.indices], rows.indptr), shape=rows.shape)
    permuted.sort_indices()
    return permuted


@dataclass(frozen=True)
class _Equations:
    """Those of a block, in rows of a matrix in place: sum of data over columns, and kept · x, is rhs."""

    starts: Ints
    columns: Ints
    data: NDArray[Any]
    kept: NDArray[Any]
    rhs: NDArray[Any]

    def settle(self, x: NDArray[Any], first: int) -> None:
        """Sweep x from ``first`` on, in place, away from the sources until it stays as it is."""
        inner = x[first:]
        for _ in range(0, MAX_SWEEPS, BETWEEN):
            for _ in range(BETWEEN - 1):
                self._sweep(x, first)
            old = inner.copy()
            self._sweep(x, first)
            size = np.abs(inner)
            if (np.abs(inner - old) <= TOLERANCE * (size + SMALL * size.max())).all():
                return
            if not np.isfinite(size.max()):
                break
        raise ConvergenceError(NO_END)

    def _sweep(self, x: NDArray[Any], first: int) -> None:
        from pyamg.amg_core import gauss_seidel

        gauss_seidel(self.starts, self.columns, self.data, x, self.rhs - self.kept * x, first, len(x), 1)
