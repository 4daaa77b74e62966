"""Flow that keeps what physics keeps: vorticity carried by the midpoint of its own velocity.

q1 = exp(-dt J_V̄ B) q0 with V̄ = ½(V0 + V1): energy is exact for any polynomial in the place of exp, since V̄ crosses no
stream line of its own; circulation is exact, for J sums to zero; enstrophy as far as the series goes.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.errors import ConvergenceError
from geomhw.mesh.arrays import Floats, dot
from geomhw.methods.fluid.scheme import Memory, VorticityScheme

#: Two iterates of the stream function closer than this, relative, are one.
FIXED_POINT_TOLERANCE = 1e-10
MAX_ITERATIONS = 60
#: The series of the exponential ends at this share of its start.
SERIES_TOLERANCE = 1e-11


class ConservativeScheme(VorticityScheme):
    """Exponential midpoint rule: energy and circulation exact, enstrophy but for the filter; reversible without it."""

    def _advance(self, now: Memory, dt: float) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        """By fixed-point iteration on ψ and c from an extrapolated guess."""
        n = len(now["psi"])
        x = np.concatenate([_extrapolated(now), now["c"]])
        flow = np.sqrt(max(dot(now["c"], now["c"]) - dot(now["psi"], now["q"]), 0.0))  # √∫|V|², to which c belongs
        scale = np.repeat([float(np.abs(now["psi"]).max()) or 1.0, flow or 1.0], [n, len(now["c"])])
        least = np.inf
        for _ in range(MAX_ITERATIONS):
            q, J, image = self._image(now, x, dt)
            change = float(np.abs((image - x) / scale).max())
            if change <= FIXED_POINT_TOLERANCE:
                return q, image[:n], image[n:], J
            if not change < 1e3 * least:
                break
            least, x = min(least, change), image
        raise ConvergenceError("the midpoint iteration does not converge; take a shorter time step")

    def _image(self, now: Memory, x: Floats, dt: float) -> tuple[Floats, sp.csr_array, Floats]:
        """q at the end of the step if ψ and c were x there, J of the middle, and the ψ and c of that q."""
        model, n = self.model, len(now["psi"])
        psi, c = (now["psi"] + x[:n]) / 2, (now["c"] + x[n:]) / 2
        J = model.jacobian(psi, c)
        q, mean_q = self._carried(J, now["q"], dt)
        q = self._filtered(q, dt, J, psi)
        image = model.stream_function(q, now["around"])
        if not len(c):
            return q, J, image
        rate = model.harmonic_rate(model.vorticity(mean_q), model.velocity(psi, c))
        return q, J, np.concatenate([image, now["c"] + dt * rate])

    def _carried(self, J: sp.csr_array, q: Floats, dt: float) -> tuple[Floats, Floats]:
        """exp(-dt J B) q, and the mean q̄ = φ₁(-dt J B) q over the step, φ₁(z) = (eᶻ - 1)/z: q1 - q0 = -dt J B q̄."""
        model = self.model
        parts = model.series_parts(J, dt)
        mean = np.zeros_like(q)
        size = np.abs(q).max()
        s = dt / parts
        for _ in range(parts):
            term, total, average = q, q.copy(), q.copy()
            for order in range(1, 60):
                term = (-s / order) * (J @ model.vorticity(term))
                total += term
                average += term / (order + 1)
                if np.abs(term).max() <= SERIES_TOLERANCE * size:
                    break
            q = total
            mean += average / parts
        return q, mean


def _extrapolated(now: Memory) -> Floats:
    """ψ a step ahead, by the polynomial through as many earlier ones as there are."""
    history = [now["psi"], *(now[f"psi_{k}"] for k in (1, 2, 3) if f"psi_{k}" in now)]
    weights = {1: (1,), 2: (2, -1), 3: (3, -3, 1), 4: (4, -6, 4, -1)}[len(history)]
    return np.asarray(sum(weight * psi for weight, psi in zip(weights, history, strict=True)))
