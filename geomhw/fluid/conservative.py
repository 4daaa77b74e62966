"""The conservative fluid: vorticity advected by the midpoint velocity of the step, q1 = exp(-dt J_V̄ B) q0.

With V̄ = ½(V0 + V1), circulation is exact, since the columns of J sum to zero, and enstrophy is exact up to the series.
In the form q1 = q0 - dt J_V̄ w̄ with w̄ = B φ₁(-dt J_V̄ B) q0, energy is exact for any w̄, since J_V̄ is antisymmetric and
maps the stream function of V̄ to zero. So w̄ is updated only until V̄ is accurate enough; then V̄ alone converges.
"""

import math
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, dot
from geomhw.errors import ConvergenceError
from geomhw.fluid.vorticity_scheme import Unknowns, VorticityScheme
from geomhw.solvers.expm import SERIES_STEP, substeps

#: The iteration has converged when ψ and c change by less than this, relative to their size.
FIXED_POINT_TOLERANCE = 1e-10
MAX_ITERATIONS = 60
#: w̄ is final if the first iteration with it changes ψ and c by less than this, relative to their size.
MEAN_TOLERANCE = 1e-8
#: Until then w̄ is updated as soon as iterations with the old one reduce the change by this factor.
MEAN_UPDATE = 0.1
#: Terms of the exponential series below this share of the vorticity are dropped: for the first w̄, and for later ones.
SERIES_TOLERANCES = (1e-6, 1e-9)
#: The iteration diverges once the change is this many times the smallest so far.
DIVERGENCE = 1e3


class ConservativeScheme(VorticityScheme):
    """Exponential midpoint rule: conserves energy and circulation, and enstrophy up to the filter.

    Without the filter, the scheme is reversible in time. Parameters and errors are those of `VorticityScheme`.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(2)
    >>> x, y, z = mesh.vertices.T
    >>> scheme = ConservativeScheme(mesh)
    >>> state = scheme.from_vorticity(2 * z + x * y, color=z)
    >>> scheme.step(state, dt=0.1).time
    0.1
    """

    def advect(self, flow: Unknowns, dt: float) -> tuple[Unknowns, sp.csr_array]:
        """Solve the midpoint rule for the end of the step by fixed-point iteration from an extrapolated guess."""
        guess, sizes = replace(flow, psi=_extrapolated(flow)), _sizes(flow)
        updates, due, first, least = 0, True, np.inf, np.inf
        for _ in range(MAX_ITERATIONS):
            psi, c = (flow.psi + guess.psi) / 2, (flow.c + guess.c) / 2
            J = self.model.jacobian(psi, c)
            if due:
                w, end = self.mean_vorticity(flow.q, J, dt, SERIES_TOLERANCES[updates > 0])
                if not updates:
                    loss = self.filter_loss(end, dt, J)
            later = self.midpoint_rule(flow, psi, c, J, w, loss, dt)
            change = _change(guess, later, sizes)
            guess, updates, first = later, updates + due, change if due else first
            if change <= FIXED_POINT_TOLERANCE and updates > 1:
                return later, J
            if not change < DIVERGENCE * least:
                break
            least = min(least, change)
            due = (updates == 1 or first > MEAN_TOLERANCE) and change <= MEAN_UPDATE * first
        raise ConvergenceError("the midpoint iteration does not converge; take a shorter time step")

    def midpoint_rule(
        self, flow: Unknowns, psi: Floats, c: Floats, J: sp.csr_array, w: Floats, loss: Floats, dt: float
    ) -> Unknowns:
        """Return q1 = q0 - dt J_V̄ w̄ minus the filter's loss, c1 = c0 + dt dc/dt, and ψ1, for ψ, c and w̄ at midpoint."""
        q1 = flow.q - dt * (J @ w) - self.energy_neutral(loss, psi)
        c1 = flow.c + dt * self.model.harmonic_rate(w, psi, c)
        return replace(flow, q=q1, c=c1, psi=self.model.stream_function(q1, flow.circulations))

    def mean_vorticity(self, q: Floats, J: sp.csr_array, dt: float, tolerance: float) -> tuple[Floats, Floats]:
        """Return w̄ = B φ₁(-dt J B) q, φ₁(z) = (eᶻ - 1)/z, the mean over the step, and M⁻¹ exp(-dt J B) q, its end."""
        model = self.model
        D, count = model.derivative(J), substeps(float(model.rates(J).max()), dt, SERIES_STEP)
        density, mean = q * model.inverse_areas, np.zeros_like(q)
        smallest = tolerance * float(np.abs(density).max())
        for _ in range(count):
            term, total, average = density, density.copy(), density.copy()
            for order in range(1, 60):
                term = (-dt / count / order) * (D @ model.mass_corrected(term))
                total += term
                average += term / (order + 1)
                if np.abs(term).max() <= smallest:
                    break
            density = total
            mean += average / count
        return model.mass_corrected(mean), density


def _extrapolated(flow: Unknowns) -> Floats:
    """ψ one step ahead, by the polynomial through the n latest: Σ_k (-1)ᵏ (n over k+1) ψ_k, the latest first."""
    history = (flow.psi, *flow.earlier)
    return np.asarray(sum((-1) ** k * math.comb(len(history), k + 1) * psi for k, psi in enumerate(history)))


def _sizes(flow: Unknowns) -> tuple[float, float]:
    """The sizes of ψ and c to which changes are relative: the largest |ψ|, and the root of twice the energy."""
    norm = np.sqrt(max(dot(flow.c, flow.c) - dot(flow.psi, flow.q), 0.0))
    return float(np.abs(flow.psi).max()) or 1.0, norm or 1.0


def _change(one: Unknowns, other: Unknowns, sizes: tuple[float, float]) -> float:
    """The largest relative difference of ψ and c."""
    differences = np.abs(other.psi - one.psi).max(), np.abs(other.c - one.c).max(initial=0.0)
    return float(np.max(np.divide(differences, sizes)))
