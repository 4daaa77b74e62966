"""Flow that keeps what physics keeps: vorticity carried by the midpoint of its own velocity.

q1 = exp(-dt J_V̄ B) q0 with V̄ = ½(V0 + V1): energy is exact for any polynomial in the place of exp, since V̄ crosses no
stream line of its own; circulation is exact, for J sums to zero; enstrophy as far as the series goes.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.errors import ConvergenceError
from geomhw.mesh.arrays import Floats
from geomhw.methods.fluid.scheme import Memory, VorticityScheme

#: Two iterates of the stream function closer than this, relative, are one.
FIXED_POINT_TOLERANCE = 3e-11
MAX_ITERATIONS = 60
#: The series of the exponential ends at this share of its start.
SERIES_TOLERANCE = 1e-12


class ConservativeScheme(VorticityScheme):
    """Exponential midpoint rule: energy and circulation exact, enstrophy but for the filter; reversible without it."""

    def _advance(self, now: Memory, dt: float, alpha: Floats | None) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        """By fixed-point iteration from an extrapolated guess."""
        model = self.model
        psi, c = _extrapolated(now), now["c"]
        size = np.abs(now["psi"]).max() or 1.0
        first = last = np.inf
        for _ in range(MAX_ITERATIONS):
            middle_psi, middle_c = (now["psi"] + psi) / 2, (now["c"] + c) / 2
            J = model.jacobian(middle_psi, middle_c)
            q, mean_w = self._carried(J, now["q"], dt)
            q = self._filtered(q, dt, alpha, middle_psi)
            new_psi = model.stream_function(q, now["around"])
            change = np.abs(new_psi - psi).max() / size
            psi = new_psi
            if len(c):
                new_c = now["c"] + dt * model.harmonic_rate(mean_w, model.velocity(middle_psi, middle_c))
                change = max(change, np.abs(new_c - c).max() / (np.abs(c).max() or 1.0))
                c = new_c
            if change <= FIXED_POINT_TOLERANCE:
                return q, psi, c, J
            first, last = min(first, change), change
            if not np.isfinite(change) or last > 1e3 * first:
                break
        raise ConvergenceError("the midpoint iteration does not converge; take a shorter time step")

    def _carried(self, J: sp.csr_array, q: Floats, dt: float) -> tuple[Floats, Floats]:
        """q after the step, and the mean vorticity w̄ for which it is exactly q - dt J w̄."""
        model = self.model
        parts = model.series_parts(J, dt)
        mean = np.zeros_like(q)
        size = np.abs(q).max(initial=0.0)
        s = dt / parts
        for _ in range(parts):
            term, total, average = q, q.copy(), q.copy()
            for order in range(1, 60):
                term = (-s / order) * (J @ model.vorticity(term))
                total += term
                average += term / (order + 1)  # φ₁(z) = (eᶻ - 1)/z
                if np.abs(term).max(initial=0.0) <= SERIES_TOLERANCE * size:
                    break
            q = total
            mean += average / parts
        return q, model.vorticity(mean)


def _extrapolated(now: Memory) -> Floats:
    """ψ a step ahead, by the polynomial through as many earlier ones as there are."""
    history = [now["psi"], *(now[f"psi_{k}"] for k in (1, 2, 3) if f"psi_{k}" in now)]
    weights = {1: (1,), 2: (2, -1), 3: (3, -3, 1), 4: (4, -6, 4, -1)}[len(history)]
    return np.asarray(sum(weight * psi for weight, psi in zip(weights, history, strict=True)))
