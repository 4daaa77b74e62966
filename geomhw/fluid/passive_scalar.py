"""A color carried by the flow that keeps its bounds."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.fluid.vorticity import VorticityModel
from geomhw.mesh.rings import OneRings
from geomhw.solvers.expm import absolute_row_sums, substeps

#: Largest step times rate of a part, the rate being the absolute row sum of D. Runge and Kutta's fourth-order
#: polynomial stands 2√2 on imaginary eigenvalues, and the consistent mass raises those by 1.75 at most. Within it
#: colors come less than two edges.
PART = 1.6
#: How much of the finest waves, which the mesh carries at a wrong speed, goes while the flow crosses an edge.
WEAR = 1.0


class PassiveScalar:
    """Carries colors on one mesh with small lag, each held within the two rings of vertices that it came from.

    dc/dt = -B M D c, B the mass correction of the vorticity: with the lumped mass alone fine stripes stand still. What
    the mesh cannot carry wears off, and nothing leaves its bounds [Bermejo, Staniforth 1992].
    """

    def __init__(self, model: VorticityModel) -> None:
        self._model = model
        self._rings = OneRings(model.mesh.edges, model.mesh.n_vertices)

    def carry(self, D: sp.csr_array, color: Floats, dt: float) -> Floats:
        """The color, (n,) or (n, k), after a time dt in the flow of D."""
        columns = color.reshape(len(color), -1)
        rates = absolute_row_sums(D).reshape(-1, 1)
        parts = substeps(float(rates.max(initial=0.0)), dt, PART)
        step = dt / parts
        wear = np.minimum(WEAR * step * rates, 1.0)
        for _ in range(parts):
            low, high = self._bounds(columns)
            carried, term = columns.copy(), columns
            for order in (1, 2, 3, 4):
                term = self._model.sharpened((-step / order) * (D @ term), 1)
                carried += term
            carried -= self._model.roughness(carried, wear)
            columns = np.clip(carried, low, high)
        return columns.reshape(color.shape)

    def _bounds(self, columns: Floats) -> tuple[Floats, Floats]:
        """Least and largest value within two rings, (n, k)."""
        both = np.concatenate([-columns, columns], axis=1)
        for _ in range(2):
            both = self._rings.largest(both)
        k = columns.shape[1]
        return -both[:, :k], both[:, k:]
