"""Arrows, comets and lines as triangles, and even thinning of points."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import unit

#: Outline of an arrow along +x of length 1, centered at the origin: shaft and head, (corners, 2).
_SHAFT, _HEAD, _NOTCH = 0.05, 0.21, 0.06
_OUTLINE = np.array(
    [
        [-0.5, -_SHAFT],
        [_NOTCH, -_SHAFT],
        [_NOTCH, _SHAFT],
        [-0.5, _SHAFT],
        [0.0, -_HEAD],
        [0.5, 0.0],
        [0.0, _HEAD],
        [_NOTCH, 0.0],
    ]
)
#: Number of corners of the head of a comet.
_ROUND = 12
_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 7], [7, 5, 6]])


def arrow_triangles(centers: Floats, vectors: Floats, normals: Floats) -> tuple[Floats, Ints]:
    """Return points and triangles of flat arrows with the given vectors, perpendicular to the normals."""
    across = unit(np.cross(normals, vectors)) * np.linalg.norm(vectors, axis=1, keepdims=True)
    points = centers[:, None] + _OUTLINE[:, :1] * vectors[:, None] + _OUTLINE[:, 1:] * across[:, None]
    triangles = len(_OUTLINE) * np.arange(len(centers))[:, None, None] + _TRIANGLES
    return points.reshape(-1, 3), triangles.reshape(-1, 3)


def ribbons(segments: Floats, width: float) -> tuple[Floats, Ints]:
    """Return points and triangles of segments, (s, 2, 3), as strips of a width in planes of constant z.

    Strips are longer by half their width, so that those of a curve overlap.
    """
    along = segments[:, 1] - segments[:, 0]
    ahead = 0.25 * width * unit(along * [1, 1, 0])
    side = 2 * np.stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))], axis=1)
    start, end = segments[:, 0] - ahead, segments[:, 1] + ahead
    points = np.stack([start - side, end - side, end + side, start + side], axis=1)
    triangles = 4 * np.arange(len(points))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return points.reshape(-1, 3), triangles.reshape(-1, 3)


def strips(points: Floats, segments: Ints, widths: Floats) -> tuple[Floats, Ints]:
    """Return points and triangles of polylines as strips in planes of constant z.

    points: (k, 3). segments: the first point of each, which the next follows. widths: of the strips at points, (k,).
    """
    ahead = np.zeros((len(points), 3))
    along = points[segments + 1] - points[segments]
    np.add.at(ahead, segments, along)
    np.add.at(ahead, segments + 1, along)
    ahead = unit(ahead * [1, 1, 0])
    side = 0.5 * widths[:, None] * np.stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))], axis=1)
    left, right = 2 * segments, 2 * segments + 1
    triangles = np.stack([left, right, right + 2, left, right + 2, left + 2], axis=1).reshape(-1, 3)
    return np.stack([points - side, points + side], axis=1).reshape(-1, 3), triangles


def head_triangles(centers: Floats, vectors: Floats, normals: Floats) -> tuple[Floats, Ints]:
    """Return points and triangles of heads of arrows with the given vectors, perpendicular to the normals."""
    across = unit(np.cross(normals, vectors)) * np.linalg.norm(vectors, axis=1, keepdims=True)
    outline = np.array([[0.5, 0.0], [-0.5, 0.42], [-0.25, 0.0], [-0.5, -0.42]])
    points = centers[:, None] + outline[:, :1] * vectors[:, None] + outline[:, 1:] * across[:, None]
    triangles = 4 * np.arange(len(centers))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return points.reshape(-1, 3), triangles.reshape(-1, 3)


def comets(paths: Floats, radii: Floats) -> tuple[Floats, Ints, Floats]:
    """Return points, triangles and opacity of comets in planes of constant z.

    Each comet has a disc of the given radius, (k,), at the end of its path, (p, k, 3), and a tail along the path. Width
    and opacity of the tail grow linearly with arc length from zero.
    """
    p, k = paths.shape[:2]
    share = _share_of_length(paths[..., :2])
    across = _across(paths[..., :2]) * (radii * share)[..., None]
    sides = np.stack([paths - across, paths + across], axis=2)  # (p, k, 2, 3)
    left = 2 * np.arange(p * k).reshape(p, k)
    a, b, c, d = left[:-1], left[:-1] + 1, left[1:], left[1:] + 1
    tails = np.stack([a, c, b, b, c, d], axis=-1).reshape(-1, 3)
    angle = np.linspace(0, 2 * np.pi, _ROUND, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(_ROUND)], axis=1)
    heads = paths[-1][:, None] + radii[:, None, None] * rim
    corner = np.arange(1, _ROUND - 1)
    fan = np.stack([np.zeros_like(corner), corner, corner + 1], axis=1)
    discs = 2 * p * k + _ROUND * np.arange(k)[:, None, None] + fan
    points = np.concatenate([sides.reshape(-1, 3), heads.reshape(-1, 3)])
    density = np.concatenate([np.repeat(share.ravel(), 2), np.ones(_ROUND * k)])
    return points, np.concatenate([tails, discs.reshape(-1, 3)]), density


def _share_of_length(paths: Floats) -> Floats:
    """Return the arc length of paths up to each point, (p, k), as a fraction; zero on a path of length zero."""
    run = np.zeros(paths.shape[:2])
    np.cumsum(np.linalg.norm(np.diff(paths, axis=0), axis=2), axis=0, out=run[1:])
    return np.divide(run, run[-1], out=np.zeros_like(run), where=run[-1] > 0)


def _across(paths: Floats) -> Floats:
    """Return unit vectors to the left of plane paths, (p, k, 3) from (p, k, 2)."""
    ahead = unit(np.gradient(paths, axis=0)) if len(paths) > 1 else np.zeros_like(paths)
    return np.stack([-ahead[..., 1], ahead[..., 0], np.zeros(paths.shape[:2])], axis=2)


def spread(points: Floats, distance: float) -> Ints:
    """Select points at least ``distance`` apart, as many as possible in a fixed random order; ascending indices."""
    from scipy.spatial import cKDTree

    chosen = _one_per_cell(points, distance / 3)
    kept = points[chosen]
    pairs = cKDTree(kept).query_pairs(distance, output_type="ndarray")
    rank = np.random.default_rng(0).permutation(len(kept))
    alive, taken = np.ones(len(kept), dtype=bool), np.zeros(len(kept), dtype=bool)
    while alive.any():
        first = alive.copy()
        lower = rank[pairs[:, 0]] < rank[pairs[:, 1]]
        first[np.where(lower, pairs[:, 1], pairs[:, 0])] = False
        taken |= first
        alive &= ~first
        gone = np.concatenate([pairs[first[pairs[:, 0]], 1], pairs[first[pairs[:, 1]], 0]])
        alive[gone] = False
        pairs = pairs[alive[pairs].all(axis=1)]
    return np.sort(chosen[taken])


def _one_per_cell(points: Floats, size: float) -> Ints:
    """Return the first point in each cell of a lattice, so that the cost does not depend on the density of the mesh."""
    cells = np.floor((points - points.min(axis=0)) / size).astype(np.int64)
    sides = cells.max(axis=0) + 1
    if np.prod(sides.astype(float)) < 2.0**62:  # one number per cell
        cells = (cells[:, 0] * sides[1] + cells[:, 1]) * sides[2] + cells[:, 2]
    _, first = np.unique(cells, axis=0, return_index=True)
    return first
