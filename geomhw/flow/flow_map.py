"""The flow map exp(t D_V) of a tangent field V as a linear operator on functions [OATVF]."""

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, FieldError
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import directional_derivative
from geomhw.options import FlowSeries
from geomhw.solvers.expm import expm, norm_bound, taylor3

#: Courant number that no step reaches.
MAX_COURANT = 1e9
_INTEGRATORS = {"taylor3": taylor3, "expm": expm}


class FlowMap:
    """The flow map T_V^t of one field on one mesh, for any functions and times.

    Parameters
    ----------
    field : (m, 3) array, V per face; its normal part is ignored.
    integrator : ``taylor3``, the handout's I + tD + t²D²/2, or ``expm``, the exponential to rounding. Both split a
        step that is too long for them.

    Attributes
    ----------
    field : (m, 3) array, the tangential part of V.
    operator : (n, n) sparse array D_V, units of V/length, strong.

    Raises
    ------
    FieldError
        If the field has another shape or is not finite, or the integrator is unknown.

    References
    ----------
    [OATVF] Azencot, Ben-Chen, Chazal, Ovsjanikov: An Operator Approach to Tangent Vector Field Processing, Computer
    Graphics Forum 32(5), 2013.

    Examples
    --------
    A quarter turn about z moves the function x to y.

    >>> import numpy as np
    >>> from geomhw.flow import rigid_field
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(4)
    >>> x, y, z = mesh.vertices.T
    >>> turned = FlowMap(mesh, rigid_field(mesh, [0, 0, 1])).advect(x, np.pi / 2)
    >>> bool(np.abs(turned - y).max() < 0.01)
    True
    """

    def __init__(self, mesh: TriangleMesh, field: Floats, integrator: FlowSeries = "taylor3") -> None:
        if integrator not in _INTEGRATORS:
            raise ArgumentError(f"there is no integrator '{integrator}'; choose from {', '.join(_INTEGRATORS)}")
        self.mesh = mesh
        self.field = tangential(mesh, field)
        self.operator = directional_derivative(mesh, self.field)
        self._exponential = _INTEGRATORS[integrator]
        self._norm = norm_bound(self.operator)

    def pull_back(self, functions: Floats, t: float) -> Floats:
        """Return f∘Φ_t = exp(t D_V) f, (n,) or (n, k): at x the value of f at Φ_t(x) [OATVF, eq. 8]."""
        return self._exponential(self.operator, t, vertex_functions(self.mesh, functions), norm=self._norm)

    def advect(self, functions: Floats, t: float) -> Floats:
        """Return exp(-t D_V) f, (n,) or (n, k): f moved downstream for time t."""
        return self.pull_back(functions, -t)

    def steps_at_once(self, dt: float) -> int:
        """Return 1: a run takes its time steps one by one, as the handout does."""
        return 1


def require_possible_step(mesh: TriangleMesh, velocity: Floats, dt: float) -> None:
    """Raise ArgumentError for a time step so long that no method takes it with a velocity, (m, 3)."""
    courant = dt * float(np.linalg.norm(velocity, axis=1).max()) / mesh.mean_edge_length
    if courant > MAX_COURANT:
        raise ArgumentError(f"a step of {dt:g} has a Courant number of {courant:.3g}; take a shorter step")


def vertex_functions(mesh: TriangleMesh, functions: Floats) -> Floats:
    """Return functions as an array, (n,) or (n, k); FieldError if they have another shape or are not finite."""
    values = np.asarray(functions, dtype=float)
    if values.ndim not in (1, 2) or len(values) != mesh.n_vertices:
        raise FieldError(f"a function on this mesh has {mesh.n_vertices} values, not {values.shape}")
    if not np.isfinite(values).all():
        row = int(np.argmin(np.isfinite(values.reshape(len(values), -1)).all(axis=1)))
        raise FieldError(f"the function is not finite at vertex {row}")
    return values
