"""The flow map exp(t D_V) of a tangent field V as a linear operator on functions [OATVF]."""

import math
from collections.abc import Iterator
from typing import get_args

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, FieldError
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import directional_derivative
from geomhw.options import Integrator
from geomhw.results import Field, Result
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

    def __init__(self, mesh: TriangleMesh, field: Floats, integrator: Integrator = "taylor3") -> None:
        if integrator not in _INTEGRATORS:
            raise ArgumentError(f"there is no integrator '{integrator}'; choose from {', '.join(get_args(Integrator))}")
        self.mesh = mesh
        self.field = tangential(mesh, field)
        self.operator = directional_derivative(mesh, self.field)
        self._exponential = _INTEGRATORS[integrator]
        self._norm = norm_bound(self.operator)

    def pull_back(self, functions: Floats, t: float) -> Floats:
        """Return f∘Φ_t = exp(t D_V) f, (n,) or (n, k): at x the value of f at Φ_t(x) [OATVF, eq. 8]."""
        return self._exponential(self.operator, t, self._checked(functions), norm=self._norm)

    def advect(self, functions: Floats, t: float) -> Floats:
        """Return exp(-t D_V) f, (n,) or (n, k): f moved downstream for time t."""
        return self.pull_back(functions, -t)

    def _checked(self, functions: Floats) -> Floats:
        values = np.asarray(functions, dtype=float)
        if values.ndim not in (1, 2) or len(values) != self.mesh.n_vertices:
            raise FieldError(f"a function on this mesh has {self.mesh.n_vertices} values, not {values.shape}")
        if not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values.reshape(len(values), -1)).all(axis=1)))
            raise FieldError(f"the function is not finite at vertex {row}")
        return values


def frames(flow: FlowMap, color: Floats, dt: float, steps: int, every: int) -> Iterator[Result]:
    """Advect a color and yield it at the start, after each ``every`` steps of dt, and after the last.

    Parameters
    ----------
    color : (n,) or (n, k) array, the color at time 0.

    Yields
    ------
    Result with the fields ``color`` per vertex, ``velocity`` per face and ``time``. The report has step, time, and the
    least, largest and area-weighted mean value of the color.

    Raises
    ------
    ArgumentError
        If dt, steps or every is not positive, or dt is impossible on the mesh.
    ConvergenceError
        If dt is too long for the smallest faces of the mesh.
    """
    if not (dt > 0 and math.isfinite(dt)):
        raise ArgumentError(f"the time step must be positive and finite, not {dt}")
    if steps < 1 or every < 1:
        raise ArgumentError("a run needs at least one step, and at least one step from frame to frame")
    require_possible_step(flow.mesh, flow.field, dt)
    color = flow.advect(color, 0.0)
    for step in range(steps + 1):
        following = flow.advect(color, dt) if step < steps else color  # first: a step that is refused leaves no frame
        if step % every == 0 or step == steps:
            yield _frame(flow, color, step, step * dt)
        color = following


def require_possible_step(mesh: TriangleMesh, velocity: Floats, dt: float) -> None:
    """Raise ArgumentError for a time step so long that no method takes it with a velocity, (m, 3)."""
    courant = dt * float(np.linalg.norm(velocity, axis=1).max()) / mesh.mean_edge_length
    if courant > MAX_COURANT:
        raise ArgumentError(f"a step of {dt:g} has a Courant number of {courant:.3g}; take a shorter step")


def _frame(flow: FlowMap, color: Floats, step: int, time: float) -> Result:
    areas = flow.mesh.vertex_areas
    mean = np.tensordot(areas, color, axes=1) / areas.sum()
    report = {
        "step": step,
        "time": time,
        "color_min": float(color.min()),
        "color_max": float(color.max()),
        "color_mean": float(np.mean(mean)),
    }
    fields = [
        Field("color", "vertex", color),
        Field("velocity", "face", flow.field),
        Field("time", "mesh", np.array([time])),
    ]
    return Result(flow.mesh, fields, report)
