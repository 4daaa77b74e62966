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

#: The filter's rate α in units of |V|/h, and the largest α dt, at which the finest waves still decay evenly.
FILTER_RATE = 2.0
MOST_DAMPING = 2.0

Memory = dict[str, Floats]


class VorticityScheme:
    """What the schemes in vorticity form share: state, forces, filter, viscosity, dye; `_advance` is theirs.

    filter: damp what the mesh cannot carry, dq/dt = -D w + λ (q - mean), where D = K M⁻¹K (α/M) K M⁻¹K with K = M - M_c
    and α = 2|V|/h at each vertex, and λ is such that no energy is lost: only the finest waves decay, enstrophy falls,
    circulation stays. viscosity: ν, length²/time; vorticity diffuses by backward Euler.
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
        alpha = self._filter_rate(memory) if self._filter else None
        q, psi, c, J = self._advance(memory, dt, alpha)
        if self._viscosity:
            q = self._diffusion(self._viscosity * dt)(q) * model.areas
            psi = model.stream_function(q, memory["around"])
        color = carry_dye(model.derivative(J), state.color, dt)
        past = {"psi_1": memory["psi"]}
        past |= {f"psi_{k + 1}": memory[f"psi_{k}"] for k in (1, 2) if f"psi_{k}" in memory}
        return FlowState(
            state.step + 1, state.time + dt, color, {"q": q, "around": memory["around"], "c": c, "psi": psi, **past}
        )

    def _advance(self, now: Memory, dt: float, alpha: Floats | None) -> tuple[Floats, Floats, Floats, sp.csr_array]:
        """q, ψ and c at the end of the step, and J of its middle."""
        raise NotImplementedError

    def _pushed(self, memory: Memory, dt: float, acceleration: Floats) -> Memory:
        """The state with dt times the acceleration added to its velocity; earlier ψ are shifted alike."""
        q, around, c = self.model.from_velocity(dt * acceleration)
        push = self.model.stream_function(q, around)
        shifted = {name: psi + push for name, psi in memory.items() if name.startswith("psi")}
        return {"q": memory["q"] + q, "around": memory["around"] + around, "c": memory["c"] + c, **shifted}

    def _filter_rate(self, memory: Memory) -> Floats:
        """α at each vertex, (n,): how many edges the flow there crosses a unit of time, times `FILTER_RATE`."""
        speed = self.model.speed(self.model.velocity(memory["psi"], memory["c"]))
        return np.asarray(FILTER_RATE * speed * self.model.inverse_edge_lengths)

    def _filtered(self, q: Floats, dt: float, alpha: Floats | None, psi: Floats) -> Floats:
        """q after the filter has worked for a step, at no cost in energy while the mean stream function is ψ."""
        if alpha is None:
            return q
        damping = self.model.roughness(self.model.vorticity(q), np.minimum(alpha, MOST_DAMPING / dt))
        lever = self.model.centered(q)
        arm = float(psi @ lever)
        gain = float(psi @ damping) / arm if arm else 0.0
        return np.asarray(q - dt * (damping - gain * lever))
