"""Test meshes: the zoo, on which every identity is tested, and flat, crumpled or degenerate variants."""

from collections.abc import Callable

import numpy as np

from geomhw.mesh import genus_two, grid, icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh


def crumpled(mesh: TriangleMesh, seed: int = 5) -> TriangleMesh:
    """Move every vertex at random, by a fifth of an edge."""
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    return TriangleMesh(mesh.vertices + 0.2 * mesh.mean_edge_length * noise, mesh.faces)


def two_spheres() -> TriangleMesh:
    """Return two spheres and a vertex without faces."""
    ball = icosphere(2)
    n = ball.n_vertices
    vertices = np.concatenate([ball.vertices, [[9.0, 9.0, 9.0]], ball.vertices * 0.5 + [4.0, 0.0, 0.0]])
    return TriangleMesh(vertices, np.concatenate([ball.faces, ball.faces + n + 1]))


def grid_of(h: float) -> TriangleMesh:
    """A small grid of that mean edge length."""
    mesh = grid(4, 4)
    return TriangleMesh(mesh.vertices * (h / mesh.mean_edge_length), mesh.faces)


def annulus() -> TriangleMesh:
    """Return a flat square with a square hole: two boundary loops."""
    square = grid(9, 9)
    inside = np.abs(square.face_centers[:, :2] - square.vertices.mean(axis=0)[:2]).max(axis=1) < 0.17
    return TriangleMesh(square.vertices, square.faces[~inside])


def sheared(cells: int = 12, shear: float = 20.0) -> TriangleMesh:
    """Return a flat parallelogram of slivers."""
    square = grid(cells, cells)
    return TriangleMesh(square.vertices + shear * square.vertices[:, [1, 2, 2]], square.faces)


def book(pages: int = 3, cells: int = 6) -> TriangleMesh:
    """Return square pages that share an edge on the z axis, page by page."""
    square = grid(cells, cells)
    x, z = square.vertices[:, 0], square.vertices[:, 1]
    angle = 2 * np.pi * np.arange(pages)[:, None] / pages
    points = np.stack([np.cos(angle) * x, np.sin(angle) * x, np.broadcast_to(z, (pages, len(z)))], axis=2)
    every = np.arange(pages * len(x)).reshape(pages, -1)
    every[:, x == 0] = every[0, x == 0]
    faces = every[:, square.faces].reshape(-1, 3)
    used, names = np.unique(faces, return_inverse=True)
    return TriangleMesh(points.reshape(-1, 3)[used], names.reshape(-1, 3))


def split_diagonals(cells: int = 16) -> TriangleMesh:
    """Return a flat square whose diagonals have a vertex on one side only: a face of zero area at each."""
    square = grid(cells, cells, diagonal="uniform")
    below, above = square.faces[::2], square.faces[1::2]
    a, c, d = above.T
    m = square.n_vertices + np.arange(len(above))
    faces = [below, np.stack([a, m, d], axis=1), np.stack([m, c, d], axis=1), np.stack([a, c, m], axis=1)]
    middles = square.vertices[above[:, :2]].mean(axis=1)
    return TriangleMesh(np.concatenate([square.vertices, middles]), np.concatenate(faces))


