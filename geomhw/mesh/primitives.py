"""Meshes made from scratch: sphere, torus, flat grids, bands, and any surface f(x, y, z) = 0.

All are deterministic, numpy only, and oriented outward (flat ones: normal +z).
"""

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import MeshError
from geomhw.mesh.geometry import unit
from geomhw.mesh.topology import unique_edges
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A scalar function of the arrays x, y, z, negative inside.
ScalarFunction = Callable[[Floats, Floats, Floats], Floats]


# -- spheres -----------------------------------------------------------------------------------------------------


def icosphere(level: int, radius: float = 1.0) -> TriangleMesh:
    """Sphere of 10·4^level + 2 vertices round the origin: the icosahedron, each face split in four ``level`` times.

    The vertices of a level come first in the next one.

    >>> [icosphere(level).n_vertices for level in range(4)]
    [12, 42, 162, 642]
    """
    points, faces = _icosahedron()
    for _ in range(level):
        edges = unique_edges(faces)
        middle = len(points) + edges.of_faces  # of the edge opposite each corner
        points = unit(np.concatenate([points, points[edges.vertices].sum(axis=1)]))
        a, b, c = faces.T
        x, y, z = middle.T
        faces = np.stack([a, z, y, z, b, x, y, x, c, x, y, z], axis=1).reshape(-1, 3)
    return TriangleMesh(radius * points, faces)


def _icosahedron() -> tuple[Floats, Ints]:
    golden = (1 + np.sqrt(5)) / 2
    short = np.array([[-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0]])
    points = unit(np.concatenate([np.roll(short, k, axis=1) for k in range(3)]))
    # The hull of the twelve points: triples at edge distance, each turned to face outward.
    a, b, c = np.indices((12, 12, 12)).reshape(3, -1)
    near = points @ points.T > 0.4  # neighbors have cosine 1/√5, others less
    outward = np.linalg.det(points[np.stack([a, b, c], axis=1)]) > 0
    faces = np.stack([a, b, c], axis=1)[near[a, b] & near[b, c] & near[c, a] & outward & (a < b) & (a < c)]
    return points, faces


# -- lattices, flat and wrapped ----------------------------------------------------------------------------------


def grid(
    nx: int,
    ny: int,
    width: float = 1.0,
    height: float = 1.0,
    diagonal: Literal["alternating", "uniform"] = "alternating",
) -> TriangleMesh:
    """Rectangle [0, width] x [0, height] in the plane z = 0, nx x ny cells of two triangles, normal +z.

    Vertex j (nx + 1) + i lies at (i width/nx, j height/ny).
    """
    j, i = np.indices((ny + 1, nx + 1)).reshape(2, -1)
    points = np.stack([i * width / nx, j * height / ny, np.zeros(len(i))], axis=1)
    return TriangleMesh(points, _lattice_faces(nx, ny, alternate=diagonal == "alternating"))


def strip(length_cells: int, width_cells: int = 1, cell: float = 1.0) -> TriangleMesh:
    """Long flat strip of square cells along x; 3000 x 1 is where heat underflows."""
    return grid(length_cells, width_cells, length_cells * cell, width_cells * cell)


def torus(n_major: int, n_minor: int, major: float = 1.0, minor: float = 0.4) -> TriangleMesh:
    """Torus round the z axis, n_major x n_minor vertices; ``major`` is the radius of its center circle."""
    j, i = np.indices((n_minor, n_major)).reshape(2, -1)
    u, v = 2 * np.pi * i / n_major, 2 * np.pi * j / n_minor
    r = major + minor * np.cos(v)
    points = np.stack([r * np.cos(u), r * np.sin(u), minor * np.sin(v)], axis=1)
    return TriangleMesh(points, _lattice_faces(n_major, n_minor, wrap_i=True, wrap_j=True))


def cylinder_band(n_around: int, n_high: int, radius: float = 1.0, height: float = 1.0) -> TriangleMesh:
    """Open cylinder round the z axis, n_around x n_high cells; two boundary loops."""
    j, i = np.indices((n_high + 1, n_around)).reshape(2, -1)
    u = 2 * np.pi * i / n_around
    points = np.stack([radius * np.cos(u), radius * np.sin(u), height * (j / n_high - 0.5)], axis=1)
    return TriangleMesh(points, _lattice_faces(n_around, n_high, wrap_i=True))


