"""Meshes of implicit surfaces f(x, y, z) = 0 by surface nets, and the double torus."""

from collections.abc import Callable, Sequence

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import MeshError
from geomhw.mesh.geometry import unit
from geomhw.mesh.primitives import split_quads
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A scalar function of the arrays x, y, z, negative inside.
ScalarFunction = Callable[[Floats, Floats, Floats], Floats]


def genus_two(cells: int = 48) -> TriangleMesh:
    """Generate the double torus (x(x-1)²(x-2) + y²)² + z² = 0.15² from a lattice with ``cells`` cells along x.

    Examples
    --------
    >>> genus_two(32).genus
    2
    """

    def f(x: Floats, y: Floats, z: Floats) -> Floats:
        return np.asarray((x * (x - 1) ** 2 * (x - 2) + y**2) ** 2 + z**2 - 0.15**2)

    lower, upper = np.array([-0.2, -0.75, -0.25]), np.array([2.2, 0.75, 0.25])
    size = (upper - lower).max() / cells
    return implicit_surface(f, lower, upper, np.ceil((upper - lower) / size).astype(int).tolist())


def implicit_surface(
    f: ScalarFunction,
    lower: Sequence[float] | Floats,
    upper: Sequence[float] | Floats,
    cells: int | Sequence[int],
    relax: int = 20,
) -> TriangleMesh:
    """Mesh the closed surface f = 0 in the box [lower, upper] by naive surface nets.

    Each lattice cell in which f changes sign gives a vertex, each such lattice edge a quad. Tangential smoothing and
    Newton steps onto f = 0 follow; quads are split along their Delaunay diagonals.

    Parameters
    ----------
    f : callable
        f(x, y, z) on arrays, negative inside.
    lower, upper : (3,) arrays
        Opposite corners of the box.
    cells : int or three ints
        Number of lattice cells per axis.
    relax : int
        Number of smoothing rounds.

    Raises
    ------
    MeshError
        If the surface leaves the box or does not exist, or if the lattice is too coarse for a manifold.

    References
    ----------
    Gibson: Constrained elastic surface nets, 1998.

    Examples
    --------
    >>> ball = implicit_surface(lambda x, y, z: x**2 + y**2 + z**2 - 1, [-2, -2, -2], [2, 2, 2], 12)
    >>> ball.euler_characteristic
    2
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    shape = np.broadcast_to(np.asarray(cells), (3,))
    step = (high - low) / shape
    x, y, z = (low[k] + step[k] * np.arange(shape[k] + 1) for k in range(3))
    values = f(*np.meshgrid(x, y, z, indexing="ij"))
    points, quads = _surface_net(values)
    points, normals = _project(f, low + step * points, step)
    edges = np.unique(np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1), axis=0)
    for _ in range(relax):
        pull = _neighbor_mean(points, edges) - points
        pull -= np.einsum("vx,vx->v", pull, normals)[:, None] * normals
        points, normals = _project(f, points + 0.5 * pull, step)
    mesh = TriangleMesh(points, _delaunay_split(points, quads))
    if not (mesh.is_closed and mesh.is_edge_manifold and mesh.is_oriented):
        raise MeshError("the lattice is too coarse for this surface: an edge has more than two faces; use more cells")
    return mesh


def _surface_net(values: Floats) -> tuple[Floats, Ints]:
    """Return vertices in lattice units, (n, 3), and outward quads, (q, 4), between lattice values of opposite sign."""
    inside = values < 0
    faces = [np.take(inside, [0, -1], axis=axis) for axis in range(3)]
    if any(face.any() for face in faces):
        raise MeshError("the surface leaves the box; make the box larger")
    if not inside.any():
        raise MeshError("there is no surface in the box: the function is nowhere negative")
    cell_shape = tuple(size - 1 for size in values.shape)
    strides = np.array([cell_shape[1] * cell_shape[2], cell_shape[2], 1])
    cells, crossings = [], []
    for axis in range(3):
        before, after = (np.take(values, range(k, values.shape[axis] - 1 + k), axis=axis) for k in (0, 1))
        rising = (before < 0) & (after >= 0)
        start = np.argwhere(rising | ((before >= 0) & (after < 0)))
        low, high = before[tuple(start.T)], after[tuple(start.T)]
        crossing = start.astype(float)
        crossing[:, axis] += low / (low - high)
        # The four cells around the edge, counterclockwise seen from its end.
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        ring = start[:, None] - np.stack([u + v, v, 0 * u, u])
        ring = np.where(rising[tuple(start.T)][:, None, None], ring, ring[:, ::-1])
        cells.append(ring @ strides)
        crossings.append(np.repeat(crossing, 4, axis=0))
    names, quads = np.unique(np.concatenate(cells), return_inverse=True)
    where = np.concatenate(crossings)
    sums = [np.bincount(quads.ravel(), weights=column) for column in where.T]
    count = np.bincount(quads.ravel(), minlength=len(names))
    return np.stack(sums, axis=1) / count[:, None], quads.reshape(-1, 4)


def _project(f: ScalarFunction, points: Floats, step: Floats) -> tuple[Floats, Floats]:
    """Move points, (n, 3), along the gradient of f to f = 0; return them and the unit gradients there."""
    gradient = np.zeros_like(points)
    for _ in range(30):
        for axis, offset in enumerate(np.diag(1e-4 * step)):
            ahead, behind = f(*(points + offset).T), f(*(points - offset).T)
            gradient[:, axis] = (ahead - behind) / (2 * offset[axis])
        move = (f(*points.T) / np.einsum("vx,vx->v", gradient, gradient))[:, None] * gradient
        # At most half a cell per step: Newton's method may diverge far from the surface.
        length = np.linalg.norm(move, axis=1, keepdims=True)
        points = points - move * np.minimum(1, 0.5 * step.min() / np.maximum(length, 1e-300))
        if length.max() < 1e-13 * np.ptp(points, axis=0).max():
            break
    return points, unit(gradient)


def _neighbor_mean(points: Floats, edges: Ints) -> Floats:
    """Return the mean of the neighbors of each point, (n, 3)."""
    ends, others = edges.ravel(), edges[:, ::-1].ravel()
    sums = [np.bincount(ends, weights=column[others], minlength=len(points)) for column in points.T]
    return np.stack(sums, axis=1) / np.bincount(ends, minlength=len(points))[:, None]


def _delaunay_split(points: Floats, quads: Ints) -> Ints:
    """Split quads along the diagonal opposite the two angles of smaller sum."""
    corners = points[quads]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    angles = np.arctan2(np.linalg.norm(np.cross(ahead, behind), axis=2), np.einsum("qkx,qkx->qk", ahead, behind))
    # The margin keeps ties, frequent on symmetric surfaces, independent of rounding.
    turn = angles[:, 0] + angles[:, 2] < angles[:, 1] + angles[:, 3] - 1e-9
    return split_quads(np.where(turn[:, None], np.roll(quads, 1, axis=1), quads))