ZOO: dict[str, Callable[[], TriangleMesh]] = {
    "triangle": lambda: TriangleMesh([[0, 0, 0], [1, 0, 0], [0.3, 1, 0]], [[0, 1, 2]]),
    "tetrahedron": lambda: TriangleMesh(
        [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    ),
    "sphere": lambda: icosphere(3),
    "crumpled_sphere": lambda: crumpled(icosphere(2)),
    "torus": lambda: torus(24, 12),
    "crumpled_torus": lambda: crumpled(torus(20, 12)),
    "genus_two": genus_two,
    "grid": lambda: grid(8, 6),
    "strip": lambda: strip(40),
    "annulus": annulus,
    "two_spheres": two_spheres,
}
CLOSED = {"tetrahedron": 0, "sphere": 0, "crumpled_sphere": 0, "torus": 1, "crumpled_torus": 1, "genus_two": 2}
_built: dict[str, TriangleMesh] = {}


def zoo_mesh(name: str) -> TriangleMesh:
    """Return a mesh of the zoo, built once."""
    if name not in _built:
        _built[name] = ZOO[name]()
    return _built[name]


def spiky() -> TriangleMesh:
    """Return a sphere with random radii: its Delaunay triangulation has edges from a vertex to itself."""
    ball = icosphere(3)
    return TriangleMesh(ball.vertices * np.random.default_rng(0).uniform(1, 2, (ball.n_vertices, 1)), ball.faces)


def volume(mesh: TriangleMesh) -> float:
    """Return the enclosed volume by the divergence theorem; positive for outward faces."""
    return float(np.einsum("f,fx,fx->", mesh.face_areas, mesh.face_normals, mesh.face_centers)) / 3


def disc(rings: int) -> TriangleMesh:
    """The unit disc, flat: rings of 6k vertices at the radius k/rings."""
    from scipy.spatial import Delaunay

    turns = [2 * np.pi * (np.arange(6 * k) + 0.5 * (k % 2)) / (6 * k) for k in range(1, rings + 1)]
    points = [np.stack([np.cos(a), np.sin(a)], axis=1) * k / rings for k, a in enumerate(turns, start=1)]
    flat = np.concatenate([np.zeros((1, 2)), *points])
    faces = Delaunay(flat).simplices
    a, b, c = flat[faces].transpose(1, 0, 2)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((area < 0)[:, None], faces[:, ::-1], faces)[np.abs(area) > 1e-12]
    return TriangleMesh(np.column_stack([flat, np.zeros(len(flat))]), faces)


def scattered_sphere(count: int, seed: int = 0) -> TriangleMesh:
    """Return the Delaunay triangulation of random points on the unit sphere, with outward faces."""
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    faces = ConvexHull(points).simplices
    inward = np.linalg.det(points[faces]) < 0
    return TriangleMesh(points, np.where(inward[:, None], faces[:, ::-1], faces))


def flat_torus(n: int = 4, rings: int = 3) -> tuple[TriangleMesh, np.ndarray, float, float]:
    """Return a flat torus in space, a bent square tube folded from strips, its coordinates (u, v) and both widths.

    A polygon of 2 rings nested tubes: the outer and inner walls of a prism, closed above and below by annuli, is not
    flat; two prisms of the same polygon, joined at both ends, are.
    """
    angle = 2 * np.pi * np.arange(n) / n
    height = 1.0
    points, coordinates, side = [], [], 2 * np.sin(np.pi / n)
    for level in range(rings):
        for k in range(n):
            points.append([np.cos(angle[k]), np.sin(angle[k]), height * level / (rings - 1)])
            coordinates.append([k * side, height * level / (rings - 1)])
    for level in range(1, rings - 1):
        for k in range(n):
            points.append([np.cos(angle[k]), np.sin(angle[k]), height * level / (rings - 1)])
            coordinates.append([k * side, 2 * height - height * level / (rings - 1)])
    order = [*range(rings), *range(2 * rings - 3, rings - 1, -1)]
    faces = []
    for i, row in enumerate(order):
        above = order[(i + 1) % len(order)]
        for k in range(n):
            a, b, c, d = row * n + k, row * n + (k + 1) % n, above * n + (k + 1) % n, above * n + k
            faces += [[a, b, c], [a, c, d]]
    return TriangleMesh(points, faces), np.array(coordinates), n * side, 2 * height


def folded(flat: TriangleMesh) -> TriangleMesh:
    """Return a sheet in the plane folded along x = 0."""
    return TriangleMesh(flat.vertices * [1, 1, 0] * np.sign(flat.vertices[:, :1]) ** [1, 0, 0], flat.faces)
