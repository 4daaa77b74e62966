"""What a flow is at one instant, what drives it, and what is measured on it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from geomhw.arrays import Floats, dot
from geomhw.errors import ConvergenceError
from geomhw.flow.tangent_fields import energy
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence

#: Acceleration per face, (m, 3), at a time.
Force = Callable[[float], Floats]


@dataclass(frozen=True)
class FlowState:
    """A flow after so many steps, and a color that it carries, (n,) or (n, k).

    memory: what the scheme that made the state knows of the flow; with the rest, all that it needs to go on to the same
    numbers.
    """

    step: int
    time: float
    color: Floats
    memory: Mapping[str, Floats]


class Scheme(Protocol):
    """A way to step a flow: another one stands beside it by offering the same calls."""

    mesh: TriangleMesh

    def start(self, velocity: Floats, color: Floats) -> FlowState:
        """The state at time 0: the divergence-free part of the velocity."""

    def step(self, state: FlowState, dt: float, force: Force | None) -> FlowState:
        """The state one step of dt later."""

    def velocity(self, state: FlowState) -> Floats:
        """Velocity per face, (m, 3)."""

    def vorticity(self, state: FlowState) -> Floats:
        """Vorticity at vertices, (n,), 1/time, counterclockwise positive."""

    def coefficients(self, state: FlowState) -> Mapping[str, float]:
        """What else the scheme knows of the flow as a whole, by the names of its columns."""


class Diagnostics:
    """Measures states of one mesh: what a flow should keep, and how far it strays."""

    def __init__(self, scheme: Scheme) -> None:
        self._scheme = scheme
        self._mesh = mesh = scheme.mesh
        self._divergence = divergence(mesh)
        self._size = abs(self._divergence)

    def __call__(self, state: FlowState, dt: float) -> dict[str, float]:
        """Step, time, energy ½∫|V|², enstrophy ½∫w², circulation ∫w, relative divergence, Courant number dt |V|max / h.

        The relative divergence is the largest |Div V| over the largest that fields of these lengths could have. After
        these, the scheme's own coefficients.
        """
        V, vorticity, areas = self._scheme.velocity(state), self._scheme.vorticity(state), self._mesh.vertex_areas
        speed = np.linalg.norm(V, axis=1).max()
        most = (self._size @ np.abs(V).ravel()).max()
        return {
            "step": state.step,
            "time": state.time,
            "energy": energy(self._mesh, V) / 2,
            "enstrophy": dot(areas, vorticity**2) / 2,
            "circulation": dot(areas, vorticity),
            "divergence": float(np.abs(self._divergence @ V.ravel()).max() / most) if most else 0.0,
            "courant": float(dt * speed / self._mesh.mean_edge_length),
            "color_min": float(state.color.min()),
            "color_max": float(state.color.max()),
            **self._scheme.coefficients(state),
        }


def require_finite(velocity: Floats, step: int) -> None:
    """ConvergenceError once a flow has blown up."""
    if not np.isfinite(velocity).all():
        raise ConvergenceError(
            f"the flow is no longer finite at step {step}; take a shorter time step or a weaker force"
        )
