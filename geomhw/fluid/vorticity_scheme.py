"""What schemes in vorticity form share: their unknowns, forces, viscosity, the filter and the transport of color."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, dot
from geomhw.errors import ArgumentError
from geomhw.flow.passive_scalar import PassiveScalar
from geomhw.fluid.state import FlowState, Force
from geomhw.fluid.vorticity import VorticityModel
from geomhw.mesh.triangle_mesh import TriangleMesh

#: The filter's rate α in units of the rate at which the flow crosses edges (`VorticityModel.rates`).
FILTER_RATE = 8.0
#: Largest α dt of a substep: up to here even the shortest wave, R = 3/4, does not change sign. And most substeps.
STABLE_DAMPING = 1.0
FILTER_SUBSTEPS = 2
#: Earlier stream functions that are kept, for extrapolation.
HISTORY = 4


@dataclass(frozen=True)
class Unknowns:
    """The unknowns of the vorticity equation, and the stream function that they determine.

    q: integrated vorticity, (n,). circulations: along boundary loops, (k,), zero at other unknowns of ψ. c: harmonic
    coefficients, (2g,). psi: stream function, (n,). earlier: stream functions of earlier steps, latest first.
    """

    q: Floats
    circulations: Floats
    c: Floats
    psi: Floats
    earlier: tuple[Floats, ...] = ()

    @classmethod
    def of(cls, variables: Mapping[str, Floats]) -> "Unknowns":
        """From the arrays of a state."""
        earlier = (variables.get(f"psi_{k}") for k in range(1, HISTORY + 1))
        q, circulations, c, psi = (variables[name] for name in ("q", "around", "c", "psi"))
        return cls(q, circulations, c, psi, tuple(before for before in earlier if before is not None))

    def variables(self) -> dict[str, Floats]:
        """As the arrays of a state, under the names that restart files have."""
        earlier = {f"psi_{k}": psi for k, psi in enumerate(self.earlier, 1)}
        return {"q": self.q, "around": self.circulations, "c": self.c, "psi": self.psi, **earlier}


class VorticityScheme:
    """Base of the schemes in vorticity form.

    Parameters
    ----------
    mesh : an oriented manifold of any genus, with or without boundary.
    filter : damp the shortest waves, dq/dt = -M D w + λ M(ψ - mean), with D = R √α R √α R, R = I - M⁻¹M_c, and α about
        12 |V|/h at each vertex. λ is such that no energy is lost. Enstrophy decreases; circulation is conserved.
    viscosity : ν ≥ 0, length²/time; vorticity diffuses by backward Euler.

    Raises
    ------
    MeshError
        If the mesh is not an oriented manifold, or a face has zero area.
    ArgumentError
        If the viscosity is negative or not finite.
    """

    def __init__(self, mesh: TriangleMesh, filter: bool = True, viscosity: float = 0.0) -> None:
        if not (viscosity >= 0 and np.isfinite(viscosity)):
            raise ArgumentError(f"the viscosity must be zero or a positive number, not {viscosity}")
        self.mesh = mesh
        self.model = VorticityModel(mesh)
        self._scalar = PassiveScalar(self.model)
        self._filter = filter
        self._viscosity = viscosity
        self._diffusion = lru_cache(maxsize=2)(self.model.diffusion)

    def start(self, velocity: Floats, color: ArrayLike | None = None) -> FlowState:
        """Return the state at time 0 with the divergence-free part of a velocity, (m, 3); color zero by default."""
        return self._initial(*self.model.from_velocity(velocity), color)

    def from_vorticity(
        self,
        w: ArrayLike,
        color: ArrayLike | None = None,
        *,
        circulations: ArrayLike | None = None,
        harmonic: ArrayLike | None = None,
    ) -> FlowState:
        """Return the state at time 0 with a given vorticity.

        Parameters
        ----------
        w : (n,) array, units 1/time. Its mean on each component is changed to satisfy Stokes' theorem.
        color : (n,) or (n, k) array, by default zero.
        circulations : (l,) array, length²/time, along the boundary loops in the order of `coefficients`; by default
            zero.
        harmonic : (2g,) array, length²/time, coefficients of ``model.harmonic``; by default zero.
        """
        return self._initial(*self.model.from_vorticity(w, circulations, harmonic), color)

    def _initial(self, q: Floats, circulations: Floats, c: Floats, color: ArrayLike | None) -> FlowState:
        unknowns = Unknowns(q, circulations, c, self.model.stream_function(q, circulations))
        return FlowState.initial(self.mesh, color, unknowns.variables())

    def step(self, state: FlowState, dt: float, force: Force | None = None) -> FlowState:
        """Add the force, advect and diffuse the vorticity, advect the color; ConvergenceError if dt is too long."""
        flow = Unknowns.of(state.variables)
        if force is not None:
            flow = self.add_force(flow, dt * force(state.time))
        later, J = self.advect(flow, dt)
        if self._viscosity:
            later = self.diffuse(later, dt)
        later = replace(later, earlier=(flow.psi, *flow.earlier)[:HISTORY])
        color = self._scalar.advect(self.model.derivative(J), state.color, dt)
        return FlowState(state.step + 1, state.time + dt, color, later.variables())

    def advect(self, flow: Unknowns, dt: float) -> tuple[Unknowns, sp.csr_array]:
        """Return the unknowns at the end of the step, and J of its middle."""
        raise NotImplementedError

    def add_force(self, flow: Unknowns, impulse: Floats) -> Unknowns:
        """Add an impulse, (m, 3), dt times the acceleration, to the velocity; earlier ψ are shifted with the latest."""
        q, circulations, c = self.model.from_velocity(impulse)
        psi = self.model.stream_function(q, circulations)
        earlier = tuple(before + psi for before in flow.earlier)
        return Unknowns(flow.q + q, flow.circulations + circulations, flow.c + c, flow.psi + psi, earlier)

    def diffuse(self, flow: Unknowns, dt: float) -> Unknowns:
        """Diffuse the vorticity by a step of backward Euler."""
        q = self._diffusion(self._viscosity * dt)(flow.q) * self.model.areas
        return replace(flow, q=q, psi=self.model.stream_function(q, flow.circulations))

    def filter_loss(self, density: Floats, dt: float, J: sp.csr_array) -> Floats:
        """Return what the filter subtracts in a step from q = M density, (n,), before energy is restored; sum zero."""
        model = self.model
        if not self._filter:
            return np.zeros_like(density)
        alpha = FILTER_RATE * model.rates(J)
        substeps = int(np.clip(np.ceil(dt * alpha.max() / STABLE_DAMPING), 1, FILTER_SUBSTEPS))
        s = dt / substeps
        alpha = np.minimum(alpha, STABLE_DAMPING / s)
        damped = density
        for _ in range(substeps):
            damped = damped - s * model.hyperdiffusion(model.mass_corrected(damped), alpha)
        return np.asarray(model.areas * (density - damped))

    def energy_neutral(self, dq: Floats, psi: Floats) -> Floats:
        """Return dq plus the multiple of M(ψ - mean) with which ψᵀdq = 0: no energy is lost if ψ is the step's mean."""
        gain = self.model.without_mean(self.model.areas * psi)
        norm = dot(psi, gain)
        return dq - (dot(psi, dq) / norm) * gain if norm else dq

    def velocity(self, state: FlowState) -> Floats:
        """Return n x ∇ψ + Σ c_k h_k per face, (m, 3)."""
        return self.model.velocity(state.variables["psi"], state.variables["c"])

    def vorticity(self, state: FlowState) -> Floats:
        """Return w = B q, (n,), units 1/time."""
        return self.model.vorticity(state.variables["q"])

    def coefficients(self, state: FlowState) -> dict[str, float]:
        """Return c_k as ``harmonic_k`` and the circulation along each boundary loop as ``loop_k``, length²/time."""
        flow = Unknowns.of(state.variables)
        named = {"harmonic": flow.c, "loop": flow.circulations[self.model.loops]}
        return {f"{name}_{k}": float(value) for name, values in named.items() for k, value in enumerate(values)}
