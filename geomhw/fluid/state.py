"""The state of a flow at one time, the interface of schemes that step it, and diagnostics."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, dot
from geomhw.flow.tangent_fields import energy
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence

#: Acceleration per face, (m, 3), at a time.
Force = Callable[[float], Floats]


@dataclass(frozen=True)
class FlowState:
    """A flow at one time and the color that it transports; make one by `Scheme.start` or `Scheme.from_vorticity`.

    Attributes
    ----------
    step : number of steps since the start.
    time : time since the start.
    color : (n,) or (n, k) array.
    variables : arrays by name, all that the scheme of this state needs to continue. Their names depend on the scheme;
        read a state by `Scheme.velocity`, `Scheme.vorticity` and `Scheme.coefficients`.
    """

    step: int
    time: float
    color: Floats
    variables: Mapping[str, Floats]

    @classmethod
    def initial(cls, mesh: TriangleMesh, color: ArrayLike | None, variables: Mapping[str, Floats]) -> "FlowState":
        """Return the state at time 0; a color of None is zero."""
        values = np.zeros(mesh.n_vertices) if color is None else np.asarray(color, dtype=float)
        return cls(0, 0.0, values, variables)


class Scheme(Protocol):
    """Time stepping of incompressible flow on one mesh."""

    mesh: TriangleMesh

    def start(self, velocity: Floats, color: ArrayLike | None = None) -> FlowState:
        """Return the state at time 0 with the divergence-free part of a velocity, (m, 3); color zero by default."""

    def from_vorticity(self, w: ArrayLike, color: ArrayLike | None = None) -> FlowState:
        """Return the state at time 0 with a vorticity, (n,), less its mean on each component; color zero by default."""

    def step(self, state: FlowState, dt: float, force: Force | None = None) -> FlowState:
        """Return the state one step of dt later; ConvergenceError if dt is too long for the scheme."""

    def velocity(self, state: FlowState) -> Floats:
        """Return the velocity per face, (m, 3)."""

    def vorticity(self, state: FlowState) -> Floats:
        """Return the vorticity at vertices, (n,), 1/time, positive counterclockwise seen from outside."""

    def coefficients(self, state: FlowState) -> Mapping[str, float]:
        """Return the numbers by name that the scheme has besides, such as circulations along boundary loops."""


class Diagnostics:
    """Measure states of one scheme: conserved quantities, divergence and Courant number.

    Examples
    --------
    >>> from geomhw.fluid import scheme_of
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(4)
    >>> scheme = scheme_of(mesh, "conservative")
    >>> rotation = scheme.from_vorticity(2 * mesh.vertices[:, 2])
    >>> row = Diagnostics(scheme)(rotation, dt=0.1)
    >>> round(row["energy"], 2)  # on the smooth sphere 4π/3 = 4.19
    4.17
    """

    def __init__(self, scheme: Scheme) -> None:
        self._scheme, self._mesh = scheme, scheme.mesh
        self._divergence = divergence(scheme.mesh)
        self._absolute = abs(self._divergence)

    def __call__(self, state: FlowState, dt: float) -> dict[str, float]:
        """Return a row of diagnostics.

        Parameters
        ----------
        dt : the time step, for the Courant number.

        Returns
        -------
        Step, time, energy ½∫|V|², enstrophy ½∫w², circulation ∫w, divergence, the Courant number dt |V|max / h, the
        range of the color, and the scheme's coefficients. Divergence is the largest |Div V| relative to the largest
        value possible for vectors of these components.
        """
        V, vorticity, areas = self._scheme.velocity(state), self._scheme.vorticity(state), self._mesh.vertex_areas
        speed = np.linalg.norm(V, axis=1).max()
        bound = (self._absolute @ np.abs(V).ravel()).max()
        return {
            "step": state.step,
            "time": state.time,
            "energy": energy(self._mesh, V) / 2,
            "enstrophy": dot(areas, vorticity**2) / 2,
            "circulation": dot(areas, vorticity),
            "divergence": float(np.abs(self._divergence @ V.ravel()).max() / bound) if bound else 0.0,
            "courant": float(dt * speed / self._mesh.mean_edge_length),
            "color_min": float(state.color.min()),
            "color_max": float(state.color.max()),
            **self._scheme.coefficients(state),
        }
