"""Polylines in space as curves on a surface: closest points, joined within faces or by shortest paths."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.geodesic.shortest_paths import ShortestPaths
from geomhw.geodesic.surface_path import SurfacePath
from geomhw.mesh.curve_points import curve_points
from geomhw.mesh.nearest_many import nearest_faces
from geomhw.mesh.surface_points import bounding_box
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Distance from the surface, in diagonals of the mesh, beyond which a polyline is no curve on the surface.
FARTHEST = 0.1


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

    Each point moves to the closest point of the surface. Consecutive points in one face are joined within it, others by
    a shortest path.

    Parameters
    ----------
    mesh : TriangleMesh
    points : (k, 3) array of coordinates
        The last one equals the first if the curve is closed.
    name : of the curve, for messages.

    Raises
    ------
    FieldError
        If the curve has fewer than two different points, is farther from the surface than a tenth of the diagonal of
        the mesh, or consecutive points lie on different components.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> trace_polyline(grid(2, 2), [[0.1, 0.4, 0.01], [0.9, 0.4, 0]]).path.length.__round__(6)
    0.8
    """
    places = np.asarray(points, dtype=float).reshape(-1, 3)
    faces, weights, distances = nearest_faces(mesh, places)
    low, high = bounding_box(mesh)
    diagonal = float(np.linalg.norm(high - low))
    worst = int(distances.argmax()) if len(distances) else 0
    if len(distances) and distances[worst] > FARTHEST * diagonal:
        raise FieldError(
            f"point {worst} of {name} is {distances[worst]:.4g} from the surface, {distances[worst] / diagonal:.2g} "
            "diagonals of the mesh; a curve lies on the surface or near it"
        )
    path = _joined(mesh, faces, weights, name)
    return TracedCurve(path, float(distances.max()))


def curve_through_faces(mesh: TriangleMesh, faces: Ints, weights: Floats, name: str = "the curve") -> TracedCurve:
    """Return the curve through points in barycentric coordinates, (k,) and (k, 3); as `trace_polyline`."""
    return TracedCurve(_joined(mesh, faces, weights, name), 0.0)


def _joined(mesh: TriangleMesh, faces: Ints, weights: Floats, name: str) -> SurfacePath:
    """Return the curve through points, consecutive ones of which are joined in a face or by a shortest path."""
    order = np.argsort(mesh.faces, axis=None, kind="stable")
    starts = np.searchsorted(mesh.faces.ravel()[order], np.arange(mesh.n_vertices + 1))
    corners = mesh.faces.tolist() if len(faces) > mesh.n_faces else None

    def of(face: int) -> list[int]:
        return corners[face] if corners else mesh.faces[face].tolist()

    places = [
        {v: w for v, w in zip(of(f), share, strict=True) if w > 0}
        for f, share in zip(faces.tolist(), weights.tolist(), strict=True)
    ]
    kept = [0] if places else []
    for k in range(1, len(places)):
        if places[k] != places[kept[-1]]:
            kept.append(k)
    if len(kept) < 2:
        raise FieldError(f"{name} has one point on the surface; a curve has at least two")

    def common(one: dict[int, float], other: dict[int, float]) -> int:
        """The lowest face that contains two points, or -1."""
        support = {*one, *other}
        if len(support) > 3:
            return -1
        v = next(iter(one))
        around = np.sort(order[starts[v] : starts[v + 1]] // 3).tolist()
        return next((f for f in around if support <= set(of(f))), -1)

    within = [common(places[i], places[j]) for i, j in pairwise(kept)]
    apart = [k for k, face in enumerate(within) if face < 0]
    between = _shortest(mesh, faces, weights, kept, apart, name)
    path_faces: list[int] = []
    path_weights: list[list[float]] = []
    for k, face in enumerate(within):
        if face >= 0:
            path_faces.append(face)
            path_weights.append([places[kept[k]].get(v, 0.0) for v in of(face)])
        else:
            path_faces += between[k].faces[:-1].tolist()
            path_weights += between[k].weights[:-1].tolist()
    last = between[len(within) - 1] if within[-1] < 0 else None
    path_faces.append(int(last.faces[-1]) if last else within[-1])
    end = last.weights[-1].tolist() if last else [places[kept[-1]].get(v, 0.0) for v in of(within[-1])]
    return SurfacePath(mesh, np.array(path_faces), np.array([*path_weights, end]))


def _shortest(
    mesh: TriangleMesh, faces: Ints, weights: Floats, kept: list[int], apart: list[int], name: str
) -> dict[int, SurfacePath]:
    """Return the shortest path of each segment between points that share no face."""
    if not apart:
        return {}
    points = curve_points(mesh, faces[kept], weights[kept])
    begins = np.array(apart)
    parts = mesh.components[points.corners[:, 0]]
    if len(bad := begins[parts[begins] != parts[begins + 1]]):
        raise FieldError(f"points {kept[bad[0]]} and {kept[bad[0] + 1]} of {name} lie on different components")
    found = ShortestPaths(mesh).between(points[begins], points[begins + 1])
    return dict(zip(apart, found, strict=True))
