"""Random meshes of some hundred faces, in families: smooth, flat, open, one-sided, non-manifold, thin, scattered."""

from collections.abc import Callable

import numpy as np

from geomhw.mesh.primitives import cylinder_band, grid, icosphere, moebius_band, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.hostile import Arrays, arrays, doubled, joined, klein_bottle, pinched, soup, touching_edge, triangles
from support.meshes import book, sheared, split_diagonals

Random = np.random.Generator


def sphere(rng: Random) -> Arrays:
    """Return a sphere whose vertices have moved by some of an edge."""
    vertices, faces = arrays(icosphere(2))
    return vertices + rng.uniform(0, 0.08) * rng.normal(size=vertices.shape), faces


def spiky(rng: Random) -> Arrays:
    """Return a sphere of random radii."""
    vertices, faces = arrays(icosphere(int(rng.integers(1, 3))))
    return vertices * rng.uniform(1, rng.uniform(1.1, 3), (len(vertices), 1)), faces


def ellipsoid(rng: Random) -> Arrays:
    """Return a sphere stretched along the axes by up to 30."""
    vertices, faces = arrays(icosphere(2))
    return vertices * 30 ** rng.uniform(-0.5, 0.5, 3), faces


def ring(rng: Random) -> Arrays:
    """Return a torus of random numbers of vertices and of a random thickness."""
    return arrays(torus(int(rng.integers(5, 24)), int(rng.integers(4, 12)), 1.0, rng.uniform(0.05, 0.6)))


