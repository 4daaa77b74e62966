"""Deterministic, evenly distributed sample points on a surface."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.hilbert_curve import hilbert_keys
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Candidates per point, rounds of Lloyd relaxation, and the largest number of points that are relaxed.
CANDIDATES, ROUNDS, MOST_RELAXED = 12, 4, 20_000
#: Steps of a two-dimensional low-discrepancy sequence.
_STEPS = (1 / 1.324717957244746, 1 / 1.324717957244746**2)  # of the plastic number


def area_samples(mesh: TriangleMesh, count: int, order: Ints | None = None) -> tuple[Ints, Floats]:
    """Return faces, (count,), and barycentric coordinates, (count, 3), of points with equal shares of the area.

    Points are equally spaced along the cumulative face areas, in the given ``order`` of the faces, (m,), by default
    that of the mesh. On a mesh of zero area all points lie in the first face.
    """
    k = np.arange(count)
    order = np.arange(mesh.n_faces) if order is None else order
    total = np.cumsum(mesh.face_areas[order])
    face = order[np.minimum(np.searchsorted(total, (k + 0.5) / count * total[-1]), mesh.n_faces - 1)]
    u, v = ((0.5 + k * step) % 1 for step in _STEPS)
    # Fold the unit square to a triangle.
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return face, np.stack([1 - u - v, u, v], axis=1)


def spread_samples(mesh: TriangleMesh, count: int) -> tuple[Ints, Floats]:
    """Return points with nearly equal area and mutual distance, in the format of `area_samples`.

    Faces are ordered along the Hilbert curve. One of each ``CANDIDATES`` consecutive samples is chosen. It moves to the
    centroid of the samples closest to it, for ``ROUNDS`` rounds of Lloyd relaxation [Lloyd 1982]. More than
    ``MOST_RELAXED`` points are not relaxed.
    """
    along = np.argsort(hilbert_keys(mesh.face_centers), kind="stable")
    if count > MOST_RELAXED:
        return area_samples(mesh, count, along)
    faces, weights = area_samples(mesh, count * CANDIDATES, along)
    chosen = _relaxed(points_on(mesh, faces, weights), np.arange(count) * CANDIDATES + CANDIDATES // 2)
    return faces[chosen], weights[chosen]


def _relaxed(samples: Floats, chosen: Ints) -> Ints:
    """Move the chosen samples, (count,), by Lloyd relaxation over all samples, (k, 3), and keep them distinct."""
    from scipy.spatial import cKDTree

    tree, count = cKDTree(samples), len(chosen)
    for _ in range(ROUNDS):
        owner = cKDTree(samples[chosen]).query(samples)[1]
        total = np.stack([np.bincount(owner, weights=x, minlength=count) for x in samples.T], axis=1)
        size = np.bincount(owner, minlength=count)[:, None]
        moved = tree.query(np.where(size > 0, total / np.maximum(size, 1), samples[chosen]))[1]
        alone = np.bincount(moved, minlength=len(samples))[moved] == 1
        chosen = np.where(alone, moved, chosen)
    return chosen


def points_on(mesh: TriangleMesh, faces: Ints, weights: Floats) -> Floats:
    """Return the positions, (k, 3), of points with barycentric coordinates, (k, 3), in faces, (k,)."""
    return np.asarray(np.einsum("pk,pkx->px", weights, mesh.vertices[mesh.faces[faces]]))
