"""RK4: classical Runge-Kutta on the vorticity equation, four Poisson solves a step."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError
from geomhw.fluid.vorticity_scheme import Memory, VorticityScheme

#: Largest step times rate (`VorticityModel.rates`) at which waves do not grow: a Courant number of 1.5 on even meshes.
STABLE = 2.2


class RK4Scheme(VorticityScheme):
    """dq/dt = -J_V B q and dc/dt by RK4, drift of order dt⁵; ConvergenceError for steps that are not stable.

    What the filter takes is found at the start of a step, and taken evenly, at no cost in energy at any stage.
    """

    def _advance(self, now: Memory, dt: float) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        model, q, c, psi = self.model, now["q"], now["c"], now["psi"]
        middle = model.jacobian(psi, c)
        if not dt * model.rates(middle).max() <= STABLE:
            raise ConvergenceError(f"a step of {dt:g} is too long for RK4; take a shorter one")
        loss = self._smoothed_away(q * model.inverse_areas, dt, middle) / dt
        dq, dc = np.zeros_like(q), np.zeros_like(c)
        total_q, total_c = np.zeros_like(q), np.zeros_like(c)
        for weight, reach in ((1 / 6, 0.0), (1 / 3, 0.5), (1 / 3, 0.5), (1 / 6, 1.0)):
            at_q, at_c = q + reach * dt * dq, c + reach * dt * dc
            if reach:
                psi = model.stream_function(at_q, now["around"])
            J = model.jacobian(psi, at_c) if reach else middle
            w = model.vorticity(at_q)
            dq = -(J @ w) - self._neutral(loss, psi)
            dc = model.harmonic_rate(w, model.velocity(psi, at_c)) if len(c) else dc
            total_q += weight * dq
            total_c += weight * dc
            middle = J if reach == 0.5 else middle
        q, c = q + dt * total_q, c + dt * total_c
        if not np.isfinite(q).all():
            raise ConvergenceError("the flow is no longer finite; take a shorter time step")
        return q, model.stream_function(q, now["around"]), c, middle
