"""Karcher mean and geometric median of points on a surface, by exact logarithmic and exponential maps.

Karcher: Riemannian Center of Mass and Mollifier Smoothing. Comm. Pure Appl. Math. 30(5), 1977.
Weiszfeld: Sur le point pour lequel la somme des distances de n points donnés est minimum. Tohoku Math. J. 43, 1937.
Vardi, Zhang: The Multivariate L1-Median and Associated Data Depth. PNAS 97(4), 2000.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.straightest import StraightestGeodesics
from geomhw.mesh.inserted_points import InsertedPoints, insert_points
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.surface_points import SurfacePoints, concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.transport.log_map import LogarithmicMap

#: Starts are the vertices of least value among their neighbors, within this share of the least one, and their number.
BAND, STARTS = 0.05, 8
#: Steps, at most, and halvings of a step.
STEPS, HALVINGS = 500, 30
#: Steps end at this length, and values are equal up to this share.
SHORTEST, ROUNDING, EQUAL = 1e-14, 1e-14, 1e-9
#: Minima at a larger distance differ, as a share of the largest distance of a point.
APART = 1e-5


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


def karcher_mean(mesh: TriangleMesh, points: SurfacePoints) -> SurfaceMean:
    """Return the point of least sum of squared exact distances from given points.

    The iteration starts at the vertex of least sum. It steps along the straightest geodesic whose vector is the mean of
    the logarithmic map, halved until the sum does not grow, up to rounding. It is repeated from other vertices that are
    the least among their neighbors and nearly as good.

    Parameters
    ----------
    mesh : TriangleMesh
    points : k points, vertices or within faces.

    Raises
    ------
    ArgumentError
        If there is no point.
    FieldError
        If no path connects two of the points.

    References
    ----------
    Karcher: Riemannian Center of Mass and Mollifier Smoothing. Comm. Pure Appl. Math. 30(5), 1977.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> square = grid(2, 2)
    >>> karcher_mean(square, vertex_points(square, [0, 2, 6, 8])).point.report()
    [4]
    """
    return _center(mesh, points, median=False)


def geometric_median(mesh: TriangleMesh, points: SurfacePoints) -> SurfaceMean:
    """Return the point of least sum of exact distances from given points; parameters and errors as `karcher_mean`.

    The steps are those of Weiszfeld, at a given point those of Vardi and Zhang.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> square = grid(2, 2)
    >>> geometric_median(square, vertex_points(square, [0, 4, 5])).point.report()
    [4]
    """
    return _center(mesh, points, median=True)


def _center(mesh: TriangleMesh, points: SurfacePoints, median: bool) -> SurfaceMean:
    """Minimize from several starts; return the best minimum."""
    if not len(points):
        raise ArgumentError("there is no point to take the mean of")
    inserted = insert_points(mesh, points)
    search = _Search(inserted.mesh, inserted.vertices, median)
    found = [search.minimum(int(v)) for v in _starts(search)]
    best = min(found, key=lambda item: item.value)
    places = [original_point(mesh, inserted, item.point) for item in found]
    point = places[found.index(best)]
    others, scale = [point], APART * float(best.distances.max())
    for item, place in zip(found, places, strict=True):
        away = [np.linalg.norm(place.positions(mesh) - other.positions(mesh)) for other in others]
        if item.value <= best.value * (1 + EQUAL) and min(away) > scale:
            others.append(place)
    rest = concatenate(others[1:]) if others[1:] else None
    return SurfaceMean(point, best.value, best.distances, best.last_step, best.steps, rest)


def original_point(mesh: TriangleMesh, inserted: InsertedPoints, point: SurfacePoints) -> SurfacePoints:
    """Return a point of a divided mesh as one of the mesh before."""
    face, corner = int(point.faces[0]), point.weights[0]
    if face < 0:
        if (v := int(point.vertices[0])) < mesh.n_vertices:
            return vertex_points(mesh, [v])
        face, k = np.argwhere(inserted.mesh.faces == v)[0].tolist()
        corner = np.eye(3)[k]
    return face_point(mesh, int(inserted.parents[face]), corner @ inserted.corners[face])


def _starts(search: "_Search") -> Ints:
    """Vertices to start from, the best first."""
    mesh = search.mesh
    distances = ExactDistance(mesh).rows([vertex_points(mesh, [v]) for v in search.targets.tolist()])
    if np.isinf(distances[0, search.targets]).any():
        k = int(np.isinf(distances[0, search.targets]).argmax())
        raise FieldError(f"no path connects point 0 with point {k}: they lie on different components")
    values = distances.sum(axis=0) if search.median else (distances**2).sum(axis=0)
    least, (a, b) = np.full(len(values), inf), mesh.edges.T
    np.minimum.at(least, a, values[b])
    np.minimum.at(least, b, values[a])
    (local,) = np.nonzero((values <= least) & np.isfinite(values))
    local = local[np.argsort(values[local], kind="stable")]
    return np.asarray(local[values[local] <= values[local[0]] * (1 + BAND)][:STARTS])


class _Search:
    """Minimization over a mesh of which the given points are vertices."""

    def __init__(self, mesh: TriangleMesh, targets: Ints, median: bool) -> None:
        self.mesh, self.targets, self.median = mesh, targets, median
        self._log, self._lines = LogarithmicMap(mesh), StraightestGeodesics(mesh)

    def minimum(self, v: int) -> SurfaceMean:
        """Return the minimum to which the iteration from a vertex converges."""
        here = self._at(vertex_points(self.mesh, [v]), 0)
        for steps in range(1, STEPS + 1):
            if np.linalg.norm(here[1]) <= SHORTEST * here[0].distances.max():
                break
            following = self._step(*here, steps)
            if following is None:
                break
            here = following
        return here[0]

    def _step(self, state: SurfaceMean, step: Floats, number: int) -> tuple[SurfaceMean, Floats] | None:
        """Return the state after a step that does not increase the sum; None if there is none."""
        length, degrees = state.last_step, float(np.degrees(np.arctan2(step[1], step[0])))
        for _ in range(HALVINGS):
            try:
                end = self._lines.trace_angle(state.point, degrees, length).end(-1)
            except ArgumentError:  # off the boundary
                return None
            new = self._at(end, number)
            flat = new[0].value > state.value * (1 - ROUNDING)
            if new[0].value <= state.value * (1 + ROUNDING) and not (flat and new[0].last_step >= state.last_step):
                return new
            length /= 2
        return None

    def _at(self, point: SurfacePoints, number: int) -> tuple[SurfaceMean, Floats]:
        """Return the state at a point, and the next step as a vector in the frame of the logarithmic map."""
        result = self._log.from_source(point)
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
