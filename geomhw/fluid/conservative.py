"""Flow that keeps what physics keeps: vorticity carried by the midpoint of its own velocity.

q1 = exp(-dt J_V̄ B) q0 with V̄ = ½(V0 + V1): circulation is exact, for J sums to zero; enstrophy as far as the series
goes. In the form q1 = q0 - dt J_V̄ w̄ with w̄ = B φ₁(-dt J_V̄ B) q0 energy is exact for any w̄, since V̄ crosses no stream
line of its own. So w̄ follows guesses of V̄ until they are good, and V̄ alone is then iterated to the last digit.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, dot
from geomhw.errors import ConvergenceError
from geomhw.fluid.vorticity_scheme import Memory, VorticityScheme

#: Two iterates of the stream function closer than this, relative, are one.
FIXED_POINT_TOLERANCE = 1e-10
MAX_ITERATIONS = 60
#: A guess so close to what comes of it, relative, has given w̄ well enough.
GUESS_TOLERANCE = 1e-8
#: A worse guess, and the first, is left as soon as iteration has brought it this much nearer.
GUESS_GAIN = 0.1
#: The series of the exponential ends at this share of its start: for the first guess, and for better ones.
SERIES_TOLERANCES = (1e-6, 1e-9)


class ConservativeScheme(VorticityScheme):
    """Exponential midpoint rule: energy and circulation exact, enstrophy but for the filter; reversible without it."""

    def _advance(self, now: Memory, dt: float) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        """By fixed-point iteration on ψ and c from an extrapolated guess."""
        n = len(now["psi"])
        before = np.concatenate([now["psi"], now["c"]])
        after = np.concatenate([_extrapolated(now), now["c"]])
        flow = np.sqrt(max(dot(now["c"], now["c"]) - dot(now["psi"], now["q"]), 0.0))  # √∫|V|², to which c belongs
        scale = np.repeat([float(np.abs(now["psi"]).max()) or 1.0, flow or 1.0], [n, len(now["c"])])
        guesses, anew, error, least = 0, True, np.inf, np.inf
        for _ in range(MAX_ITERATIONS):
            middle = (before + after) / 2
            J = self.model.jacobian(middle[:n], middle[n:])
            if anew:
                w, end = self._carried(J, now["q"], dt, SERIES_TOLERANCES[guesses > 0])
                if not guesses:
                    loss = self._smoothed_away(end, dt, J)
            q, image = self._image(now, middle, J, w, loss, dt)
            change = float(np.abs((image - after) / scale).max())
            guesses, error, after = guesses + anew, change if anew else error, image
            if change <= FIXED_POINT_TOLERANCE and guesses > 1:
                return q, image[:n], image[n:], J
            if not change < 1e3 * least:
                break
            least = min(least, change)
            anew = (guesses == 1 or error > GUESS_TOLERANCE) and change <= GUESS_GAIN * error
        raise ConvergenceError("the midpoint iteration does not converge; take a shorter time step")

    def _image(
        self, now: Memory, middle: Floats, J: sp.csr_array, w: Floats, loss: Floats, dt: float
    ) -> tuple[Floats, Floats]:
        """q at the end of the step if ψ and c, and J with them, are those of its middle; and the ψ and c of that q."""
        model, n = self.model, len(now["psi"])
        psi, c = middle[:n], middle[n:]
        q = now["q"] - dt * (J @ w) - self._neutral(loss, psi)
        image = model.stream_function(q, now["around"])
        if not len(c):
            return q, image
        return q, np.concatenate([image, now["c"] + dt * model.harmonic_rate(w, model.velocity(psi, c))])

    def _carried(self, J: sp.csr_array, q: Floats, dt: float, tolerance: float) -> tuple[Floats, Floats]:
        """w̄ = B φ₁(-dt J B) q with φ₁(z) = (eᶻ - 1)/z, the mean vorticity over the step, and M⁻¹ exp(-dt J B) q."""
        model = self.model
        D = model.derivative(J)
        parts = model.series_parts(J, dt)
        density = q * model.inverse_areas
        mean = np.zeros_like(q)
        enough = tolerance * float(np.abs(density).max())
        for _ in range(parts):
            term, total, average = density, density.copy(), density.copy()
            for order in range(1, 60):
                term = (-dt / parts / order) * (D @ model.sharpened(term))
                total += term
                average += term / (order + 1)
                if np.abs(term).max() <= enough:
                    break
            density = total
            mean += average / parts
        return model.sharpened(mean), density


def _extrapolated(now: Memory) -> Floats:
    """ψ a step ahead, by the polynomial through as many earlier ones as there are."""
    history = [now["psi"], *(now[f"psi_{k}"] for k in (1, 2, 3, 4) if f"psi_{k}" in now)]
    weights = {1: (1,), 2: (2, -1), 3: (3, -3, 1), 4: (4, -6, 4, -1), 5: (5, -10, 10, -5, 1)}[len(history)]
    return np.asarray(sum(weight * psi for weight, psi in zip(weights, history, strict=True)))
