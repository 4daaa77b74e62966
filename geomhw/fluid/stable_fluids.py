"""The course handout's fluid: advect the velocity by the flow map, add the force, project [OATVF, sec. 5.4]."""

from typing import get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, ConvergenceError
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.tangent_fields import tangential
from geomhw.fluid.state import FlowState, Force
from geomhw.fluid.vorticity import VorticityModel
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.averaging import faces_to_vertices, vertices_to_faces
from geomhw.operators.curl import curl_of
from geomhw.operators.directional_derivative import DirectionalDerivative
from geomhw.operators.divergence import divergence
from geomhw.options import Advection
from geomhw.solvers.expm import taylor3


class StableFluidsScheme:
    """Advection, force and projection, in that order, with one factorization for all steps.

    Advection averages the velocity to vertices and back. This damps the flow at every step, however short.

    Parameters
    ----------
    mesh : an oriented manifold.
    advection : ``full``, V ← Π Q T P V with T = exp(-dt D_V) in three terms, or ``increment``, V ← V + Π Q (T - I) P V,
        which averages only the change. P and Q average to vertices and to faces; Π is the tangential part.

    Raises
    ------
    MeshError
        If the mesh is not an oriented manifold, or a face has zero area.
    ArgumentError
        If the advection is unknown.
    """

    def __init__(self, mesh: TriangleMesh, advection: Advection = "full") -> None:
        if advection not in get_args(Advection):
            raise ArgumentError(f"there is no advection '{advection}'; choose from {', '.join(get_args(Advection))}")
        mesh.require_oriented("a flow")
        self.mesh = mesh
        self._advection = advection
        self._decomposition = HelmholtzDecomposition(mesh)
        self._derivative = DirectionalDerivative(mesh)
        self._latest: tuple[Floats, sp.csr_array] | None = None
        self._P, self._Q = faces_to_vertices(mesh), vertices_to_faces(mesh)
        self._divergence = divergence(mesh)

    def start(self, velocity: Floats, color: ArrayLike | None = None) -> FlowState:
        """Return the state at time 0 with the divergence-free part of a velocity, (m, 3); color zero by default."""
        return FlowState.initial(self.mesh, color, {"velocity": self.project(tangential(self.mesh, velocity))})

    def from_vorticity(self, w: ArrayLike, color: ArrayLike | None = None) -> FlowState:
        """Return the state at time 0 with a vorticity, (n,), less its mean on each component; color zero by default."""
        model = VorticityModel(self.mesh)
        return self.start(model.induced_velocity(model.from_vorticity(w)[0]), color)

    def step(self, state: FlowState, dt: float, force: Force | None = None) -> FlowState:
        """Return the state one step of dt later; ConvergenceError if the flow is no longer finite."""
        V = self.advect(self.velocity(state), dt)
        V = self.add_force(V, dt, force, state.time)
        V = self.project(V)
        if not np.isfinite(V).all():
            raise ConvergenceError(
                f"the flow is no longer finite at step {state.step + 1}; take a shorter time step or a weaker force"
            )
        color = taylor3(self._D(V), -dt, state.color)
        return FlowState(state.step + 1, state.time + dt, color, {"velocity": V})

    def advect(self, V: Floats, dt: float) -> Floats:
        """Advect V by itself, component by component at vertices, and make it tangential again."""
        at_vertices = self._P @ V
        advected = taylor3(self._D(V), -dt, at_vertices)
        if self._advection == "full":
            return tangential(self.mesh, self._Q @ advected)
        return np.asarray(V + tangential(self.mesh, self._Q @ (advected - at_vertices)))

    def add_force(self, V: Floats, dt: float, force: Force | None, time: float) -> Floats:
        """Return V + dt F."""
        return V if force is None else V + dt * force(time)

    def project(self, V: Floats) -> Floats:
        """Return the divergence-free part of V; the second projection removes the rounding errors of the first."""
        return self._decomposition.project(self._decomposition.project(V))

    def velocity(self, state: FlowState) -> Floats:
        """Return the velocity per face, (m, 3), free of divergence."""
        return state.variables["velocity"]

    def vorticity(self, state: FlowState) -> Floats:
        """Return the integrated curl over vertex areas, (n,)."""
        areas = self.mesh.vertex_areas
        q = curl_of(self.mesh, self.velocity(state), self._divergence)
        return np.divide(q, areas, out=np.zeros_like(q), where=areas > 0)

    def coefficients(self, state: FlowState) -> dict[str, float]:
        """Return an empty dictionary."""
        return {}

    def _D(self, V: Floats) -> sp.csr_array:
        """D_V; the latest is kept, since the color and the next step use the same."""
        if self._latest is None or self._latest[0] is not V:
            self._latest = (V, self._derivative(V))
        return self._latest[1]
