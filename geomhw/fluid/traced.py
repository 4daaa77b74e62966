"""A scheme with tracers in its flow."""

from collections.abc import Mapping

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.tracer import Particles
from geomhw.flow.tracer_cloud import Tracers, Tracing
from geomhw.fluid.state import FlowState, Force, Scheme
from geomhw.results import Cloud

_MARK = "tracer_"


class TracedScheme:
    """Another scheme, whose states also hold tracers: they go along the mean velocity of each step.

    What is not of tracers is, to the last bit, what the scheme gives without them.
    """

    def __init__(self, scheme: Scheme, count: int) -> None:
        self.mesh = scheme.mesh
        self._scheme, self._count = scheme, count
        self._tracing = Tracing(scheme.mesh)
        self._latest: tuple[FlowState, Floats] | None = None

    def start(self, velocity: Floats, color: Floats) -> FlowState:
        """The scheme's state at time 0 with the tracers where they are seeded."""
        return _with(self._scheme.start(velocity, color), self._tracing.start(self._count))

    def step(self, state: FlowState, dt: float, force: Force | None) -> FlowState:
        """The scheme's state one step of dt later, and the tracers with it."""
        before = self.velocity(state)
        later = self._scheme.step(_without(state), dt, force)
        after = self._scheme.velocity(later)
        later = _with(later, self._tracing.step(tracers_of(state), (before + after) / 2, later.time))
        self._latest = (later, after)
        return later

    def velocity(self, state: FlowState) -> Floats:
        """Velocity per face, (m, 3); that of the latest state is remembered."""
        if self._latest is None or self._latest[0] is not state:
            self._latest = (state, self._scheme.velocity(state))
        return self._latest[1]

    def vorticity(self, state: FlowState) -> Floats:
        """Vorticity at vertices, (n,)."""
        return self._scheme.vorticity(state)

    def coefficients(self, state: FlowState) -> Mapping[str, float]:
        """What else the scheme knows of the flow."""
        return self._scheme.coefficients(state)

    def cloud(self, state: FlowState) -> Cloud:
        """The tracers of a state as points with fields, said at `Tracing.cloud`."""
        return self._tracing.cloud(tracers_of(state), self.velocity(state), state.color)


def tracers_of(state: FlowState) -> Tracers:
    """The tracers in a state; FieldError where there are none."""
    try:
        faces, weights, past, times = (state.memory[_MARK + name] for name in ("faces", "weights", "past", "times"))
    except KeyError:
        raise FieldError("this state of a flow has no tracers; start anew with them") from None
    return Tracers(Particles(np.asarray(faces), weights), state.time, past, times)


def _with(state: FlowState, tracers: Tracers) -> FlowState:
    held = {
        "faces": tracers.particles.faces,
        "weights": tracers.particles.weights,
        "past": tracers.past,
        "times": tracers.times,
    }
    memory = {**state.memory, **{_MARK + name: values for name, values in held.items()}}
    return FlowState(state.step, state.time, state.color, memory)


def _without(state: FlowState) -> FlowState:
    memory = {name: values for name, values in state.memory.items() if not name.startswith(_MARK)}
    return FlowState(state.step, state.time, state.color, memory)
