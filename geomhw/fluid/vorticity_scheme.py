"""Schemes in vorticity form: what they share."""

from functools import lru_cache

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, dot
from geomhw.errors import FieldError
from geomhw.fluid.passive_scalar import PassiveScalar
from geomhw.fluid.state import FlowState, Force
from geomhw.fluid.vorticity import VorticityModel
from geomhw.mesh.triangle_mesh import TriangleMesh

#: The filter's rate α in units of the rate at which the flow crosses edges (`VorticityModel.rates`).
FILTER_RATE = 8.0
#: The largest α dt of a part at which even the finest wave, K = 3/4, does not change sign; and how many parts at most.
STABLE_DAMPING = 1.0
FILTER_PARTS = 2

Memory = dict[str, Floats]


class VorticityScheme:
    """What the schemes in vorticity form share: state, forces, filter, viscosity, dye; `_advance` is theirs.

    filter: damp what the mesh cannot carry, dq/dt = -D w + λ M(ψ - mean), D = K M⁻¹ √α K √α M⁻¹ K, K = M - M_c, and α
    some 12 |V|/h at each vertex; λ is such that no energy is lost. Only the finest waves decay: enstrophy falls, and
    circulation stays. viscosity: ν, length²/time; vorticity diffuses by backward Euler.
    """

    def __init__(self, mesh: TriangleMesh, filter: bool = True, viscosity: float = 0.0) -> None:
        if not (viscosity >= 0 and np.isfinite(viscosity)):
            raise FieldError(f"the viscosity must be zero or a positive number, not {viscosity}")
        self.mesh = mesh
        self.model = VorticityModel(mesh)
        self._dye = PassiveScalar(self.model)
        self._filter = filter
        self._viscosity = viscosity
        self._diffusion = lru_cache(maxsize=2)(self.model.diffusion)

    def start(self, velocity: Floats, color: Floats) -> FlowState:
        """The divergence-free part of the velocity, at time 0."""
        return self.from_vorticity(*self.model.from_velocity(velocity), color)

    def from_vorticity(self, q: Floats, around: Floats, c: Floats, color: Floats) -> FlowState:
        """State of that integrated vorticity, (n,), loop circulations and harmonic coefficients, at time 0."""
        memory = {"q": q, "around": around, "c": c, "psi": self.model.stream_function(q, around)}
        return FlowState(0, 0.0, np.asarray(color, dtype=float), memory)

    def velocity(self, state: FlowState) -> Floats:
        """n x ∇ψ + Σ c_k h_k per face, (m, 3)."""
        return self.model.velocity(state.memory["psi"], state.memory["c"])

    def vorticity(self, state: FlowState) -> Floats:
        """B q, (n,)."""
        return self.model.vorticity(state.memory["q"])

    def coefficients(self, state: FlowState) -> dict[str, float]:
        """c_k of the harmonic fields, harmonic_k, and the circulation round boundary loops, loop_k; length²/time."""
        loops = state.memory["around"][self.model.loops]
        named = {"harmonic": state.memory["c"], "loop": loops}
        return {f"{name}_{k}": float(value) for name, values in named.items() for k, value in enumerate(values)}

    def step(self, state: FlowState, dt: float, force: Force | None) -> FlowState:
        """One step of dt; ConvergenceError where it is too long for the scheme."""
        model, memory = self.model, dict(state.memory)
        if force is not None:
            memory = self._pushed(memory, dt, force(state.time))
        q, psi, c, J = self._advance(memory, dt)
        if self._viscosity:
            q = self._diffusion(self._viscosity * dt)(q) * model.areas
            psi = model.stream_function(q, memory["around"])
        color = self._dye.carry(model.derivative(J), state.color, dt)
        past = {"psi_1": memory["psi"]}
        past |= {f"psi_{k + 1}": memory[f"psi_{k}"] for k in (1, 2, 3) if f"psi_{k}" in memory}
        return FlowState(
            state.step + 1, state.time + dt, color, {"q": q, "around": memory["around"], "c": c, "psi": psi, **past}
        )

    def _advance(self, now: Memory, dt: float) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        """q, ψ and c at the end of the step, and J of its middle."""
        raise NotImplementedError

    def _pushed(self, memory: Memory, dt: float, acceleration: Floats) -> Memory:
        """The state with dt times the acceleration added to its velocity; earlier ψ are shifted alike."""
        q, around, c = self.model.from_velocity(dt * acceleration)
        push = self.model.stream_function(q, around)
        shifted = {name: psi + push for name, psi in memory.items() if name.startswith("psi")}
        return {"q": memory["q"] + q, "around": memory["around"] + around, "c": memory["c"] + c, **shifted}

    def _smoothed_away(self, density: Floats, dt: float, J: sp.csr_array) -> Floats:
        """What the filter takes in a step from q = M density, (n,), before energy is given back; it sums to zero."""
        model = self.model
        if not self._filter:
            return np.zeros_like(density)
        alpha = FILTER_RATE * model.rates(J)
        parts = int(np.clip(np.ceil(dt * alpha.max() / STABLE_DAMPING), 1, FILTER_PARTS))
        s = dt / parts
        alpha = np.minimum(alpha, STABLE_DAMPING / s)
        left = density
        for _ in range(parts):
            left = left - s * model.roughness(model.sharpened(left), alpha)
        return np.asarray(model.areas * (density - left))

    def _neutral(self, dq: Floats, psi: Floats) -> Floats:
        """dq and so much of M(ψ - mean) that no energy is lost where ψ is the mean of its step: ψᵀdq = 0."""
        lever = self.model.centered(self.model.areas * psi)
        arm = dot(psi, lever)
        return dq - (dot(psi, dq) / arm) * lever if arm else dq
