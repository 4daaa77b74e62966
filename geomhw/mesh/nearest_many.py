"""Closest points of a triangle mesh to many points in space, by trees of face centers."""

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.mesh.geometry import lengths
from geomhw.mesh.nearest import _on_edges, _on_planes
from geomhw.mesh.surface_points import SNAP
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Pairs of a point and a face that are compared at once.
PAIRS = 1 << 18


def nearest_faces(mesh: TriangleMesh, points: ArrayLike) -> tuple[Ints, Floats, Floats]:
    """Find the points of the surface closest to points in space.

    Parameters
    ----------
    mesh : TriangleMesh
    points : (k, 3) array

    Returns
    -------
    faces : (k,) integer array
        Of equally close faces, the lowest.
    weights : (k, 3) array
        Barycentric coordinates there; those below 1e-9 are 0.
    distances : (k,) array

    Raises
    ------
    ArgumentError
        If a coordinate is not finite.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> faces, weights, distances = nearest_faces(grid(1, 1), [[0.75, 0.25, 9.0], [0, 0, 1]])
    >>> distances.tolist()
    [9.0, 1.0]
    """
    from scipy.spatial import cKDTree

    places = np.asarray(points, dtype=float).reshape(-1, 3)
    if not np.isfinite(places).all():
        bad = int(np.argmin(np.isfinite(places).all(axis=1)))
        raise ArgumentError(f"point {bad} of a curve has a coordinate that is not a finite number")
    X, k = mesh.vertices, len(places)
    used = np.unique(mesh.faces)
    bound = cKDTree(X[used]).query(places)[0]
    centers = mesh.face_centers
    radii = lengths((X[mesh.faces] - centers[:, None]).reshape(-1, 3)).reshape(-1, 3).max(axis=1)
    # Faces of similar radius share a tree: a face is as close as the closest vertex only if its center is within the
    # bound and its radius.
    octave = np.floor(np.log2(np.maximum(radii, np.finfo(float).tiny))).astype(int)
    face, weights, best = np.zeros(k, dtype=np.int64), np.zeros((k, 3)), np.full(k, np.inf)
    for size in np.unique(octave):
        members = np.flatnonzero(octave == size)
        tree = cKDTree(centers[members])
        reach = (bound + radii[members].max()) * (1 + 1e-9)
        counts = tree.query_ball_point(places, reach, return_length=True)
        splits = np.searchsorted(np.cumsum(counts), np.arange(PAIRS, counts.sum(), PAIRS)) + 1
        for rows in np.split(np.arange(k), np.unique(splits)):
            found = tree.query_ball_point(places[rows], reach[rows])
            point = np.repeat(rows, [len(item) for item in found])
            if len(point):
                candidate = members[np.concatenate(found).astype(np.int64)]
                _improve(mesh, places, point, candidate, face, weights, best)
    weights[weights < SNAP] = 0.0
    return face, weights / weights.sum(axis=1, keepdims=True), np.sqrt(best)


def _improve(
    mesh: TriangleMesh, places: Floats, point: Ints, candidate: Ints, face: Ints, weights: Floats, best: Floats
) -> None:
    """Put the closest of the candidates of each point, (c,), in place if it is closer, or as close and lower."""
    corners = mesh.vertices[mesh.faces[candidate]] - places[point][:, None]
    share, to_edge = _on_edges(corners)
    on_plane, to_plane = _on_planes(corners, mesh.face_normals[candidate])
    near = np.minimum(to_edge.min(axis=1), to_plane)
    order = np.lexsort((candidate, near, point))
    first = order[np.diff(point[order], prepend=-1) > 0]
    p, f, d = point[first], candidate[first], near[first]
    first = first[(d < best[p]) | ((d == best[p]) & (f < face[p]))]
    p, edge, rows = point[first], to_edge[first].argmin(axis=1), np.arange(len(first))
    found = np.zeros((len(first), 3))
    found[rows, edge], found[rows, (edge + 1) % 3] = 1 - share[first, edge], share[first, edge]
    inside = to_plane[first] <= near[first]
    found[inside] = on_plane[first][inside]
    face[p], best[p] = candidate[first], near[first]
    weights[p] = found / found.sum(axis=1, keepdims=True)
