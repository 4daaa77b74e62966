"""Particles carried along the exact streamlines of a field that is constant on each face."""

import math
from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ConvergenceError, FieldError
from geomhw.flow.face_steps import Crossings, FaceFlow, Mask
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.sampling import points_on, spread_samples
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A barycentric coordinate below this is zero: the particle is on the edge, or at the vertex.
ON_EDGE = 1e-14
#: A particle that comes back to an edge this near, relative to the distance from its ends, goes round in a circle.
CLOSED = 1e-9
#: One that circles a vertex on a spiral, with a barycentric coordinate this near 1, rests until the next step.
CORE = 1e-3
#: Edges that a particle may cross in a step.
MOST_CROSSINGS = 200_000


@dataclass(frozen=True)
class Particles:
    """Points on a mesh: faces, (k,), and barycentric coordinates in them, (k, 3), none negative, of sum 1."""

    faces: Ints
    weights: Floats


class Tracer:
    """Moves particles on one mesh; MeshError where an edge has more than two faces, or a face has no area.

    Between edges a path is a straight segment along V, and edges are crossed as if the faces were laid flat, so that
    there is no error but rounding: along n x ∇ψ a particle keeps its ψ. What edges and vertices do to other fields, and
    the boundary to all, is said at `face_flow`; no particle leaves the surface.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        mesh.require_manifold("tracers need a manifold")
        self.mesh = mesh
        self._crossings = Crossings(mesh)

    def seed(self, count: int) -> Particles:
        """So many particles, each for the same area, the same ones every time; FieldError for none."""
        if count < 1:
            raise FieldError(f"there is at least one tracer, not {count}")
        return Particles(*spread_samples(self.mesh, count))

    def positions(self, particles: Particles) -> Floats:
        """Where the particles are, (k, 3)."""
        return points_on(self.mesh, particles.faces, particles.weights)

    def advance(self, particles: Particles, velocity: Floats, dt: float) -> Particles:
        """Where the particles are after going along the velocity, (m, 3), for dt; any dt, in one go.

        FieldError for a velocity or time that is none, ConvergenceError where a particle crosses edges without end.
        """
        if not (dt >= 0 and math.isfinite(dt)):
            raise FieldError(f"tracers go on for a finite time, not for {dt}")
        flow = FaceFlow(self._crossings, tangential(self.mesh, velocity))
        walk = _Walk(particles, dt)
        for _ in range(MOST_CROSSINGS):
            if not len(walk.who):
                return Particles(walk.last_faces, walk.last_weights)
            walk.go(flow)
        raise ConvergenceError(f"tracers cross more than {MOST_CROSSINGS} edges in a step; take a shorter time step")


class _Walk:
    """Particles on their way, each for the time it has left: in every call of ``go`` all reach their next edge.

    who: the particles still going, (k,); faces, weights, left: theirs. A particle remembers the first edge that it
    crossed, where, and how long ago (mark, place, since): if it comes back there, whole turns are taken off its time.
    """

    def __init__(self, particles: Particles, dt: float) -> None:
        self.last_faces, self.last_weights = particles.faces.copy(), particles.weights.copy()
        count = len(particles.faces)
        self.who = np.arange(count if dt else 0)
        self.faces, self.weights = particles.faces, particles.weights
        self.left, self.since = np.full(count, float(dt)), np.zeros(count)
        self.mark, self.place = np.full(count, -1), np.zeros(count)

    def go(self, flow: FaceFlow) -> None:
        """To the next edge or the end of the time."""
        self.faces, self.weights, rates, crossed = flow.headed(self.faces, self.weights)
        self._count_turns(crossed)
        time, edge = _exit(self.weights, rates)
        done = ~(time < self.left)
        step = np.where(done, self.left, time)
        weights = self.weights + step[:, None] * rates
        weights[~done, edge[~done]] = 0.0
        weights[weights < ON_EDGE] = 0.0
        self.weights = weights / weights.sum(axis=1, keepdims=True)
        self.left, self.since = self.left - step, self.since + step
        if done.any():
            self._finish(done)

    def _count_turns(self, crossed: Ints) -> None:
        """Take whole turns off the time of particles that are back at their mark."""
        over = np.flatnonzero(crossed >= 0)
        if not over.size:
            return
        at = self.weights[over, (crossed[over] + 1) % 3]
        back = crossed[over] == self.mark[over]
        same = back & (np.abs(at - self.place[over]) <= CLOSED * np.minimum(at, 1 - at))
        round_ = over[same]
        self.left[round_] = np.fmod(self.left[round_], self.since[round_])
        spiral = over[back & ~same & (self.weights[over].max(axis=1) > 1 - CORE)]
        self.left[spiral] = 0.0
        fresh = (self.mark[over] < 0) | (back & ~same)
        new = over[fresh]
        self.mark[new], self.place[new], self.since[new] = crossed[new], at[fresh], 0.0

    def _finish(self, done: Mask) -> None:
        """Put down where the particles are whose time is up."""
        ended = self.who[done]
        self.last_faces[ended], self.last_weights[ended] = self.faces[done], self.weights[done]
        for name in ("who", "faces", "weights", "left", "since", "mark", "place"):
            setattr(self, name, getattr(self, name)[~done])


def _exit(weights: Floats, rates: Floats) -> tuple[Floats, Ints]:
    """When each particle reaches an edge, (k,), inf for never; and the corner opposite, (k,)."""
    falling = rates < 0
    times = np.divide(weights, -rates, out=np.full_like(weights, np.inf), where=falling)
    edge = times.argmin(axis=1)
    return times[np.arange(len(times)), edge], edge
