"""A run: steps from one state to a last step or time, with what is seen on the way."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geomhw.errors import ConvergenceError, FieldError
from geomhw.fluid.state import FlowState, Force, Scheme

#: A step is not cut to reach the end if it overshoots by less than this share of itself.
SLACK = 1e-9
#: So many steps are tried, at most, to find the longest that a scheme stands.
LONGEST_SEARCH = 20


@dataclass(frozen=True)
class Plan:
    """How far to go and how: dt or a Courant number, up to a step or a time, a frame each so many steps.

    FieldError where that is no plan.
    """

    dt: float | None = None
    cfl: float | None = None
    steps: int | None = None
    until: float | None = None
    every: int = 1

    def __post_init__(self) -> None:
        for name in ("dt", "cfl", "until"):
            value = getattr(self, name)
            if value is not None and not (value > 0 and math.isfinite(value)):
                raise FieldError(f"{name} must be a positive number, not {value}")
        if (self.dt is None) == (self.cfl is None):
            raise FieldError("a run takes steps either of dt or of a Courant number")
        if (self.steps is None) == (self.until is None):
            raise FieldError("a run ends either after so many steps or at a time")
        if self.every < 1 or (self.steps is not None and self.steps < 1):
            raise FieldError("a run has at least one step, and a frame each so many steps, at least one")

    def share(self, state: FlowState) -> float:
        """How much of the run is done, 0..1."""
        return state.step / self.steps if self.steps else state.time / (self.until or 1.0)


@dataclass(frozen=True)
class Snapshot:
    """A state to show, the step that led or leads there, and whether an uninterrupted run would come by it too."""

    state: FlowState
    dt: float
    regular: bool


def run(scheme: Scheme, state: FlowState, plan: Plan, force: Force | None) -> Iterator[Snapshot]:
    """The state at the start (if that is step 0), each ``every`` steps, and at the end, which is met exactly."""
    dt = step_length(scheme, state, plan)
    if state.step == 0:
        yield Snapshot(state, dt, True)
    while not _at_end(state, plan):
        dt = step_length(scheme, state, plan)
        cut = False
        if plan.until is not None and state.time + dt > plan.until - SLACK * dt:
            cut = abs(plan.until - state.time - dt) > SLACK * dt
            dt = plan.until - state.time
        try:
            state = scheme.step(state, dt, force)
        except ConvergenceError as error:
            raise _too_long(scheme, state, dt, force) or error from error
        if state.step % plan.every == 0 and not cut:
            yield Snapshot(state, dt, True)
        elif _at_end(state, plan):
            yield Snapshot(state, dt, False)


def step_length(scheme: Scheme, state: FlowState, plan: Plan) -> float:
    """dt as given, or that of the Courant number: C h / |V|max."""
    if plan.dt is not None:
        return plan.dt
    rate = _courant_rate(scheme, state)
    if rate == 0:
        raise FieldError("a flow at rest has no Courant number; give dt, or an initial velocity")
    assert plan.cfl is not None
    return plan.cfl / rate


def _courant_rate(scheme: Scheme, state: FlowState) -> float:
    """Courant number per time: |V|max / h."""
    return float(np.linalg.norm(scheme.velocity(state), axis=1).max()) / scheme.mesh.mean_edge_length


def _too_long(scheme: Scheme, state: FlowState, dt: float, force: Force | None) -> ConvergenceError | None:
    """What to say of a step that failed: the largest that does not; None if even very short ones do."""
    good, bad = 0.0, dt
    for _ in range(LONGEST_SEARCH):
        middle = bad / 2 if not good else (good + bad) / 2
        try:
            scheme.step(state, middle, force)
            good = middle
        except ConvergenceError:
            bad = middle
        if good and bad - good < 0.05 * good:
            break
    if not good:
        return None
    rate = _courant_rate(scheme, state)
    return ConvergenceError(
        f"step {state.step + 1} is too long for the scheme, at a Courant number of {dt * rate:.3g} (dt {dt:.3g}); "
        f"the largest for this flow on this mesh is {_rounded_down(good * rate)} (dt {_rounded_down(good)})"
    )


def _rounded_down(value: float) -> str:
    """Two digits that are no more than the value."""
    if value == 0:
        return "0"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / unit) * unit:.2g}"


def _at_end(state: FlowState, plan: Plan) -> bool:
    if plan.steps is not None:
        return state.step >= plan.steps
    assert plan.until is not None
    return state.time >= plan.until * (1 - 1e-15)
