"""Closest points of a triangle mesh to points in space."""

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError
from geomhw.mesh.named_points import face_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Distance, in diagonals of the bounding box, from which no point of the surface is the nearest up to rounding.
FARTHEST = 1e6


def nearest_point(mesh: TriangleMesh, point: ArrayLike) -> SurfacePoints:
    """Find the point of the surface closest to a point in space, (3,); of equally close faces, the lowest.

    Raises
    ------
    ArgumentError
        If ``point`` does not have three finite coordinates, or is a million diagonals of the bounding box away.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> nearest_point(grid(1, 1), [0.75, 0.25, 9.0]).positions(grid(1, 1))
    array([[0.75, 0.25, 0.  ]])
    """
    return nearest_points(mesh, np.asarray([point]))


def nearest_points(mesh: TriangleMesh, points: ArrayLike) -> SurfacePoints:
    """Find the closest points of the surface to points in space, (k, 3); it raises as `nearest_point` does."""
    from geomhw.mesh.closest_faces import closest_faces

    places = near_places(points, *bounding_box(mesh))
    return face_points(mesh, *closest_faces(mesh, places))


def near_places(points: ArrayLike, low: Floats, high: Floats) -> Floats:
    """Check points in space, (k, 3), against the bounding box of a mesh as `nearest_point` does, and return them."""
    places = np.asarray(points, dtype=float)
    if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
        wrong = places[~np.isfinite(places).all(axis=1)] if places.shape[1:] == (3,) else places
        raise ArgumentError(f"a point in space has three finite coordinates, not {wrong[0].tolist()}")
    diagonal = float(np.linalg.norm(high - low))
    with np.errstate(over="ignore"):
        distance = np.hypot.reduce(places - (low + high) / 2, axis=1)
    for k in np.flatnonzero(distance > FARTHEST * diagonal if diagonal > 0 else [])[:1]:
        raise ArgumentError(
            f"the point {', '.join(f'{x:g}' for x in places[k])} is {distance[k]:.3g} away from the mesh, whose "
            f"bounding box has a diagonal of {diagonal:.3g}; give a point near the surface"
        )
    return places


def bounding_box(mesh: TriangleMesh) -> tuple[Floats, Floats]:
    """Return the corner of least and the corner of largest coordinates of the vertices on faces, (3,) each."""
    used = mesh.vertices[np.unique(mesh.faces)]
    return used.min(axis=0), used.max(axis=0)
