"""Functions carried by a tangent field: the operator approach [OATVF].

Azencot, Ben-Chen, Chazal, Ovsjanikov: An Operator Approach to Tangent Vector Field Processing, Computer Graphics Forum
32(5), 2013. The flow map T_V^t = exp(t D_V) of eq. 8 pulls functions back, f∘Φ_t; exp(-t D_V) carries them along.
"""

import math
from collections.abc import Iterator
from typing import get_args

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.directional_derivative import directional_derivative
from geomhw.options import Integrator
from geomhw.results import Field, Result
from geomhw.solvers.expm import expm, norm_bound, taylor3

_INTEGRATORS = {"taylor3": taylor3, "expm": expm}


class FlowMap:
    """T_V^t of one field on one mesh, applied to any functions for any time.

    field: V, (m, 3), of which the tangential part counts. integrator: ``taylor3``, the handout's I + tD + t²D²/2, or
    ``expm``, the exponential to rounding. Either splits a step too large for it. FieldError for other input.
    """

    def __init__(self, mesh: TriangleMesh, field: Floats, integrator: Integrator = "taylor3") -> None:
        if integrator not in _INTEGRATORS:
            raise FieldError(f"there is no integrator '{integrator}'; choose from {', '.join(get_args(Integrator))}")
        self.mesh = mesh
        self.field = tangential(mesh, field)
        self.operator = directional_derivative(mesh, self.field)
        self._apply = _INTEGRATORS[integrator]
        self._norm = norm_bound(self.operator)

    def pull_back(self, functions: Floats, t: float) -> Floats:
        """T_V^t f = exp(t D_V) f, (n,) or (n, k) [OATVF, eq. 8]: the value at x is that of f at Φ_t(x)."""
        return self._apply(self.operator, t, self._checked(functions), norm=self._norm)

    def carry(self, functions: Floats, t: float) -> Floats:
        """exp(-t D_V) f, (n,) or (n, k): f moved downstream for time t."""
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
    """The color at the start, after each ``every`` steps of dt downstream, and after the last.

    Fields: ``color``, per vertex; ``velocity``, per face; ``time``. The report has step, time, and the color's least,
    largest and area-weighted mean value. FieldError for a dt, steps or every that is not positive.
    """
    if not (dt > 0 and math.isfinite(dt)):
        raise FieldError(f"the time step must be positive and finite, not {dt}")
    if steps < 1 or every < 1:
        raise FieldError("a run has at least one step, and a frame each so many steps, at least one")
    color = flow.carry(color, 0.0)
    for step in range(steps + 1):
        if step:
            color = flow.carry(color, dt)
        if step % every == 0 or step == steps:
            yield _frame(flow, color, step, step * dt)


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
