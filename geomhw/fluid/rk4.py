"""RK4: classical Runge-Kutta on the vorticity equation, with four Poisson solves per step."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ConvergenceError
from geomhw.fluid.vorticity_scheme import Unknowns, VorticityScheme

#: Largest step times rate (`VorticityModel.rates`) at which waves do not grow: a Courant number of 1.5 on even meshes.
STABLE = 2.2


class RK4Scheme(VorticityScheme):
    """Fourth-order Runge-Kutta on dq/dt = -J_V B q and dc/dt; energy drifts with dt⁵ per step.

    A step beyond a Courant number of about 1.5 raises ConvergenceError. The loss of the filter is computed at the start
    of a step and applied evenly. Parameters and errors are those of `VorticityScheme`.
    """

    def advect(self, flow: Unknowns, dt: float) -> tuple[Unknowns, sp.csr_array]:
        """Combine the rates at the start, twice at the middle, and at the end of the step."""
        model, n = self.model, len(flow.q)
        J1 = model.jacobian(flow.psi, flow.c)
        if not dt * model.rates(J1).max() <= STABLE:
            raise ConvergenceError(f"a step of {dt:g} is too long for RK4; take a shorter one")
        loss = self.filter_loss(flow.q * model.inverse_areas, dt, J1) / dt
        y = np.concatenate([flow.q, flow.c])

        def after(s: float, k: Floats) -> Unknowns:
            """The unknowns y + s k."""
            q, c = np.split(y + s * k, [n])
            return replace(flow, q=q, c=c, psi=model.stream_function(q, flow.circulations))

        def stage(at: Unknowns) -> tuple[Floats, sp.csr_array]:
            """dq/dt and dc/dt, and J."""
            J, w = model.jacobian(at.psi, at.c), model.vorticity(at.q)
            dq = -(J @ w) - self.energy_neutral(loss, at.psi)
            return np.concatenate([dq, model.harmonic_rate(w, at.psi, at.c)]), J

        k1, _ = stage(flow)
        k2, _ = stage(after(0.5 * dt, k1))
        k3, J3 = stage(after(0.5 * dt, k2))
        k4, _ = stage(after(dt, k3))
        later = after(dt, (1 / 6) * k1 + (1 / 3) * k2 + (1 / 3) * k3 + (1 / 6) * k4)
        if not np.isfinite(later.q).all():
            raise ConvergenceError("the flow is no longer finite; take a shorter time step")
        return later, J3
