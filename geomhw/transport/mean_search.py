"""Descent to a point of least sum of squared distances, or of distances, from given points of a surface.

Karcher: Riemannian Center of Mass and Mollifier Smoothing. Comm. Pure Appl. Math. 30(5), 1977.
Weiszfeld: Sur le point pour lequel la somme des distances de n points donnés est minimum. Tohoku Math. J. 43, 1937.
Vardi, Zhang: The Multivariate L1-Median and Associated Data Depth. PNAS 97(4), 2000.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf, sqrt

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.straightest import StraightestGeodesics
from geomhw.mesh.named_points import face_point
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.log_map import LogarithmicMap

#: Steps, at most, and halvings of a step.
STEPS, HALVINGS = 500, 30
#: Steps end at this length, and values are equal up to this share.
SHORTEST, ROUNDING = 1e-14, 1e-14
#: Directions to points, at most, even ones, and lengths as shares of a step, in which the sum may decrease where it
#: does not in that of the step.
DIRECTIONS, EVEN_DIRECTIONS, SHARES = 8, np.arange(0, 360, 45), (0.5, 0.02)
#: Corners toward which a step over the boundary may go instead.
CORNERS = 2
#: A step of this length, as a share of the largest distance of a point, changes the sum by rounding.
NEGLIGIBLE = 1e-7
#: Radii exceed distances by this share, so that rounding does not matter.
SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class SurfaceMean:
    """A point that minimizes a sum over given points.

    Attributes
    ----------
    point : SurfacePoints
    value : float
        Sum of the squared distances, or for a median sum of the distances.
    distances : (k,) array
        Exact distance of each given point.
    last_step : float
        Length of the next step of the iteration: 0 at a stationary point, up to rounding.
    steps : int
        Number of steps.
    others : SurfacePoints, optional
        Further minima that were found with the same value: the mean is not unique.
    """

    point: SurfacePoints
    value: float
    distances: Floats
    last_step: float
    steps: int
    others: SurfacePoints | None = None


#: A state of the iteration: a point with its sum, and the next step in the frame of the logarithmic map.
State = tuple[SurfaceMean, Floats]
#: The point at a length from a point; None off the surface.
Way = Callable[[float], SurfacePoints | None]


class MeanSearch:
    """Minimization over a mesh of which the given points are vertices."""

    def __init__(self, mesh: TriangleMesh, targets: Ints, median: bool) -> None:
        self.mesh, self.targets, self.median = mesh, targets, median
        self._log, self._lines = LogarithmicMap(mesh), StraightestGeodesics(mesh)

    def radius(self, value: float) -> float:
        """Return the distance from a given point beyond which sums are larger than a value."""
        return (value if self.median else sqrt(value)) * (1 + SLACK)

    def minimum(self, start: SurfacePoints, radius: float = inf) -> SurfaceMean:
        """Return the minimum to which the iteration from a point converges; all given points are within a radius."""
        here = self._at(start, 0, radius)
        for steps in range(1, STEPS + 1):
            if np.linalg.norm(here[1]) <= SHORTEST * here[0].distances.max():
                break
            following = self._step(*here, steps) or self._in_any_direction(here[0], steps)
            if following is None:
                break
            here = following
        return here[0]

    def _step(self, state: SurfaceMean, step: Floats, number: int) -> State | None:
        """Return the state after a step that does not increase the sum; None if there is none.

        A step over the boundary is replaced by its part along an edge or within a face.
        """
        direction = float(np.arctan2(step[1], step[0]))
        degrees = float(np.degrees(direction))
        new, leaves = self._halved(state, lambda length: self._traced(state.point, degrees, length), number)
        if new or not leaves:
            return new
        ways = [(float(np.cos(angle - direction)), way) for angle, way in self._ways_to_corners(state.point)]
        for share, way in sorted(ways, key=lambda item: -item[0])[:CORNERS]:
            new, _ = self._halved(state, way, number, share) if share > 0 else (None, False)
            if new and new[0].value < state.value:
                return new
        return None

    def _halved(self, state: SurfaceMean, way: Way, number: int, share: float = 1.0) -> tuple[State | None, bool]:
        """Return the state after a step, halved until the sum does not grow, or None; whether it leaves the surface.

        way : returns the point at a length, None off the surface. share : of the length of the step.
        """
        length = share * state.last_step
        for _ in range(HALVINGS):
            point = way(length)
            if point is None:
                return None, True
            new = self._at(point, number, self.radius(state.value))
            flat = new[0].value > state.value * (1 - ROUNDING)
            if new[0].value <= state.value * (1 + ROUNDING) and not (flat and new[0].last_step >= state.last_step):
                return new, False
            length /= 2
        return None, False

    def _ways_to_corners(self, point: SurfacePoints) -> list[tuple[float, Way]]:
        """Return the angle to each corner of the faces that hold a point, and the straight way to it."""
        mesh, here, at = self.mesh, point.positions(self.mesh)[0], point.corners[0, 0]
        faces = point.faces if point.faces[0] >= 0 else np.flatnonzero((mesh.faces == at).any(axis=1))
        longest = float(mesh.edge_lengths[mesh.edge_table.of_faces[faces]].max())
        angle, ways = np.asarray(self._log.from_source(point, longest)["angle"]), list[tuple[float, Way]]()
        for face in faces.tolist():
            corners = mesh.faces[face]
            start = point.weights[0] if point.faces[0] >= 0 else np.where(corners == at, 1.0, 0.0)
            for end, v in zip(np.eye(3), corners.tolist(), strict=True):
                reach = float(np.linalg.norm(mesh.vertices[v] - here))
                if reach > 0 and np.isfinite(angle[v]):
                    ways.append((float(angle[v]), partial(_on_the_way, mesh, face, start, end, reach)))
        return ways

    def _in_any_direction(self, state: SurfaceMean, number: int) -> State | None:
        """Return the state of least sum of some directions; None if the sum decreases in none.

        At a vertex with an angle far from 2π, and at the boundary, the mean of the logarithms may not be one.
        Directions are relative to those of the points, so that they do not depend on the order of faces.
        """
        if state.last_step <= NEGLIGIBLE * state.distances.max():
            return None
        angles = np.asarray(self._log.from_source(state.point, self.radius(state.value))["angle"])[self.targets]
        to_points = np.degrees(angles[np.isfinite(angles)])
        directions = [*to_points[:DIRECTIONS].tolist(), *(to_points[:1] + EVEN_DIRECTIONS).tolist()]
        for share in SHARES:
            ends = [self._traced(state.point, degrees, share * state.last_step) for degrees in directions]
            states = [self._at(end, number, self.radius(state.value)) for end in ends if end is not None]
            best = min(states, key=lambda item: item[0].value, default=None)
            if best and best[0].value < state.value * (1 - ROUNDING):
                return best
        return None

    def _traced(self, point: SurfacePoints, degrees: float, length: float) -> SurfacePoints | None:
        """Return the end of a straightest line; None off the boundary."""
        try:
            return self._lines.trace_angle(point, degrees, length).end(-1)
        except ArgumentError:
            return None

    def _at(self, point: SurfacePoints, number: int, radius: float) -> State:
        """Return the state at a point, and the next step as a vector in the frame of the logarithmic map.

        The sum is infinite if a given point is beyond the radius.
        """
        result = self._log.from_source(point, radius)
        d, log = np.asarray(result["radius"])[self.targets], np.asarray(result["log"])[self.targets]
        away = (d > 0) & np.isfinite(log).all(axis=1)
        if not self.median:
            step, value = log[away].sum(axis=0) / len(d), float((d**2).sum())
        else:
            pull, at = (log[away] / d[away, None]).sum(axis=0), len(d) - np.count_nonzero(away)
            strength = float(np.linalg.norm(pull))
            share = max(1 - at / strength, 0.0) if strength > 0 else 0.0
            step, value = share * pull / max(float((1 / d[away]).sum()), np.finfo(float).tiny), float(d.sum())
        return SurfaceMean(point, value, d, float(np.linalg.norm(step)), number), step


def _on_the_way(
    mesh: TriangleMesh, face: int, start: Floats, end: Floats, reach: float, length: float
) -> SurfacePoints:
    """Return the point at a length on the straight way within a face, of length ``reach``, or its end."""
    return face_point(mesh, face, start + (end - start) * min(length / reach, 1.0))
