"""Advection of a color by the flow, within its bounds."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.flow.mass_correction import MassCorrection
from geomhw.solvers.expm import absolute_row_sums, substeps

#: Largest step times rate of a substep; the rate is the absolute row sum of D. RK4 is stable up to 2√2 on imaginary
#: eigenvalues, and the consistent mass raises those by 1.75 at most. Within it, color moves less than two edges.
SUBSTEP = 1.6
#: Share of the shortest waves, whose speed is wrong on the mesh, that is damped while the flow crosses an edge.
DAMPING = 1.0
#: Neighbors of a vertex that are stored in columns.
COLUMNS = 32
#: No vertices, as an index.
NONE = slice(0)


class PassiveScalar:
    """Advect colors on one mesh, with small lag and without new extrema.

    dc/dt = -B M D c by RK4, with the mass correction B of the vorticity: with the lumped mass alone fine stripes stand
    still. The shortest waves are damped, and each value is clipped to the range over the two-ring of its vertex before
    the substep.

    Parameters
    ----------
    correction : of the mass, and the filter, of the mesh.

    References
    ----------
    Bermejo, Staniforth: The conversion of semi-Lagrangian advection schemes to quasi-monotone schemes, 1992.
    """

    def __init__(self, correction: MassCorrection) -> None:
        self._correction = correction
        self._rings = OneRings(correction.mesh.edges, correction.mesh.n_vertices)

    def advect(self, D: sp.csr_array, color: Floats, dt: float, held: Ints | slice = NONE) -> Floats:
        """Return the color, (n,) or (n, k), after a time dt in the flow with directional derivative D, (n, n).

        held : vertices at which the color does not change, such as those of inflow through a boundary.
        """
        columns = color.reshape(len(color), -1)
        rates = absolute_row_sums(D).reshape(-1, 1)
        count = substeps(float(rates.max(initial=0.0)), dt, SUBSTEP)
        s = dt / count
        damping = np.minimum(DAMPING * s * rates, 1.0)
        for _ in range(count):
            low, high = self._bounds(columns)
            advected, term = columns.copy(), columns
            for order in (1, 2, 3, 4):
                term = self._correction.mass_corrected((-s / order) * (D @ term), 1)
                term[held] = 0.0
                advected += term
            advected -= self._correction.hyperdiffusion(advected, damping)
            advected[held] = columns[held]
            columns = np.clip(advected, low, high)
        return columns.reshape(color.shape)

    def _bounds(self, columns: Floats) -> tuple[Floats, Floats]:
        """Least and largest value over the two-ring of each vertex, (n, k)."""
        both = np.concatenate([-columns, columns], axis=1)
        for _ in range(2):
            both = self._rings.largest(both)
        k = columns.shape[1]
        return -both[:, :k], both[:, k:]


class OneRings:
    """The neighbors of each vertex, from the edges, (e, 2), of n vertices.

    The first are stored in columns, the k-th with the k-th neighbor of all vertices that have one: a maximum over
    columns is three to five times as fast as ``np.maximum.reduceat`` over rows, which takes the others. The time does
    not depend on the largest valence.
    """

    def __init__(self, edges: Ints, n: int) -> None:
        ends = np.concatenate([edges, edges[:, ::-1]])
        ends = ends[np.argsort(ends[:, 0], kind="stable")]
        valences = np.bincount(ends[:, 0], minlength=n)
        starts = np.cumsum(valences) - valences
        self._order = np.argsort(-valences, kind="stable")  # vertices with a k-th neighbor come first
        sorted_starts, sorted_valences = starts[self._order], valences[self._order]
        self._columns = [
            ends[sorted_starts[: np.searchsorted(-sorted_valences, -k)] + k, 1].astype(np.intp)
            for k in range(min(valences.max(initial=0), COLUMNS))
        ]
        others = sorted_valences[sorted_valences > COLUMNS] - COLUMNS
        self._row_starts = np.cumsum(others) - others
        shifts = sorted_starts[: len(others)] + COLUMNS - self._row_starts
        self._rows = ends[np.repeat(shifts, others) + np.arange(others.sum()), 1].astype(np.intp)

    def largest(self, values: Floats) -> Floats:
        """Return the largest of the values, (n,) or (n, k), at each vertex and its neighbors."""
        largest = np.take(values, self._order, axis=0)
        for column in self._columns:
            first = largest[: len(column)]
            np.maximum(first, np.take(values, column, axis=0), out=first)
        if len(self._rows):
            first = largest[: len(self._row_starts)]
            np.maximum(first, np.maximum.reduceat(np.take(values, self._rows, axis=0), self._row_starts), out=first)
        result = np.empty_like(largest)
        result[self._order] = largest
        return result
