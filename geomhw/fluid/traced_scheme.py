"""A scheme whose states also hold tracers in the flow."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.pathlines import Pathlines, PathlineTracer
from geomhw.flow.streamlines import FacePoints
from geomhw.fluid.state import FlowState, Force, Scheme
from geomhw.results import Cloud

_PREFIX = "tracer_"
_NAMES = ("faces", "weights", "past", "times")


class TracedScheme:
    """Another scheme with tracers that move with the mean velocity of each step.

    Everything else is bit-identical to the scheme without tracers.

    Parameters
    ----------
    scheme : the scheme.
    count : number of tracers, seeded so that they represent equal areas.
    """

    def __init__(self, scheme: Scheme, count: int) -> None:
        self.mesh = scheme.mesh
        self._scheme, self._count = scheme, count
        self._tracer = PathlineTracer(scheme.mesh)
        self.velocity, self.vorticity, self.coefficients = scheme.velocity, scheme.vorticity, scheme.coefficients

    def start(self, velocity: Floats, color: ArrayLike | None = None) -> FlowState:
        """Return the scheme's state at time 0, with the tracers at their seeds."""
        return _with(self._scheme.start(velocity, color), self._tracer.start(self._count))

    def from_vorticity(self, w: ArrayLike, color: ArrayLike | None = None) -> FlowState:
        """Return the scheme's state at time 0, with the tracers at their seeds."""
        return _with(self._scheme.from_vorticity(w, color), self._tracer.start(self._count))

    def step(self, state: FlowState, dt: float, force: Force | None = None) -> FlowState:
        """Return the scheme's state one step of dt later, and the tracers with it."""
        later = self._scheme.step(state, dt, force)
        mean = (self.velocity(state) + self.velocity(later)) / 2
        return _with(later, self._tracer.step(tracers_of(state), mean, later.time))

    def cloud(self, state: FlowState) -> Cloud:
        """Return the tracers of a state as points with fields, see `PathlineTracer.cloud`."""
        return self._tracer.cloud(tracers_of(state), self.velocity(state), state.color)


def tracers_of(state: FlowState) -> Pathlines:
    """Return the tracers in a state; FieldError if it has none."""
    try:
        faces, weights, past, times = (state.variables[_PREFIX + name] for name in _NAMES)
    except KeyError:
        raise FieldError("this state of a flow has no tracers; start anew with them") from None
    return Pathlines(FacePoints(np.asarray(faces), weights), state.time, past, times)


def _with(state: FlowState, tracers: Pathlines) -> FlowState:
    arrays = (tracers.points.faces, tracers.points.weights, tracers.past, tracers.times)
    named = {_PREFIX + name: values for name, values in zip(_NAMES, arrays, strict=True)}
    return replace(state, variables={**state.variables, **named})
