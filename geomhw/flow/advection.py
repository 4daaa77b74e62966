"""A color advected by a steady tangent field, step by step: the methods by name, and the frames of a run."""

import math
from collections.abc import Iterator
from typing import Literal, get_args

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, ConvergenceError
from geomhw.flow.bounded_flow import BoundedFlow
from geomhw.flow.flow_map import FlowMap, require_possible_step
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Integrator
from geomhw.results import Field, Result

#: `TriangleMesh.digest` of the sphere of the course handout, on which exp(-tD) in three terms is the handout's answer.
HANDOUTS_SPHERE = "57e9c1b46f12d7f0d13dc0ae712a7978c8fb57e59b065d3fb89020954f733645"
#: A run stops if the color leaves its range by this many times the width of the range.
RUNAWAY = 10.0


def flow_of(mesh: TriangleMesh, field: Floats, integrator: Integrator = "auto") -> FlowMap | BoundedFlow:
    """Make a flow by name.

    Parameters
    ----------
    field : (m, 3) array, V per face; its normal part is ignored.
    integrator : as in `integrator_of`; ``bounded`` makes a `BoundedFlow`, the others make a `FlowMap`.

    Raises
    ------
    FieldError
        If the field has another shape or is not finite.
    ArgumentError
        If the integrator is unknown.
    MeshError
        If a face has zero area.
    """
    chosen = integrator_of(mesh, integrator)
    return BoundedFlow(mesh, field) if chosen == "bounded" else FlowMap(mesh, field, chosen)


def integrator_of(mesh: TriangleMesh, integrator: Integrator) -> Literal["bounded", "taylor3", "expm"]:
    """Return the integrator, where ``auto`` is ``taylor3`` on the handout's sphere and ``bounded`` on other meshes."""
    if integrator not in get_args(Integrator):
        raise ArgumentError(f"there is no integrator '{integrator}'; choose from {', '.join(get_args(Integrator))}")
    if integrator == "auto":
        return "taylor3" if mesh.digest == HANDOUTS_SPHERE else "bounded"
    return integrator


class ColorRange:
    """The range of a color, and how far and from which step on later colors leave it.

    Parameters
    ----------
    color : (n,) or (n, k) array, or the least and the largest value of all.
    most : excess at which `check` raises.

    Attributes
    ----------
    excess : float
        The largest distance of a value from the range, relative to the width of the range, or to the largest value
        if the color is constant.
    since : int or None
        The first step at which the excess was above `NOTICED`.
    """

    #: Excess below which a color counts as within its range.
    NOTICED = 0.01

    def __init__(self, color: Floats, most: float = RUNAWAY) -> None:
        self._most = most
        self._low, self._high = color.min(axis=0), color.max(axis=0)
        self._width = float(np.max(self._high - self._low) or np.abs(color).max() or 1.0)
        self.excess = 0.0
        self.since: int | None = None

    def check(self, color: Floats, step: int) -> None:
        """Record the color of a step; ConvergenceError if it is too far from the range."""
        beyond = np.maximum(self._low - color.min(axis=0), color.max(axis=0) - self._high)
        excess = float(np.max(beyond)) / self._width
        if not excess <= self._most:
            raise ConvergenceError(
                f"the color grows without bound: at step {step} it leaves its range by {excess:.3g} times the width of "
                "the range; take a scheme that keeps the range, or shorter steps"
            )
        if excess > self.NOTICED and self.since is None:
            self.since = step
        self.excess = max(self.excess, excess)


def frames(
    flow: FlowMap | BoundedFlow,
    color: Floats,
    dt: float,
    steps: int,
    every: int,
    limits: ColorRange | None = None,
) -> Iterator[Result]:
    """Advect a color and yield it at the start, after each ``every`` steps of dt, and after the last.

    Parameters
    ----------
    color : (n,) or (n, k) array, the color at time 0.
    limits : records whether the color leaves its range.

    Yields
    ------
    Result with the fields ``color`` per vertex, ``velocity`` per face and ``time``. The report has step, time, and the
    least, largest and area-weighted mean value of the color.

    Raises
    ------
    ArgumentError
        If dt, steps or every is not positive, or dt is impossible on the mesh.
    ConvergenceError
        If the color grows without bound.
    """
    if not (dt > 0 and math.isfinite(dt)):
        raise ArgumentError(f"the time step must be positive and finite, not {dt}")
    if steps < 1 or every < 1:
        raise ArgumentError("a run needs at least one step, and at least one step from frame to frame")
    require_possible_step(flow.mesh, flow.field, dt)
    step, color = 0, flow.advect(color, 0.0)
    limits = limits or ColorRange(color)
    start: Result | None = _frame(flow, color, 0, 0.0)
    while step < steps:
        count = min(flow.steps_at_once(dt), every - step % every, steps - step)
        color, step = flow.advect(color, count * dt), step + count
        limits.check(color, step)
        if start:  # only now: a first step that is refused leaves no frame
            yield start
            start = None
        if step % every == 0 or step == steps:
            yield _frame(flow, color, step, step * dt)


def _frame(flow: FlowMap | BoundedFlow, color: Floats, step: int, time: float) -> Result:
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