def maze(rng: Random) -> Arrays:
    """Return the corridors of a maze: a spanning tree of a lattice of cells, as a flat mesh with narrow gaps."""
    size, seen, stack = 4, {(0, 0)}, [(0, 0)]
    open_cells = {(0, 0)}
    while stack:
        i, j = stack[-1]
        near = [(i + di, j + dj) for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        near = [(a, b) for a, b in near if 0 <= a < size and 0 <= b < size and (a, b) not in seen]
        if not near:
            stack.pop()
            continue
        a, b = near[rng.integers(len(near))]
        seen.add((a, b))
        stack.append((a, b))
        open_cells |= {(2 * a, 2 * b), (a + i, b + j)}
    square = grid(2 * size - 1, 2 * size - 1)
    cell = np.floor((square.face_centers[:, :2] / square.vertices[:, :2].max()) * (2 * size - 1)).astype(int)
    kept = np.array([tuple(c) in open_cells for c in cell.tolist()])
    return used(square.vertices, square.faces[kept])


def terrain(rng: Random) -> Arrays:
    """Return a rough height field."""
    vertices, faces = arrays(grid(10, 9))
    x, y = vertices[:, 0], vertices[:, 1]
    vertices[:, 2] = 0.2 * np.sin(5 * x + rng.uniform(0, 6)) * np.cos(7 * y) + rng.uniform(0, 0.1) * rng.normal(
        size=len(x)
    )
    return vertices, faces


def patch(rng: Random, stretch: float = 1.0) -> Arrays:
    """Return the Delaunay triangulation of random points of a square."""
    from scipy.spatial import Delaunay

    points = rng.random((int(rng.integers(20, 120)), 2))
    return np.column_stack([points * [1, stretch], np.zeros(len(points))]), Delaunay(points).simplices.astype(np.int64)


def anisotropic_patch(rng: Random) -> Arrays:
    """Return a Delaunay triangulation squeezed along an axis by up to 100."""
    return patch(rng, 10 ** rng.uniform(-2, 0))


def needle_fan(rng: Random) -> Arrays:
    """Return a closed fan round a vertex of high valence, as a cone."""
    vertices, faces = triangles(int(rng.integers(30, 200)))
    vertices[0, 2] = rng.uniform(-2, 2)
    return vertices, faces


def scattered(rng: Random) -> Arrays:
    """Return triangles that share no vertex."""
    return soup(sphere(rng))


def t_junctions(rng: Random) -> Arrays:
    """Return a square whose diagonals have a vertex on one side only, moved off it by a little."""
    vertices, faces = arrays(split_diagonals(6))
    vertices[49:, :2] += rng.uniform(1e-3, 2e-2) * np.array([1, -1]) * rng.choice([-1, 1])
    return vertices, faces


def pinched_torus(rng: Random) -> Arrays:
    """Return a torus two vertices of which are one."""
    lost = int(rng.integers(40, 56))
    return pinched(arrays(torus(12, 8)), 0, lost)


def band(rng: Random) -> Arrays:
    """Return a long strip or a tube."""
    if rng.random() < 0.5:
        return arrays(strip(int(rng.integers(5, 100))))
    return arrays(cylinder_band(int(rng.integers(3, 12)), int(rng.integers(1, 20)), 1.0, rng.uniform(0.1, 9)))


def moebius(rng: Random) -> Arrays:
    """Return a Moebius band."""
    return arrays(moebius_band(int(rng.integers(8, 40)), int(rng.integers(1, 5))))


def klein(rng: Random) -> Arrays:
    """Return a Klein bottle."""
    return klein_bottle(int(rng.integers(8, 20)), int(rng.integers(6, 10)))


def slivers(rng: Random) -> Arrays:
    """Return a parallelogram sheared by up to 100."""
    return arrays(sheared(6, 10 ** rng.uniform(0, 2)))


def components(rng: Random) -> Arrays:
    """Return a sphere, a torus and a Moebius band, of sizes that differ by up to 100."""
    parts = [sphere(rng), ring(rng), moebius(rng)]
    return joined(*((vertices * 10 ** rng.uniform(-1, 1) + 30 * k, faces) for k, (vertices, faces) in enumerate(parts)))


def pages(rng: Random) -> Arrays:
    """Return pages that share an edge path."""
    return arrays(book(int(rng.integers(3, 6)), int(rng.integers(2, 6))))


def touching(rng: Random) -> Arrays:
    """Return two tetrahedra at one edge, or a sphere with duplicate faces."""
    if rng.random() < 0.5:
        return touching_edge()
    return doubled(sphere(rng), slice(5, int(rng.integers(6, 60))), flip=bool(rng.random() < 0.5))


def polycube(rng: Random) -> Arrays:
    """Return the boundary of a box of cells: flat, with ties between shortest paths."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))])
    vertices = corners * rng.integers(1, 4, 3)
    for _ in range(2):
        vertices, faces = divided(vertices, faces)
    return vertices, faces


def divided(vertices: np.ndarray, faces: np.ndarray) -> Arrays:
    """Return the mesh with each face divided into four at the middles of its edges."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, of = np.unique(edges, axis=0, return_inverse=True)
    middle = len(vertices) + of.reshape(-1, 3)
    a, b, c = faces.T
    ab, bc, ca = middle.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    new = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.concatenate([vertices, vertices[unique].mean(axis=1)]), new


def used(vertices: np.ndarray, faces: np.ndarray) -> Arrays:
    """Return a mesh without its unused vertices."""
    kept, numbers = np.unique(faces, return_inverse=True)
    return vertices[kept], numbers.reshape(-1, 3)


MAKERS: list[Callable[[Random], Arrays]] = [
    sphere, spiky, ellipsoid, ring, maze, terrain, patch, anisotropic_patch, needle_fan, scattered,
    t_junctions, pinched_torus, band, moebius, klein, slivers, components, pages, touching, polycube,
]  # fmt: skip
FAMILIES = {maker.__name__: maker for maker in MAKERS}


def random_mesh(family: str, seed: int) -> Arrays:
    """Return the mesh of a family with this seed, with or without some flipped faces."""
    rng = np.random.default_rng([seed, *family.encode()])
    vertices, faces = FAMILIES[family](rng)
    TriangleMesh(vertices, faces)
    return vertices, faces
