"""Bounds that conserved quantities of a flow must keep, from step to step."""

import math
from collections.abc import Mapping

import numpy as np

from geomhw.arrays import dot
from geomhw.errors import ConvergenceError
from geomhw.flow.advection import ColorRange
from geomhw.flow.tangent_fields import energy
from geomhw.fluid.state import FlowState, Force, Scheme

#: Share by which a quantity exceeds its bound before it is reported.
NOTICED = 0.01
#: A run stops if a quantity is this many times its bound.
RUNAWAY = {"energy": 2.0, "enstrophy": 10.0}


class ConservationCheck:
    """Compare energy, enstrophy and color of a run with their bounds.

    No scheme may gain energy but by the force: the square root of 2E grows by at most dt times the L2 norm of the
    force. In vorticity form, and without a force, enstrophy does not grow either. The color keeps its range; it is
    recorded if it does not.

    Parameters
    ----------
    scheme, state : the scheme, and the state at which the run starts.
    force : the force of the run, if there is one.
    first, dt : for a run that resumes, the diagnostics of step 0, and the time step of the earlier steps.

    Attributes
    ----------
    excess : dict
        By quantity, the largest share by which it exceeded its bound.
    since : dict
        By quantity, the first step at which this share was above `NOTICED`.
    color : ColorRange

    References
    ----------
    Elcott, Tong, Kanso, Schröder, Desbrun: Stable, Circulation-Preserving, Simplicial Fluids, 2007.
    """

    def __init__(
        self,
        scheme: Scheme,
        state: FlowState,
        force: Force | None = None,
        first: Mapping[str, float] | None = None,
        dt: float = 0.0,
    ) -> None:
        self._scheme, self._force = scheme, force
        self._bounds = self._measure(state)
        ends = (first["color_min"], first["color_max"]) if first else (state.color.min(), state.color.max())
        self.color = ColorRange(np.array(ends), math.inf)
        if first:
            self._bounds = {name: first[name] for name in self._bounds}
            for step in range(state.step):
                self._allow_force(step * dt, dt)
        self.excess: dict[str, float] = {}
        self.since: dict[str, int] = {}

    def check(self, state: FlowState, dt: float) -> None:
        """Compare the state after a step of dt; ConvergenceError if a quantity runs away."""
        self.color.check(state.color, state.step)
        self._allow_force(state.time - dt, dt)
        for name, value in self._measure(state).items():
            ratio = value / bound if (bound := self._bounds[name]) else 1.0
            if not ratio <= RUNAWAY[name]:
                raise ConvergenceError(
                    f"the flow gains {name} without a cause: at step {state.step} it is {ratio:.3g} times as large as "
                    "the start and the force allow; take a shorter time step, or the conservative scheme"
                )
            if ratio - 1 > NOTICED:
                self.since.setdefault(name, state.step)
                self.excess[name] = max(ratio - 1, self.excess.get(name, 0.0))

    def _allow_force(self, time: float, dt: float) -> None:
        """Raise the bound of energy by a step of dt under the force at a time."""
        if self._force:
            norm = math.sqrt(energy(self._scheme.mesh, self._force(time)))
            self._bounds["energy"] = (math.sqrt(2 * self._bounds["energy"]) + dt * norm) ** 2 / 2

    def _measure(self, state: FlowState) -> dict[str, float]:
        """Energy and, where it is bounded, enstrophy."""
        mesh = self._scheme.mesh
        measured = {"energy": energy(mesh, self._scheme.velocity(state)) / 2}
        if self._force is None and "q" in state.variables:
            measured["enstrophy"] = dot(mesh.vertex_areas, self._scheme.vorticity(state) ** 2) / 2
        return measured
