"""Polylines in space as curves on a surface: closest points, joined within faces or by shortest paths."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.curves.plane_walk import PlaneWalk, Step
from geomhw.errors import FieldError
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.geodesic.surface_path import SurfacePath
from geomhw.mesh.geometry import lengths
from geomhw.mesh.nearest import bounding_box, nearest_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Distance from the surface, in diagonals of the mesh, beyond which a polyline is no curve on the surface.
FARTHEST = 0.1
#: Distance, in diagonals, from which the bounding box is as far as the surface, to the digits of a message.
VERY_FAR = 1e4


@dataclass(frozen=True, eq=False)
class TracedCurve:
    """A curve on a mesh, and the largest distance of the given points from the surface.

    Attributes
    ----------
    path : SurfacePath
    distance : float
    """

    path: SurfacePath
    distance: float

    @property
    def closed(self) -> bool:
        """Whether it ends where it starts."""
        return bool((self.path.positions[0] == self.path.positions[-1]).all())


def trace_polyline(mesh: TriangleMesh, points: ArrayLike, name: str = "the curve") -> TracedCurve:
    """Project a polyline to a surface.

    Each point moves to the closest point of the surface. Consecutive points in one face are joined within it. Those a
    few faces apart are joined in the plane of both and of the normal, others by a shortest path.

    Parameters
    ----------
    mesh : TriangleMesh
    points : (k, 3) array of coordinates
        The last one equals the first if the curve is closed.
    name : of the curve, for messages.

    Raises
    ------
    FieldError
        If the curve has fewer than two different points, a coordinate is not finite, a point is farther from the
        surface than a tenth of the diagonal of the mesh, or consecutive points lie on different components.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> trace_polyline(grid(2, 2), [[0.1, 0.4, 0.01], [0.9, 0.4, 0]]).path.length.__round__(6)
    0.8
    """
    return trace_polylines(mesh, [points], [name])[0]


def trace_polylines(mesh: TriangleMesh, polylines: Sequence[ArrayLike], names: Sequence[str]) -> list[TracedCurve]:
    """Project polylines to a surface as `trace_polyline` does, in less time than one by one."""
    lines = [np.asarray(points, dtype=float).reshape(-1, 3) for points in polylines]
    low, high = bounding_box(mesh)
    diagonal, walk, begin, curves = float(np.linalg.norm(high - low)), PlaneWalk(mesh), 0, []
    for places, name in zip(lines, names, strict=True):
        if not len(places):
            raise FieldError(f"{name} has no point")
        for k in np.flatnonzero(~np.isfinite(places).all(axis=1))[:1]:
            raise FieldError(f"point {k} of {name} has the coordinates {places[k].tolist()}; a point has finite ones")
        with np.errstate(over="ignore"):
            beyond = np.hypot.reduce(np.maximum(np.maximum(low - places, places - high), 0), axis=1)
        if beyond.max() > VERY_FAR * diagonal:
            _raise_far(beyond, diagonal, name)
    found = nearest_points(mesh, np.concatenate(lines))
    for places, name in zip(lines, names, strict=True):
        points = found[np.arange(begin, begin + len(places))]
        distances = lengths(points.positions(mesh) - places)
        if distances.max() > FARTHEST * diagonal:
            _raise_far(distances, diagonal, name)
        curves.append(TracedCurve(_joined(walk, points, name), float(distances.max())))
        begin += len(places)
    return curves


def _raise_far(distances: Floats, diagonal: float, name: str) -> NoReturn:
    """Raise FieldError for the farthest point of a curve."""
    worst = int(distances.argmax())
    raise FieldError(
        f"point {worst} of {name} is {distances[worst]:.4g} from the surface, "
        f"{distances[worst] / diagonal:.2g} diagonals of the mesh; a curve lies on the surface or near it"
    )


def trace_points(mesh: TriangleMesh, points: SurfacePoints, name: str = "the curve") -> TracedCurve:
    """Return the curve through points of the surface; consecutive ones are joined as in `trace_polyline`."""
    return TracedCurve(_joined(PlaneWalk(mesh), points, name), 0.0)


def _joined(walk: PlaneWalk, points: SurfacePoints, name: str) -> SurfacePath:
    """Return the curve through points: consecutive ones are joined in a face, in a plane, or by a shortest path."""
    mesh, places = walk.mesh, points.corner_weights()
    kept = [0]
    for k in range(1, len(places)):
        if places[k] != places[kept[-1]]:
            kept.append(k)
    if len(kept) < 2:
        raise FieldError(f"{name} has one point on the surface; a curve has at least two")
    parts: list[list[Step]] = []
    for i, j in pairwise(kept):
        shared = walk.shared_face(places[i], places[j])
        parts.append([(shared, places[i])] if shared >= 0 else walk.between(places[i], places[j]))
    apart = [k for k, part in enumerate(parts) if not part]
    for k, path in _shortest(mesh, points, kept, apart, name).items():
        rows = zip(path.faces[:-1].tolist(), path.weights[:-1].tolist(), strict=True)
        parts[k] = [(f, dict(zip(mesh.faces[f].tolist(), weights, strict=True))) for f, weights in rows]
    steps = [step for part in parts for step in part]
    steps.append((steps[-1][0], places[kept[-1]]))
    faces = np.array([face for face, _ in steps])
    ends = zip(mesh.faces[faces].tolist(), (place for _, place in steps), strict=True)
    return SurfacePath(mesh, faces, np.array([[place.get(v, 0.0) for v in corners] for corners, place in ends]))


def _shortest(
    mesh: TriangleMesh, points: SurfacePoints, kept: list[int], apart: list[int], name: str
) -> dict[int, SurfacePath]:
    """Return the shortest paths of segments between points that share no face."""
    if not apart:
        return {}
    begins, ends = (points[np.array([kept[k + step] for k in apart])] for step in (0, 1))
    parts = mesh.components
    if len(bad := np.flatnonzero(parts[begins.corners[:, 0]] != parts[ends.corners[:, 0]])):
        k = apart[bad[0]]
        raise FieldError(f"points {kept[k]} and {kept[k + 1]} of {name} lie on different components")
    return dict(zip(apart, ShortestPaths(mesh).between(begins, ends), strict=True))
