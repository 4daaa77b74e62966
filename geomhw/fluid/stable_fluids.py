"""The course handout's fluid: advect the velocity with the flow map, add the force, project [OATVF, sec. 5.4].

Advection averages the velocity to vertices and back, which damps it at every step, whatever the step: it shows how a
fluid moves, not what it keeps.
"""

from typing import get_args

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.tangent_fields import tangential
from geomhw.fluid.state import FlowState, Force, require_finite
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.averaging import faces_to_vertices, vertices_to_faces
from geomhw.operators.curl import curl_of
from geomhw.operators.directional_derivative import DirectionalDerivative
from geomhw.operators.divergence import divergence
from geomhw.options import Advection
from geomhw.solvers.expm import taylor3


class StableFluidsScheme:
    """Advection, force, projection, in that order; one factorization for all steps.

    advection: ``full``, V ← Π Q T P V, the letter of eq. 8, or ``increment``, V ← V + Π Q (T - I) P V, which averages
    only what changes; P, Q: averages to vertices and to faces, Π: tangential part.
    """

    def __init__(self, mesh: TriangleMesh, advection: Advection = "full") -> None:
        if advection not in get_args(Advection):
            raise FieldError(f"there is no advection '{advection}'; choose from {', '.join(get_args(Advection))}")
        mesh.require_oriented("a flow")
        self.mesh = mesh
        self._advection = advection
        self._decomposition = HelmholtzDecomposition(mesh)
        self._derivative = DirectionalDerivative(mesh)
        self._latest: tuple[Floats, sp.csr_array] | None = None
        self._P, self._Q = faces_to_vertices(mesh), vertices_to_faces(mesh)
        self._divergence = divergence(mesh)

    def start(self, velocity: Floats, color: Floats) -> FlowState:
        """The divergence-free part of the velocity, at time 0."""
        V = self._project(tangential(self.mesh, velocity))
        return FlowState(0, 0.0, np.asarray(color, dtype=float), {"velocity": V})

    def step(self, state: FlowState, dt: float, force: Force | None) -> FlowState:
        """One step of dt; ConvergenceError if the flow blows up."""
        V = self.velocity(state)
        velocity = self._advected(self._along(V), V, dt)
        if force is not None:
            velocity = velocity + dt * force(state.time)
        velocity = self._project(velocity)
        require_finite(velocity, state.step + 1)
        color = taylor3(self._along(velocity), -dt, state.color)
        return FlowState(state.step + 1, state.time + dt, color, {"velocity": velocity})

    def velocity(self, state: FlowState) -> Floats:
        """Velocity per face, (m, 3), free of divergence."""
        return state.memory["velocity"]

    def vorticity(self, state: FlowState) -> Floats:
        """Integrated curl over vertex areas, (n,)."""
        areas = self.mesh.vertex_areas
        q = curl_of(self.mesh, self.velocity(state), self._divergence)
        return np.divide(q, areas, out=np.zeros_like(q), where=areas > 0)

    def coefficients(self, state: FlowState) -> dict[str, float]:
        """None: the scheme knows a velocity and no more."""
        return {}

    def _along(self, velocity: Floats) -> sp.csr_array:
        """D_V of that velocity; the latest is kept, which ends one step and starts the next."""
        if self._latest is None or self._latest[0] is not velocity:
            self._latest = (velocity, self._derivative(velocity))
        return self._latest[1]

    def _advected(self, D: sp.csr_array, velocity: Floats, dt: float) -> Floats:
        """Velocity carried along itself, component by component, and made tangential again."""
        at_vertices = self._P @ velocity
        carried = taylor3(D, -dt, at_vertices)
        if self._advection == "full":
            return tangential(self.mesh, self._Q @ carried)
        return np.asarray(velocity + tangential(self.mesh, self._Q @ (carried - at_vertices)))

    def _project(self, velocity: Floats) -> Floats:
        """The divergence-free part, twice, so that what rounding leaves is rounding of the small."""
        return self._decomposition.project(self._decomposition.project(velocity))
