"""A run: a scheme by name, and its steps from a state to a last step or time, with snapshots on the way."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import get_args

import numpy as np

from geomhw.errors import ArgumentError, ConvergenceError
from geomhw.flow.flow_map import require_possible_step
from geomhw.fluid.conservation import ConservationCheck
from geomhw.fluid.conservative import ConservativeScheme
from geomhw.fluid.rk4 import RK4Scheme
from geomhw.fluid.stable_fluids import StableFluidsScheme
from geomhw.fluid.state import FlowState, Force, Scheme
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import MAX_STEPS, Advection, SchemeName

#: The last step is not shortened if it overshoots the end by less than this share of itself.
SLACK = 1e-9
#: Most steps that are tried to find the longest step that a scheme can take.
LONGEST_SEARCH = 20


def scheme_of(
    mesh: TriangleMesh, name: SchemeName, *, advection: Advection = "full", filter: bool = True, viscosity: float = 0.0
) -> Scheme:
    """Make a scheme by name.

    Parameters
    ----------
    name : ``conservative``, ``rk4`` or ``stable-fluids``.
    advection : of ``stable-fluids``, see `StableFluidsScheme`.
    filter, viscosity : of the others, see `VorticityScheme`.

    Raises
    ------
    ArgumentError
        If the name is unknown, or the viscosity is not possible with the scheme.
    MeshError
        If the mesh is not an oriented manifold, or a face has zero area.
    """
    if name == "stable-fluids":
        if viscosity:
            raise ArgumentError("stable-fluids has no viscosity of its own; choose another scheme")
        return StableFluidsScheme(mesh, advection)
    if name == "conservative":
        return ConservativeScheme(mesh, filter, viscosity)
    if name == "rk4":
        return RK4Scheme(mesh, filter, viscosity)
    raise ArgumentError(f"there is no scheme '{name}'; choose from {', '.join(get_args(SchemeName))}")


@dataclass(frozen=True)
class Plan:
    """The length of the steps, the end of a run, and the steps from snapshot to snapshot.

    Parameters
    ----------
    dt, cfl : time step, or Courant number; exactly one of them.
    steps, until : last step, or end time; exactly one of them.
    every : steps from snapshot to snapshot.

    Raises
    ------
    ArgumentError
        If a number is not positive and finite, steps are more than 1e9, or both or none of two alternatives are given.
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
                raise ArgumentError(f"{name} must be a positive number, not {value}")
        if (self.dt is None) == (self.cfl is None):
            raise ArgumentError("a run takes steps either of dt or of a Courant number")
        if (self.steps is None) == (self.until is None):
            raise ArgumentError("a run ends either after a number of steps or at a time")
        if self.every < 1 or (self.steps is not None and self.steps < 1):
            raise ArgumentError("a run needs at least one step, and at least one step from frame to frame")
        if self.dt and self.until:
            _require_few_steps(self.until, self.dt)

    def share(self, state: FlowState) -> float:
        """Return how much of the run is done, 0..1."""
        return state.step / self.steps if self.steps else state.time / (self.until or 1.0)

    def ended(self, state: FlowState) -> bool:
        """Return whether the state is the last."""
        return state.step >= self.steps if self.steps else state.time >= (self.until or 0.0) * (1 - 1e-15)


@dataclass(frozen=True)
class Snapshot:
    """A state of a run, the step that led to it, and whether an uninterrupted longer run has this state too."""

    state: FlowState
    dt: float
    regular: bool


def run(
    scheme: Scheme,
    state: FlowState,
    plan: Plan,
    force: Force | None = None,
    conservation: ConservationCheck | None = None,
) -> Iterator[Snapshot]:
    """Step a scheme to the end of the plan, which is met exactly.

    Parameters
    ----------
    conservation : records whether energy and enstrophy keep their bounds.

    Yields
    ------
    Snapshot at the start (if the state is of step 0), after each ``every`` steps, and at the end.

    Raises
    ------
    ConvergenceError
        If a step is too long for the scheme; the message has the longest possible step. If energy or enstrophy runs
        away, see `ConservationCheck`.
    ArgumentError
        If the first step is impossible, the steps are too many, or they have a Courant number and the flow is at rest.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> mesh = icosphere(2)
    >>> scheme = scheme_of(mesh, "conservative")
    >>> start = scheme.from_vorticity(2 * mesh.vertices[:, 2])
    >>> [snapshot.state.step for snapshot in run(scheme, start, Plan(cfl=1.0, steps=10, every=5))]
    [0, 5, 10]
    """
    dt = step_length(scheme, state, plan)
    conservation = conservation or ConservationCheck(scheme, state, force)
    _require_possible(scheme, state, plan, dt)
    start = Snapshot(state, dt, True) if state.step == 0 else None
    while not plan.ended(state):
        dt = step_length(scheme, state, plan)
        cut = False
        if plan.until is not None and state.time + dt > plan.until - SLACK * dt:
            cut = abs(plan.until - state.time - dt) > SLACK * dt
            dt = plan.until - state.time
        try:
            state = scheme.step(state, dt, force)
        except ConvergenceError as error:
            raise _too_long(scheme, state, dt, force) or error from error
        conservation.check(state, dt)
        if start:  # only now: a first step that is refused leaves no snapshot
            yield start
            start = None
        regular = state.step % plan.every == 0 and not cut
        if regular or plan.ended(state):
            yield Snapshot(state, dt, regular)


def _require_possible(scheme: Scheme, state: FlowState, plan: Plan, dt: float) -> None:
    """Raise ArgumentError for a first step that no scheme can take, or for too many steps to the end."""
    require_possible_step(scheme.mesh, scheme.velocity(state), dt)
    if plan.until:
        _require_few_steps(plan.until - state.time, dt)


def _require_few_steps(time: float, dt: float) -> None:
    if time / dt > MAX_STEPS:
        raise ArgumentError(f"steps of {dt:g} to the time {time:g} are {time / dt:.3g}; at most {MAX_STEPS:g} are made")


def step_length(scheme: Scheme, state: FlowState, plan: Plan) -> float:
    """Return dt as given, or that of the Courant number, C h / |V|max."""
    if plan.dt is not None:
        return plan.dt
    rate = _courant_rate(scheme, state)
    if rate == 0:
        raise ArgumentError("a flow at rest has no Courant number; give a time step, or an initial velocity")
    assert plan.cfl is not None
    return plan.cfl / rate


def _courant_rate(scheme: Scheme, state: FlowState) -> float:
    """Courant number per time, |V|max / h."""
    return float(np.linalg.norm(scheme.velocity(state), axis=1).max()) / scheme.mesh.mean_edge_length


def _too_long(scheme: Scheme, state: FlowState, dt: float, force: Force | None) -> ConvergenceError | None:
    """The error for a step that failed, with the longest that succeeds by bisection; None if all fail."""
    good, bad = 0.0, dt
    for _ in range(LONGEST_SEARCH):
        middle = (good + bad) / 2
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
    """Two significant digits, rounded toward zero."""
    if value == 0:
        return "0"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / unit) * unit:.2g}"
