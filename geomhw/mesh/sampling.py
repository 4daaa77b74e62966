"""Points spread evenly over a surface, the same ones every time."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.hilbert_curve import hilbert_keys
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Samples a point from which points that keep their distance are chosen, rounds of that, and for how many points.
CANDIDATES, ROUNDS, MOST_RELAXED = 12, 4, 20_000
#: Two sequences with these steps fill the unit square evenly.
_STEPS = (1 / 1.324717957244746, 1 / 1.324717957244746**2)  # of the plastic number


def area_samples(mesh: TriangleMesh, count: int, order: Ints | None = None) -> tuple[Ints, Floats]:
    """Faces (count,) and barycentric coordinates (count, 3) of points of which each stands for the same area.

    order: the faces in the order, (m,), in which their areas are laid end to end and the points set at equal distances;
    None takes that of the mesh. On a mesh without area the first face has them all.
    """
    k = np.arange(count)
    order = np.arange(mesh.n_faces) if order is None else order
    total = np.cumsum(mesh.face_areas[order])
    face = order[np.minimum(np.searchsorted(total, (k + 0.5) / count * total[-1]), mesh.n_faces - 1)]
    u, v = ((0.5 + k * step) % 1 for step in _STEPS)
    # The square is folded to a triangle.
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return face, np.stack([1 - u - v, u, v], axis=1)


def spread_samples(mesh: TriangleMesh, count: int) -> tuple[Ints, Floats]:
    """Points of nearly the same area each that also keep their distance from each other, as `area_samples` gives them.

    Area is laid out along Hilbert's curve through the mesh's bounding cube; of a dozen samples a point, those in the
    middle of each dozen are chosen, and moved, a few times, to the middle of the samples nearest to them [Lloyd 1982].
    More than ``MOST_RELAXED`` points stay where they are chosen.
    """
    along = np.argsort(hilbert_keys(mesh.face_centers), kind="stable")
    if count > MOST_RELAXED:
        return area_samples(mesh, count, along)
    faces, weights = area_samples(mesh, count * CANDIDATES, along)
    chosen = _relaxed(points_on(mesh, faces, weights), np.arange(count) * CANDIDATES + CANDIDATES // 2)
    return faces[chosen], weights[chosen]


def _relaxed(samples: Floats, chosen: Ints) -> Ints:
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
    """Σ_k b_k x_k, (k, 3): where barycentric coordinates, (k, 3), put points on faces, (k,)."""
    return np.asarray(np.einsum("pk,pkx->px", weights, mesh.vertices[mesh.faces[faces]]))
