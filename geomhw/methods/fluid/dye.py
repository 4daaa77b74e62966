"""A color carried by the flow that keeps its bounds."""

import numpy as np
import scipy.sparse as sp

from geomhw.mesh.arrays import Floats
from geomhw.mesh.rings import OneRings
from geomhw.methods.fluid.vorticity import VorticityModel
from geomhw.solvers.exponential import norm_bound, substeps

#: Largest step times norm of D of a part. Runge and Kutta's fourth-order polynomial stands 2√2 on imaginary
#: eigenvalues, and the consistent mass raises those by 1.75 at most. Within it colors come less than two edges.
PART = 1.6


class Dye:
    """Carries colors on one mesh with small lag, each held within the two rings of vertices that it came from.

    dc/dt = -B M D c, B the mass correction of the vorticity: with the lumped mass alone fine stripes stand still. The
    polynomial alone rings at edges of the color; held so, nothing leaves its bounds [Bermejo, Staniforth 1992].
    """

    def __init__(self, model: VorticityModel) -> None:
        self._model = model
        self._rings = OneRings(model.mesh.edges, model.mesh.n_vertices)

    def carry(self, D: sp.csr_array, color: Floats, dt: float) -> Floats:
        """The color, (n,) or (n, k), after a time dt in the flow of D."""
        parts = substeps(norm_bound(D), dt, PART)
        for _ in range(parts):
            low, high = self._bounds(color)
            carried, term = color.copy(), color
            for order in (1, 2, 3, 4):
                term = self._model.sharpened((-dt / parts / order) * (D @ term), 1)
                carried += term
            color = np.clip(carried, low, high)
        return color

    def _bounds(self, color: Floats) -> tuple[Floats, Floats]:
        """Least and largest value within two rings."""
        flat = color.reshape(len(color), -1)
        both = np.concatenate([-flat, flat], axis=1)
        for _ in range(2):
            both = self._rings.largest(both)
        return -both[:, : flat.shape[1]].reshape(color.shape), both[:, flat.shape[1] :].reshape(color.shape)
