"""Pathlines of seeds in an unsteady flow, with their latest positions, as points and streaks."""

import math
from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.flow.streamlines import FacePoints, StreamlineTracer
from geomhw.flow.tangent_fields import energy
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field

#: Length of the past that is kept, as the share of √area that the root mean square speed covers in this time,
PAST = 0.15
#: and the number of positions in it.
POSITIONS = 20
#: A position is due if it is due within this share of the interval between two.
SLACK = 1e-6


@dataclass(frozen=True)
class Pathlines:
    """Points at a time and their past: positions, (20, k, 3), at the times, (20,), ascending."""

    points: FacePoints
    time: float
    past: Floats
    times: Floats


class PathlineTracer:
    """Move seeds with a flow that changes from step to step; MeshError as for `StreamlineTracer`."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self._tracer = StreamlineTracer(mesh)
        self._area = float(mesh.face_areas.sum())

    def start(self, count: int, time: float = 0.0) -> Pathlines:
        """Return seeds that represent equal areas, at rest in the past; FieldError for a count below 1."""
        points = self._tracer.seeds(count)
        x = self._tracer.positions(points)
        return Pathlines(points, time, np.repeat(x[None], POSITIONS, axis=0), np.full(POSITIONS, time))

    def step(self, pathlines: Pathlines, velocity: Floats, time: float) -> Pathlines:
        """Return the pathlines at a later time.

        Parameters
        ----------
        velocity : (m, 3) array, constant in between. With the mean of the velocities before and after, a step is of
            second order in time. If both have the form n x ∇ψ, so has their mean.
        """
        if not (time >= pathlines.time and math.isfinite(time)):
            raise FieldError(f"tracers move from time {pathlines.time} onward, not to {time}")
        points, past, times = pathlines.points, list(pathlines.past), pathlines.times.tolist()
        interval, now = self._interval(velocity), pathlines.time
        # Stops are the end, and whole intervals before it as far as the past is kept.
        count = int(min((time - now) / interval, POSITIONS))
        stops = [time - k * interval for k in range(count, 0, -1)]
        for stop in [*(stop for stop in stops if stop > now), time]:
            points, now = self._tracer.advance(points, velocity, stop - now), stop
            if now - times[-1] >= (1 - SLACK) * interval:
                past.append(self._tracer.positions(points))
                times.append(now)
        return Pathlines(points, time, np.array(past[-POSITIONS:]), np.array(times[-POSITIONS:]))

    def cloud(self, pathlines: Pathlines, velocity: Floats, color: Floats) -> Cloud:
        """Return the points with fields on them.

        Parameters
        ----------
        velocity : (m, 3) array.
        color : (n,) or (n, k) array.

        Returns
        -------
        Cloud with ``velocity``, ``color``, ``id``, ``face`` and ``past`` on points, and ``past_times`` and ``time``.
        ``past``, (k, 60), is the position, x y z, at each of the past times minus the present position.
        """
        points = pathlines.points
        x = self._tracer.positions(points)
        past = (pathlines.past - x).transpose(1, 0, 2).reshape(len(x), -1)
        corner_colors = np.asarray(color)[self.mesh.faces[points.faces]]
        fields = [
            Field("velocity", "vertex", np.asarray(velocity)[points.faces]),
            Field("color", "vertex", np.einsum("pk,pk...->p...", points.weights, corner_colors)),
            Field("id", "vertex", np.arange(len(x), dtype=np.int32)),
            Field("face", "vertex", points.faces.astype(np.int32)),
            Field("past", "vertex", past.astype(np.float32)),
            Field("past_times", "mesh", pathlines.times),
            Field("time", "mesh", np.array([pathlines.time])),
        ]
        return Cloud(x, fields)

    def _interval(self, velocity: Floats) -> float:
        """Time between two positions that are kept; inf at rest."""
        speed = math.sqrt(energy(self.mesh, velocity) / self._area)
        return PAST * math.sqrt(self._area) / speed / POSITIONS if speed > 0 else math.inf
