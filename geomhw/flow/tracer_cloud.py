"""Tracers: particles in a flow that remember where they were, to be seen as points and streaks."""

import math
from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.tangent_fields import energy
from geomhw.flow.tracer import Particles, Tracer
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field

#: How far back tracers remember: the time in which the flow's root mean square speed covers this share of √area,
MEMORY = 0.15
#: in so many places.
PLACES = 20
#: A place is due if it is due within this share of the time between two.
SLACK = 1e-6


@dataclass(frozen=True)
class Tracers:
    """Particles at a time, and where they were: past, (20, k, 3), at times, (20,), the latest last."""

    particles: Particles
    time: float
    past: Floats
    times: Floats


class Tracing:
    """Carries tracers on one mesh; MeshError as for `Tracer`."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self._tracer = Tracer(mesh)
        self._area = float(mesh.face_areas.sum())

    def start(self, count: int, time: float = 0.0) -> Tracers:
        """So many tracers, each for the same area, that remember where they start; FieldError for none."""
        particles = self._tracer.seed(count)
        at = self._tracer.positions(particles)
        return Tracers(particles, time, np.repeat(at[None], PLACES, axis=0), np.full(PLACES, time))

    def step(self, tracers: Tracers, velocity: Floats, time: float) -> Tracers:
        """The tracers at that later time, having gone along the velocity, (m, 3).

        The mean of those before and after is of second order in time, and of the form n x ∇ψ where both are.
        """
        if not (time >= tracers.time and math.isfinite(time)):
            raise FieldError(f"tracers go from time {tracers.time} onward, not to {time}")
        particles, past, times = tracers.particles, list(tracers.past), tracers.times.tolist()
        interval = self._interval(velocity)
        now = tracers.time
        for mark in _marks(now, time, interval):
            particles = self._tracer.advance(particles, velocity, mark - now)
            now = mark
            if now - times[-1] >= (1 - SLACK) * interval:
                past.append(self._tracer.positions(particles))
                times.append(now)
        return Tracers(particles, time, np.array(past[-PLACES:]), np.array(times[-PLACES:]))

    def cloud(self, tracers: Tracers, velocity: Floats, color: Floats) -> Cloud:
        """Positions, with the velocity and color of where they are, ``id``, the ``face`` they are on, and the past.

        ``past`` holds, for each of ``past_times``, x y z of where the tracer was less where it is, (k, 60).
        """
        at = self._tracer.positions(tracers.particles)
        faces, weights = tracers.particles.faces, tracers.particles.weights
        past = (tracers.past - at).transpose(1, 0, 2).reshape(len(at), -1)
        fields = [
            Field("velocity", "vertex", np.asarray(velocity)[faces]),
            Field("color", "vertex", np.einsum("pk,pk...->p...", weights, np.asarray(color)[self.mesh.faces[faces]])),
            Field("id", "vertex", np.arange(len(at), dtype=np.int32)),
            Field("face", "vertex", faces.astype(np.int32)),
            Field("past", "vertex", past.astype(np.float32)),
            Field("past_times", "mesh", tracers.times),
            Field("time", "mesh", np.array([tracers.time])),
        ]
        return Cloud(at, fields)

    def _interval(self, velocity: Floats) -> float:
        """Time between two places that are remembered; inf at rest."""
        speed = math.sqrt(energy(self.mesh, velocity) / self._area)
        return MEMORY * math.sqrt(self._area) / speed / PLACES if speed > 0 else math.inf


def _marks(start: float, end: float, interval: float) -> list[float]:
    """Times at which to stop between start and end: the end, and whole intervals before it as far as memory reaches."""
    count = int(min((end - start) / interval, PLACES))
    return [mark for mark in (end - k * interval for k in range(count, 0, -1)) if mark > start] + [end]