def moebius_band(n_around: int, n_across: int, radius: float = 1.0, width: float = 0.6) -> TriangleMesh:
    """Möbius band round the z axis, n_around x n_across cells: one boundary loop, no orientation."""
    j, i = np.indices((n_across + 1, n_around)).reshape(2, -1)
    u, s = 2 * np.pi * i / n_around, width * (j / n_across - 0.5)
    r = radius + s * np.cos(u / 2)
    points = np.stack([r * np.cos(u), r * np.sin(u), s * np.sin(u / 2)], axis=1)
    faces = _lattice_faces(n_around, n_across)
    # The column past the last is the first one, upside down.
    row, column = np.divmod(faces, n_around + 1)
    past = column == n_around
    return TriangleMesh(points, np.where(past, (n_across - row) * n_around, row * n_around + column))


def _lattice_faces(ni: int, nj: int, wrap_i: bool = False, wrap_j: bool = False, alternate: bool = False) -> Ints:
    """Two triangles for each of ni x nj cells, the vertices being numbered with i fastest."""
    j, i = np.indices((nj, ni)).reshape(2, -1)
    columns, rows = ni + (not wrap_i), nj + (not wrap_j)
    a, b = j * columns + i, j * columns + (i + 1) % columns
    c, d = (j + 1) % rows * columns + (i + 1) % columns, (j + 1) % rows * columns + i
    quads = np.stack([a, b, c, d], axis=1)
    odd = ((i + j) % 2 == 1) & alternate
    return split_quads(np.where(odd[:, None], np.roll(quads, 1, axis=1), quads))


def split_quads(quads: Ints) -> Ints:
    """Two triangles a quad, (2q, 3), along the diagonal from its first corner to its third."""
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


# -- implicit surfaces -------------------------------------------------------------------------------------------


def genus_two(cells: int = 48) -> TriangleMesh:
    """Double torus (x(x-1)²(x-2) + y²)² + z² = 0.15², with ``cells`` lattice cells along x."""

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
    """The surface f = 0 inside the box [lower, upper], f being negative inside, by naive surface nets.

    One vertex for each lattice cell in which f changes sign, one quad for each such lattice edge. ``relax`` rounds then
    move every vertex towards the mean of its neighbors, within the surface, and back onto f = 0; quads are cut along
    their Delaunay diagonal. MeshError if the lattice is too coarse to give a manifold, or the surface leaves the box.

    [Gibson 1998, "Constrained elastic surface nets"]
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
    """Vertices in lattice units, (n, 3), and outward quads, (q, 4), between the signs of f on a lattice."""
    inside = values < 0
    faces = [np.take(inside, [0, -1], axis=axis) for axis in range(3)]
    if any(face.any() for face in faces):
        raise MeshError("the surface leaves the box it is looked for in; make the box larger")
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
        # The four cells round the edge, counterclockwise seen from its end.
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
    """Points moved along the gradient of f to f = 0, (n, 3), and the unit gradients there."""
    gradient = np.zeros_like(points)
    for _ in range(30):
        for axis, offset in enumerate(np.diag(1e-4 * step)):
            ahead, behind = f(*(points + offset).T), f(*(points - offset).T)
            gradient[:, axis] = (ahead - behind) / (2 * offset[axis])
        move = (f(*points.T) / np.einsum("vx,vx->v", gradient, gradient))[:, None] * gradient
        # Never more than half a cell at once: far from the surface Newton's step may go anywhere.
        length = np.linalg.norm(move, axis=1, keepdims=True)
        points = points - move * np.minimum(1, 0.5 * step.min() / np.maximum(length, 1e-300))
        if length.max() < 1e-13 * np.ptp(points, axis=0).max():
            break
    return points, unit(gradient)


def _neighbor_mean(points: Floats, edges: Ints) -> Floats:
    ends, others = edges.ravel(), edges[:, ::-1].ravel()
    sums = [np.bincount(ends, weights=column[others], minlength=len(points)) for column in points.T]
    return np.stack(sums, axis=1) / np.bincount(ends, minlength=len(points))[:, None]


def _delaunay_split(points: Floats, quads: Ints) -> Ints:
    """Triangles from quads, cut so that the two angles facing the cut sum to less than those at its ends."""
    corners = points[quads]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    angles = np.arctan2(np.linalg.norm(np.cross(ahead, behind), axis=2), np.einsum("qkx,qkx->qk", ahead, behind))
    # Ties, of which symmetric surfaces have many, must not hang on rounding.
    turn = angles[:, 0] + angles[:, 2] < angles[:, 1] + angles[:, 3] - 1e-9
    return split_quads(np.where(turn[:, None], np.roll(quads, 1, axis=1), quads))
