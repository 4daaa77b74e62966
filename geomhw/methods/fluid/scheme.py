"""Schemes in vorticity form: what they share."""

from functools import lru_cache

import numpy as np
import scipy.sparse as sp

from geomhw.errors import FieldError
from geomhw.mesh.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.methods.fluid.dye import carry_dye
from geomhw.methods.fluid.state import FlowState, Force
from geomhw.methods.fluid.vorticity import VorticityModel

#: The filter's time τ in units of h/|V|max.
FILTER_TIME = 2.0

Memory = dict[str, Floats]


class VorticityScheme:
    """What the schemes in vorticity form share: state, forces, filter, viscosity, dye; `_advance` is theirs.

    filter: take grid-scale enstrophy away at each step, dq/dt = τ J (I - M⁻¹M_c)² M⁻¹ J w with τ = 2h/|V|max; energy
    and circulation are kept, enstrophy only falls. viscosity: ν, length²/time; vorticity diffuses by backward Euler.
    """

    def __init__(self, mesh: TriangleMesh, filter: bool = True, viscosity: float = 0.0) -> None:
        if not (viscosity >= 0 and np.isfinite(viscosity)):
            raise FieldError(f"the viscosity must be zero or a positive number, not {viscosity}")
        self.mesh = mesh
        self.model = VorticityModel(mesh)
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

    def step(self, state: FlowState, dt: float, force: Force | None) -> FlowState:
        """One step of dt; ConvergenceError where it is too long for the scheme."""
        model, memory = self.model, dict(state.memory)
        if force is not None:
            memory = self._pushed(memory, dt, force(state.time))
        tau = self._filter_time(memory) if self._filter else 0.0
        q, psi, c, J = self._advance(memory, dt, tau)
        if self._viscosity:
            q = self._diffusion(self._viscosity * dt)(q) * model.areas
            psi = model.stream_function(q, memory["around"])
        color = carry_dye(model.derivative(J), state.color, dt)
        past = {"psi_1": memory["psi"]}
        past |= {f"psi_{k + 1}": memory[f"psi_{k}"] for k in (1, 2) if f"psi_{k}" in memory}
        return FlowState(
            state.step + 1, state.time + dt, color, {"q": q, "around": memory["around"], "c": c, "psi": psi, **past}
        )

    def _advance(self, now: Memory, dt: float, tau: float) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        """q, ψ and c at the end of the step, and J of its middle."""
        raise NotImplementedError

    def _pushed(self, memory: Memory, dt: float, acceleration: Floats) -> Memory:
        """The state with dt times the acceleration added to its velocity; earlier ψ are shifted alike."""
        q, around, c = self.model.from_velocity(dt * acceleration)
        push = self.model.stream_function(q, around)
        shifted = {name: psi + push for name, psi in memory.items() if name.startswith("psi")}
        return {"q": memory["q"] + q, "around": memory["around"] + around, "c": memory["c"] + c, **shifted}

    def _filter_time(self, memory: Memory) -> float:
        speed = np.linalg.norm(self.model.velocity(memory["psi"], memory["c"]), axis=1).max()
        return FILTER_TIME * self.mesh.mean_edge_length / float(speed) if speed else 0.0

    def _smoothing(self, J: sp.csr_array, q: Floats, dt: float, tau: float) -> tuple[Floats, Floats]:
        """q filtered for a step, and the mean vorticity that this took from the product with J."""
        parts = self.model.filter_parts(J, dt, tau)
        taken = np.zeros_like(q)
        for _ in range(parts):
            rough = tau * self.model.roughness(J @ self.model.vorticity(q))
            q = q + (dt / parts) * (J @ rough)
            taken += rough / parts
        return q, taken
