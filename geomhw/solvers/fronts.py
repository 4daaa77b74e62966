"""Cholesky factorization in dense blocks along a dissection, and solutions of many right-hand sides at once.

Each node of the tree has a front: its own unknowns and the border, those further up that elimination links them to.
Bottom up, a front adds what its two branches left to the entries of the matrix, eliminates its own unknowns, and leaves
a matrix on its border [Duff, Reid 1983]. What a solution takes then are two products with dense blocks a front, which
for blocks of right-hand sides run at the speed of dense algebra, and not at that of memory.

Where no entry off the diagonal is positive no difference of numbers of one sign is formed but on diagonals: a solution
is right entry by entry, however small some are.

Duff, Reid: The Multifrontal Solution of Indefinite Sparse Symmetric Linear Equations. ACM TOMS 9(3), 1983.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import ConvergenceError
from geomhw.solvers.dissection import Dissection
from geomhw.solvers.factorization import NO_SOLUTION, NOT_DEFINITE
from geomhw.solvers.permutation import permuted

Matrix = NDArray[Any]


@dataclass(frozen=True)
class _Structure:
    """Where everything stands. Unknowns are numbered in the order of elimination, and so are the T fronts.

    order: (n,), the unknowns in that order. starts: (T+1,), of the fronts' own unknowns. borders: of each front, (b,).
    parents: (T,). within: of each front, the places of its border in its parent's front, (b,). rows, columns, values:
    of each front, entries on and below the diagonal, by places in the front.
    """

    order: Ints
    starts: list[int]
    borders: list[Ints]
    parents: list[int]
    within: list[Ints]
    rows: list[Ints]
    columns: list[Ints]
    values: list[Matrix]

    @classmethod
    def of(cls, matrix: sp.csr_array, tree: Dissection) -> "_Structure":
        """Of the lower triangle of a matrix, (n, n)."""
        n = matrix.shape[0]
        levels = np.frexp(tree.nodes)[1] - 1
        order = np.lexsort((tree.nodes, -levels))
        heap = np.concatenate([np.arange(1 << level, 2 << level) for level in range(tree.depth, -1, -1)])
        rank = np.empty(len(heap) + 1, dtype=np.int64)
        rank[heap] = np.arange(len(heap))
        sizes = np.bincount(rank[tree.nodes], minlength=len(heap))
        starts = np.append(0, np.cumsum(sizes))
        lower = sp.tril(permuted(matrix, order)).tocoo()
        r, c = (places.astype(np.int64) for places in lower.coords)
        owner = np.repeat(np.arange(len(heap)), sizes)
        parents = np.append(rank[heap[:-1] // 2], len(heap) - 1)
        # A border is named by the front and the unknown at once: ascending, these are the borders one by one.
        keys = _borders(owner, parents, r, c, tree.depth)
        front, unknown = keys // n, keys % n
        edges = np.searchsorted(front, np.arange(len(heap) + 1))

        def place(fronts: Ints, unknowns: Ints) -> Ints:
            own = owner[unknowns] == fronts
            beyond = np.searchsorted(keys, fronts * n + unknowns) - edges[fronts] + sizes[fronts]
            return np.where(own, unknowns - starts[fronts], beyond)

        of = owner[c]
        cuts = np.searchsorted(of, np.arange(len(heap) + 1))
        by_front = np.argsort(of, kind="stable")
        entries = [place(of, r)[by_front], place(of, c)[by_front], lower.data[by_front]]
        cuts = np.searchsorted(of[by_front], np.arange(len(heap) + 1))
        rows, columns, values = ([part[a:b] for a, b in pairwise(cuts)] for part in entries)
        borders, within = (
            [part[a:b] for a, b in pairwise(edges)] for part in (unknown, place(parents[front], unknown))
        )
        return cls(order, starts.tolist(), borders, parents.tolist(), within, rows, columns, values)


def _borders(owner: Ints, parents: Ints, r: Ints, c: Ints, depth: int) -> Ints:
    """Front times n plus unknown, for every unknown on the border of a front, ascending."""
    n = len(owner)
    outside = owner[r] != owner[c]
    direct = np.unique(owner[c[outside]] * n + r[outside])
    levels = [np.empty(0, dtype=np.int64)]
    # Level by level: what a front has on its border, its parent has, but for the parent's own unknowns.
    handed_on, low = levels[0], 0
    for level in range(depth, -1, -1):
        high = low + (1 << level)
        found = direct[np.searchsorted(direct, low * n) : np.searchsorted(direct, high * n)]
        levels.append(np.union1d(found, handed_on))
        above, unknown = parents[levels[-1] // n], levels[-1] % n
        handed_on = (above * n + unknown)[owner[unknown] != above]
        low = high
    return np.concatenate(levels)


class BlockCholesky:
    """Solves A x = b for A symmetric, or Hermitian, and positive definite; ConvergenceError if it is not.

    Of each front it keeps the inverse of the block of its own unknowns and what carries these to the border, so that
    forward substitution is one product, backward two.
    """

    def __init__(self, matrix: sp.csr_array) -> None:
        from scipy.linalg.lapack import get_lapack_funcs

        self._structure = s = _Structure.of(matrix, Dissection.of(matrix))
        kind = np.result_type(matrix.dtype, np.float64)
        self._complex = kind.kind == "c"
        self._inverses: list[Matrix] = []
        self._carriers: list[Matrix] = []
        left: dict[int, list[tuple[Ints, Matrix]]] = {}
        potrf, trtri = get_lapack_funcs(("potrf", "trtri"), dtype=kind)
        for t, (start, end) in enumerate(pairwise(s.starts)):
            c, size = end - start, end - start + len(s.borders[t])
            front = np.zeros((size, size), dtype=kind)
            front[s.columns[t], s.rows[t]] = s.values[t].conj()
            front[s.rows[t], s.columns[t]] = s.values[t]
            for places, remainder in left.pop(t, ()):
                front[places[:, None], places] += remainder
            triangle, info = potrf(front[:c, :c], lower=True) if c else (front[:c, :c], 0)
            if info:
                raise ConvergenceError(NOT_DEFINITE)
            inverse_triangle = trtri(triangle, lower=True)[0] if c else triangle
            self._inverses.append(inverse_triangle.conj().T @ inverse_triangle)
            self._carriers.append(front[c:, :c] @ self._inverses[t])
            remainder = front[c:, c:] - self._carriers[t] @ front[:c, c:]
            left.setdefault(s.parents[t], []).append((s.within[t], remainder))

    def __call__(self, rhs: Matrix, places: Ints | None = None, into: Matrix | None = None) -> Matrix:
        """x for right-hand sides (n,) or (n, k), of which zeros save work; ConvergenceError if it is not finite.

        places: (n,), where they stand in longer vectors; the solution is then put there.
        """
        s = self._structure
        order = s.order if places is None else places[s.order]
        kind = np.result_type(rhs.dtype, self._inverses[0].dtype)
        x = np.ascontiguousarray(rhs[order], dtype=kind).reshape(len(order), -1)
        warm = self._reached(x)
        with np.errstate(under="ignore", over="ignore", invalid="ignore"):
            for t, (start, end) in enumerate(pairwise(s.starts)):
                if warm[t] and end > start:
                    x[s.borders[t]] -= self._carriers[t] @ x[start:end]
            for t in range(len(warm) - 1, -1, -1):
                own = x[s.starts[t] : s.starts[t + 1]]
                from_border = self._adjoint_times(self._carriers[t], x[s.borders[t]])
                if warm[t]:
                    np.subtract(self._inverses[t] @ own, from_border, out=own)
                else:
                    np.negative(from_border, out=own)
        if not (np.isfinite(x).all() if self._complex else np.isfinite([x.min(), x.max()]).all()):
            raise ConvergenceError(NO_SOLUTION)
        solution = np.empty(rhs.shape, dtype=kind) if into is None else into
        solution[order] = x.reshape(len(order), *rhs.shape[1:])
        return solution

    def _reached(self, x: Matrix) -> list[bool]:
        """Of each front, whether its part of the right-hand side, or that of a front below, is not all zero."""
        s = self._structure
        warm = np.logical_or.reduceat(np.append(x.any(axis=1), False), s.starts[:-1]) & (np.diff(s.starts) > 0)
        reached: list[bool] = warm.tolist()
        for t, parent in enumerate(s.parents):
            reached[parent] |= reached[t]
        return reached

    def _adjoint_times(self, block: Matrix, x: Matrix) -> Matrix:
        return (block.T @ x.conj()).conj() if self._complex else block.T @ x
