"""Pushforward of vector fields, 1-forms and functions by the flow of a tangent field; parallel transport along it.

Each solves a linear equation in time, so that the pushforward is the exponential of a sparse operator [OATVF]:

    functions        f' = -D_U f
    vector fields    V' = -[U, V] = -(P D_U V - ∇V U with V and U exchanged)
    1-forms          w' = -(P D_U w + (∇U)ᵀ w)
    parallel         V' = -∇_U V = -P D_U V
"""

from collections.abc import Iterator
from typing import get_args

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.flow.bounded_flow import inflow_vertices
from geomhw.flow.field_derivatives import FieldDerivatives
from geomhw.flow.flow_map import vertex_functions
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.flow.mass_correction import MassCorrection
from geomhw.flow.passive_scalar import PassiveScalar
from geomhw.flow.tangent_fields import energy, tangential
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import directional_derivative
from geomhw.options import TransportName
from geomhw.solvers.expm import expm

#: A field whose curl-free part has at most this share of the energy is divergence-free up to rounding ...
SOLENOIDAL = 1e-12
#: ... and a flow preserves areas, up to the error of its samples, if the share is at most this.
AREA_PRESERVING = 1e-3


class Pushforward:
    """The flow of one face field U, which carries fields, 1-forms and functions.

    D_U is the operator of the handout, which is nearly skew-adjoint, so that the exponentials are stable. ∇U is that of
    `FieldDerivatives`. At vertices where U enters through a boundary, values do not change.

    Parameters
    ----------
    mesh : an oriented manifold.
    by : U, (m, 3); its normal part is ignored.

    Raises
    ------
    MeshError
        If a face has zero area, or the mesh is not an oriented manifold.
    FieldError
        If the field has another shape or is not finite.

    Examples
    --------
    A quarter turn about z takes the rotation about x to that about y.

    >>> from geomhw.flow import rigid_field
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(3)
    >>> X, Y, Z = (rigid_field(mesh, axis) for axis in np.eye(3))
    >>> bool(np.abs(Pushforward(mesh, Z).field(X, np.pi / 2) - Y).max() < 0.02)
    True
    """

    def __init__(self, mesh: TriangleMesh, by: Floats) -> None:
        mesh.require_oriented("the pushforward")
        self.mesh, self.by = mesh, tangential(mesh, by)
        self._derivatives = FieldDerivatives(mesh)
        self._inflow = inflow_vertices(mesh, self.by)
        self._derivative = directional_derivative(mesh, self.by)
        self._scalar = PassiveScalar(MassCorrection(mesh))
        self._decomposition = HelmholtzDecomposition(mesh)
        self._preserves_area = self._curl_free_share(self.by) <= AREA_PRESERVING

    def function(self, values: Floats, t: float) -> Floats:
        """Return f∘Φ_-t, (n,) or (n, k), of functions at vertices for a time t ≥ 0, within their range."""
        return self._scalar.advect(self._derivative, vertex_functions(self.mesh, values), t, self._inflow)

    def functions(self, values: Floats, t: float, count: int) -> Iterator[Floats]:
        """Yield functions, as `function` returns them, at time 0 and at ``count`` even times up to t."""
        yield values
        for _ in range(count):
            values = self.function(values, t / count)
            yield values

    def field(self, vectors: Floats, t: float, kind: TransportName = "vector") -> Floats:
        """Return a face field, (m, 3), transported for a time t; see `frames`."""
        *_, moved = self.frames(vectors, t, 1, kind)
        return moved

    def frames(self, vectors: Floats, t: float, count: int, kind: TransportName = "vector") -> Iterator[Floats]:
        """Yield a face field, (m, 3), at time 0, where it is as given, and at ``count`` even times up to t.

        Parameters
        ----------
        kind : ``vector``: the pushforward (Φ_t)_* V, by the differential of the flow. ``form``: the field of the 1-form
            V·, by its inverse transpose. ``parallel``: parallel transport along the paths of the flow.

        Where a vector field `keeps_divergence_zero`, its curl-free part is removed, which is an error of the transport.
        The rest has no divergence, to rounding.

        Raises
        ------
        ArgumentError
            If there is no such kind.
        ConvergenceError
            If the time is too long.
        """
        V, L = tangential(self.mesh, vectors), self.operator(kind)
        solenoidal = kind == "vector" and self.keeps_divergence_zero(V)
        state = self._derivatives.at_vertices(V).ravel()
        yield V
        for _ in range(count):
            state = expm(L, -t / count, state)
            V = self._derivatives.to_faces(state.reshape(-1, 3))
            # Twice, since the first solution leaves rounding relative to the part that is removed.
            yield self._decomposition.project(self._decomposition.project(V)) if solenoidal else V

    def keeps_divergence_zero(self, vectors: Floats) -> bool:
        """Whether a face field has no divergence to rounding, and U none but for the error of its samples."""
        return self._preserves_area and self._curl_free_share(tangential(self.mesh, vectors)) <= SOLENOIDAL

    def operator(self, kind: TransportName) -> sp.csr_array:
        """Assemble the operator L of V' = -LV on vectors at vertices, (3n, 3n), strong, units of U/length."""
        if kind not in get_args(TransportName):
            raise ArgumentError(f"there is no transport '{kind}'; choose from {', '.join(get_args(TransportName))}")
        n, surface = self._derivatives.fit.normals, self._derivatives.surface
        derivative, inflow = self._derivative, self._inflow
        if surface is not self.mesh:  # cut open at pinched vertices
            derivative, inflow = directional_derivative(surface, self.by), inflow_vertices(surface, self.by)
        P = _blocks(np.eye(3) - n[:, :, None] * n[:, None, :])
        L = P @ sp.kron(derivative, sp.eye_array(3), format="csr") @ P
        gradient = self._derivatives.covariant(self.by)
        if kind == "vector":
            L = L - _blocks(gradient)
        elif kind == "form":
            L = L + _blocks(gradient.transpose(0, 2, 1))
        moving = np.ones((surface.n_vertices, 3))
        moving[inflow] = 0.0
        return (sp.diags_array(moving.ravel()) @ L).tocsr()

    def _curl_free_share(self, field: Floats) -> float:
        """Share of the curl-free part in the energy of a field; 0 for the zero field."""
        total = energy(self.mesh, field)
        rest = field - self._decomposition.project(field) if total else field
        return energy(self.mesh, rest) / total if total else 0.0


def _blocks(matrices: Floats) -> sp.csr_array:
    """Block-diagonal matrix, (3n, 3n), of matrices, (n, 3, 3)."""
    n = len(matrices)
    return sp.bsr_array((matrices, np.arange(n), np.arange(n + 1)), shape=(3 * n, 3 * n)).tocsr()
