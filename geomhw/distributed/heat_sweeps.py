"""The heat system (M + tS) u = b by sweeps in the order in which heat arrives, over the vertices of all ranks.

The method is that of `geomhw.solvers.heat_sweeps`: u_i = exp(-p_i) w_i, and a window that moves outward with the heat.
Every rank sweeps over its vertices in the window, with the last values at its ghosts. Values at ghosts are exchanged
after each sweep. So the error of each value is small relative to that value, at any distance from the sources.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.overlap import overlapping_rows
from geomhw.distributed.ranks import release_memory
from geomhw.errors import ConvergenceError
from geomhw.solvers.expm import absolute_row_sums
from geomhw.solvers.heat_sweeps import (
    FINAL_TOLERANCE,
    MARGIN,
    MAX_SWEEPS,
    SAMPLES,
    TOLERANCE,
    WINDOW,
    WINDOW_EDGES,
    over_relaxation,
    sweep,
)
from geomhw.solvers.log_scaled import LogValues

#: Layers of vertices of other ranks that a rank sweeps over, too. With three, sweeps converge as on one rank.
LAYERS = 3


class HeatSweeps:
    """Sweeps for one matrix, in the order of one arrival.

    Parameters
    ----------
    assemble : returns A, (k, k + g), the rows of this rank, with columns for its vertices and ghosts; A is not kept.
    arrival : (k,), growing about as -log u from zero at the sources; inf where no heat arrives.
    """

    def __init__(self, mesh: LocalMesh, assemble: Callable[[], sp.csr_array], arrival: Floats) -> None:
        self._ranks, self._n_own = mesh.ranks, mesh.n_own
        rows = overlapping_rows(mesh, assemble(), LAYERS)
        self._halo, arrival = rows.halo, np.concatenate([arrival, rows.halo(arrival)])
        self._swept_here = np.flatnonzero(
            np.isfinite(arrival) & np.append(np.ones(mesh.n_own, dtype=bool), rows.overlap)
        )
        self._order = self._swept_here[np.argsort(arrival[self._swept_here], kind="stable")]
        self._arrival, self._ghost_arrival = arrival[self._order], arrival[mesh.n_own :]
        self._place = np.full(len(arrival), -1, dtype=np.int32)
        self._place[self._order] = np.arange(len(self._order))
        A, overlap = rows.matrix[self._order], rows.overlap
        del rows
        places = self._place[A.indices]
        inside = places >= 0
        self._outer = _selected(A, ~inside, A.indices - mesh.n_own, len(overlap))
        self._inner = _selected(A, inside, places, len(self._order))
        del A, places, inside
        release_memory()
        self._inner.sort_indices()
        self._border = np.flatnonzero(np.diff(self._outer.indptr))
        self._outer = self._outer[self._border]
        self._diagonal = self._inner.diagonal().real
        #: The factor of over-relaxation. It is `MAX_OMEGA` where few rows are diagonally dominant; sweeps may diverge.
        self.omega = self._over_relaxation()
        #: Sweeps so far over windows, each followed by an exchange of values at ghosts.
        self.sweeps, self._updates = 0, 0

    def __call__(self, rhs: NDArray[Any]) -> LogValues:
        """Return u, (k,), for b, (k,), real or complex as A; zero where no heat arrives.

        Raises
        ------
        ConvergenceError
            If sweeps do not converge.
        """
        edge = self._ranks.max(self._longest_edge())
        p, w = self._swept(rhs, max(WINDOW, WINDOW_EDGES * edge), max(MARGIN, edge), self.omega)
        values, found, own = LogValues.of(np.zeros_like(rhs)), LogValues.of(w, p), self._order < self._n_own
        values.log[self._order[own]], values.sign[self._order[own]] = found.log[own], found.sign[own]
        return values

    def _over_relaxation(self) -> float:
        """ω from a sample of rows of each rank. Rows at equal intervals would not do: meshes repeat themselves."""
        sample = np.random.default_rng(0).integers(len(self._order), size=min(SAMPLES, len(self._order)))
        mu = absolute_row_sums(self._inner[sample]) / self._diagonal[sample] - 1.0
        return over_relaxation(np.concatenate(self._ranks.comm.allgather(mu)))

    def _longest_edge(self) -> float:
        A = self._inner
        if not A.nnz:
            return 0.0
        return float((self._arrival[A.indices] - np.repeat(self._arrival, np.diff(A.indptr))).max(initial=0.0))

    def _swept(self, rhs: NDArray[Any], window: float, margin: float, omega: float) -> tuple[Floats, NDArray[Any]]:
        """Return p and w of the reached vertices in the order of arrival."""
        n, A = len(self._order), self._inner
        source = np.append(rhs, self._halo(rhs))[self._order]
        p, b, w = np.full(n, np.nan), np.zeros_like(source), np.zeros_like(source)
        state = A.indptr, A.indices, A.data, 1.0 / self._diagonal, b, self._arrival, margin, A.indptr[:-1].copy(), p, w
        outer = self._border, self._outer.indptr, self._outer.indices, self._outer.data, self._ghost_arrival
        end, limit = 0, window
        # Vectors cancel where they meet. There, residuals of 1e-16 of all terms, `TOLERANCE` · `SMALL`, are rounding.
        first = FINAL_TOLERANCE if np.iscomplexobj(w) else TOLERANCE
        # On a way longer than the window, over-relaxation would let errors grow: the last sweeps have ω = 1.
        for factor, tolerance in ((omega, first), (1.0, FINAL_TOLERANCE)):
            start, sweeps, reach = 0, 0, -np.inf
            while reach < np.inf:
                ghosts = self._at_ghosts(p, w)
                end = _enter(state, outer, ghosts, end, limit, source)
                _flow_in(state, outer, ghosts, start, end, source)
                converged = sweep(state, start, end, factor, tolerance)
                self.sweeps, sweeps, self._updates = self.sweeps + 1, sweeps + 1, self._updates + end - start
                farther = self._ranks.min(float(self._arrival[converged]) - margin if converged < n else np.inf)
                if farther > reach:
                    reach, sweeps = farther, 0
                if sweeps > MAX_SWEEPS:
                    raise ConvergenceError("sweeps of the heat equation do not converge; take a shorter time step")
                start, limit = max(start, int(np.searchsorted(self._arrival, reach))), max(limit, reach + window)
        return p, w

    def _at_ghosts(self, p: Floats, w: NDArray[Any]) -> tuple[Floats, NDArray[Any]]:
        """p, NaN where it is unknown, and w at ghosts; the values of other ranks replace those here."""
        place = self._place[self._halo.places]
        sent = np.full((len(place), 2), np.nan, dtype=w.dtype)
        known = place >= 0
        sent[known, 0], sent[known, 1] = p[place[known]], w[place[known]]
        ghosts = self._ranks.send(sent, self._halo.sent, self._halo.received)
        ghost_p, ghost_w = np.ascontiguousarray(ghosts[:, 0].real), np.ascontiguousarray(ghosts[:, 1])
        here = self._place[self._n_own :]
        both = np.flatnonzero((here >= 0) & ~np.isnan(ghost_p))
        both = both[~np.isnan(p[here[both]])]
        w[here[both]] = ghost_w[both] * np.exp(p[here[both]] - ghost_p[both])
        return ghost_p, ghost_w

    @property
    def per_vertex(self) -> float:
        """Mean number of sweeps over a vertex."""
        return float(self._ranks.sum(self._updates) / self._ranks.sum(len(self._order)))


def _selected(matrix: sp.csr_array, chosen: Ints, columns: Ints, width: int) -> sp.csr_array:
    """The chosen entries of a matrix, in other columns."""
    if chosen.all():
        return sp.csr_array((matrix.data, columns, matrix.indptr), shape=(matrix.shape[0], width))
    ends = np.concatenate([[0], np.cumsum(chosen)])[matrix.indptr]
    return sp.csr_array((matrix.data[chosen], columns[chosen], ends), shape=(matrix.shape[0], width))


@compiled
def _enter(state: Any, outer: Any, ghosts: Any, end: int, limit: float, source: Any) -> int:
    """Let unknowns with an arrival up to the limit enter, until one waits for a ghost; return the new end.

    p_i is that of the neighbor nearest to the sources, less the logarithm of its w.
    """
    indptr, indices, _, _, b, arrival, _, _, p, w = state
    border, outer_indptr, outer_indices, _, ghost_arrival = outer
    ghost_p, ghost_w = ghosts
    row = np.searchsorted(border, end)
    while end < len(p) and arrival[end] <= limit:
        nearest, ghost = min(indices[indptr[end]], max(end - 1, 0)), -1
        if row < len(border) and border[row] == end:
            for k in range(outer_indptr[row], outer_indptr[row + 1]):
                j = outer_indices[k]
                if ghost_arrival[j] < (arrival[nearest] if ghost < 0 else ghost_arrival[ghost]):
                    ghost = j
            row += 1
        if ghost >= 0 and np.isnan(ghost_p[ghost]):
            break
        size = abs(ghost_w[ghost]) if ghost >= 0 else abs(w[nearest])
        before = ghost_p[ghost] if ghost >= 0 else (p[nearest] if nearest < end else 0.0)
        p[end] = before - (np.log(size) if size > 0.0 else 0.0)
        if source[end] != 0.0:
            b[end] = source[end] * np.exp(p[end])
        end += 1
    return end


@compiled
def _flow_in(state: Any, outer: Any, ghosts: Any, start: int, end: int, source: Any) -> None:
    """Set the right-hand side of unknowns from start to end that have ghosts: sources, and heat from the ghosts."""
    b, p = state[4], state[8]
    border, indptr, indices, data, _ = outer
    ghost_p, ghost_w = ghosts
    for row in range(np.searchsorted(border, start), np.searchsorted(border, end)):
        i = border[row]
        b[i] = source[i] * np.exp(p[i]) if source[i] != 0.0 else 0.0
        for k in range(indptr[row], indptr[row + 1]):
            j = indices[k]
            if not np.isnan(ghost_p[j]):
                b[i] -= data[k] * np.exp(p[i] - ghost_p[j]) * ghost_w[j]
