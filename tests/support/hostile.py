"""Meshes that break assumptions: one-sided, non-manifold, degenerate, very small or large; as plain arrays."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from geomhw.mesh.primitives import cylinder_band, grid, icosphere, moebius_band, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import book, sheared


def save(vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write m.off, and wind.npy with a random field on its faces."""
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0", *(" ".join(map(repr, row)) for row in vertices.tolist())]
    lines += ["3 " + " ".join(map(str, row)) for row in faces.tolist()]
    Path("m.off").write_text("\n".join(lines) + "\n")
    np.save("wind.npy", np.random.default_rng(0).normal(size=(len(faces), 3)))


def source_of(words: str) -> int:
    """Return the source that the report names."""
    return int(next(line for line in words.splitlines() if line.startswith("source")).split()[1])


def hostile(name: str) -> TriangleMesh:
    return TriangleMesh(*HOSTILE[name]())


Arrays = tuple[np.ndarray, np.ndarray]


def arrays(mesh: TriangleMesh) -> Arrays:
    """Return writable copies of vertices and faces."""
    return mesh.vertices.copy(), mesh.faces.copy()


def made(vertices: ArrayLike, faces: ArrayLike) -> Arrays:
    """Return lists as arrays."""
    return np.array(vertices, dtype=float), np.array(faces)


def triangles(count: int) -> Arrays:
    """Return one triangle, two that form a square, or a closed fan round vertex 0."""
    if count <= 2:
        return made([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]][: count + 2], [[0, 1, 2], [0, 2, 3]][:count])
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    ring = np.arange(count)
    return made([[0, 0, 0], *rim], np.stack([np.zeros(count, int), 1 + ring, 1 + (ring + 1) % count], axis=1))


def tetrahedron() -> Arrays:
    """Return a regular tetrahedron of edge length √8."""
    return made([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def bow_tie() -> Arrays:
    """Return two triangles that share vertex 0 only."""
    return made([[0, 0, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]], [[0, 1, 2], [0, 3, 4]])


def hourglass() -> Arrays:
    """Return two spheres that touch in vertex 0."""
    vertices, faces = arrays(icosphere(2))
    lowest, n = int(vertices[:, 2].argmin()), len(vertices)
    upper = vertices - vertices[lowest]
    swap = np.arange(n)
    swap[[0, lowest]] = lowest, 0
    lower = np.where(swap[faces] == 0, 0, swap[faces] + n - 1)
    return np.concatenate([upper[swap], -upper[swap][1:]]), np.concatenate([swap[faces], lower[:, ::-1]])


def pinched(mesh: Arrays, kept: int, lost: int) -> Arrays:
    """Merge a vertex with another that shares no edge and no neighbor with it."""
    vertices, faces = mesh
    faces = np.where(faces == lost, kept, faces)
    return np.delete(vertices, lost, axis=0), faces - (faces > lost)


def pinched_meshes() -> dict[str, Arrays]:
    """Return meshes with a pinched vertex: two parts, one closed surface, one part with boundary, and two places."""
    ring = arrays(torus(12, 8))
    return {
        "bow_tie": bow_tie(),
        "hourglass": hourglass(),
        "pinched_torus": pinched(ring, 0, 52),
        "pinched_twice": pinched(pinched(ring, 0, 52), 28, 80),
        "pinched_grid": pinched(arrays(grid(6, 5)), 0, 41),
        "pinched_bands": pinched(joined(arrays(cylinder_band(8, 3)), moved(arrays(cylinder_band(8, 3)), 1, 3)), 0, 40),
    }


def renumbered(mesh: Arrays, seed: int = 0) -> tuple[Arrays, np.ndarray, np.ndarray]:
    """Renumber vertices and faces at random; return the mesh, and the former numbers of vertices and of faces."""
    rng = np.random.default_rng(seed)
    vertices, faces = mesh
    places, order = rng.permutation(len(vertices)), rng.permutation(len(faces))
    rank = np.argsort(places)
    return (vertices[places], rank[faces[order]]), places, order


def rotated_corners(mesh: Arrays, seed: int = 0) -> Arrays:
    """Start the faces from other corners, at random."""
    faces = mesh[1].copy()
    shift = np.random.default_rng(seed).integers(0, 3, len(faces))
    return mesh[0], np.take_along_axis(faces, (np.arange(3) + shift[:, None]) % 3, axis=1)


def flipped(mesh: Arrays, seed: int = 0) -> Arrays:
    """Reverse half of the faces, at random."""
    faces = mesh[1].copy()
    half = np.random.default_rng(seed).random(len(faces)) < 0.5
    faces[half] = faces[half, ::-1]
    return mesh[0], faces


def far_away(mesh: Arrays) -> Arrays:
    """Translate a mesh by a million times its size."""
    used = mesh[0][np.unique(mesh[1])]
    return mesh[0] + 1e6 * np.ptp(used, axis=0).max() * np.array([0.6, -0.7, 0.4]), mesh[1]


def touching_edge() -> Arrays:
    """Return two tetrahedra that share an edge, where four faces meet."""
    vertices, faces = tetrahedron()
    other = np.array([0, 1, 4, 5])
    mirror = vertices[[0, 1]].mean(axis=0)
    return np.concatenate([vertices, 2 * mirror - vertices[2:]]), np.concatenate([faces, other[faces][:, ::-1]])


def klein_bottle(n: int = 24, k: int = 12) -> Arrays:
    """Return a figure-eight Klein bottle: closed, one-sided, self-intersecting."""
    vertices, faces = [], []
    for i in range(n):
        u = 2 * np.pi * i / n
        for j in range(k):
            v = 2 * np.pi * j / k
            r = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
            z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
            vertices.append([r * np.cos(u), r * np.sin(u), z])

    def at(i: int, j: int) -> int:
        return (i % n) * k + ((j if i < n else -j) % k)

    for i in range(n):
        for j in range(k):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [[a, b, c], [a, c, d]]
    return made(vertices, faces)


def turned(mesh: Arrays, every: int = 3) -> Arrays:
    """Flip every k-th face."""
    vertices, faces = mesh
    faces = faces.copy()
    faces[::every] = faces[::every, ::-1]
    return vertices, faces


def doubled(mesh: Arrays, which: slice, flip: bool = False) -> Arrays:
    """Duplicate some faces, flipped on request."""
    vertices, faces = mesh
    again = np.roll(faces[which], 1, axis=1)
    return vertices, np.concatenate([faces, again[:, ::-1] if flip else again])


def loose(mesh: Arrays, where: int, point: ArrayLike = (9.0, 9.0, 9.0)) -> Arrays:
    """Insert a vertex without faces."""
    vertices, faces = mesh
    return np.insert(vertices, where, np.asarray(point), axis=0), faces + (faces >= where)


def soup(mesh: Arrays) -> Arrays:
    """Separate all triangles."""
    vertices, faces = mesh
    return vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def joined(*meshes: Arrays) -> Arrays:
    """Join meshes side by side."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def moved(mesh: Arrays, scale: float = 1.0, offset: float = 0.0) -> Arrays:
    """Scale and translate a mesh."""
    return mesh[0] * scale + offset, mesh[1]


def needle(height: float) -> Arrays:
    """Return a square with a middle vertex at a height above one side, which gives one flat face."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, height, 0]]
    return made(corners, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])


def flat_vertex() -> Arrays:
    """Return a grid with one vertex moved onto its neighbor: faces of zero area, edges of zero length."""
    vertices, faces = arrays(grid(5, 5))
    vertices[14] = vertices[15]
    return vertices, faces


BALL = arrays(icosphere(2))
HOSTILE: dict[str, Callable[[], Arrays]] = {
    "triangle": lambda: triangles(1),
    "two_triangles": lambda: triangles(2),
    "tetrahedron": tetrahedron,
    "fan_1000": lambda: triangles(1000),
    "bow_tie": bow_tie,
    "hourglass": hourglass,
    "touching_edge": touching_edge,
    "book_3": lambda: arrays(book(3)),
    "book_5": lambda: arrays(book(5, 3)),
    "moebius": lambda: arrays(moebius_band(40, 4)),
    "klein": klein_bottle,
    "turned_sphere": lambda: turned(BALL),
    "turned_torus": lambda: turned(arrays(torus(24, 12)), 2),
    "turned_grid": lambda: turned(arrays(grid(8, 6)), 2),
    "inside_out": lambda: (BALL[0], BALL[1][:, ::-1]),
    "two_ways": lambda: joined(BALL, (BALL[0] + [3, 0, 0], BALL[1][:, ::-1])),
    "doubled": lambda: doubled(BALL, slice(5, 40)),
    "doubled_flipped": lambda: doubled(BALL, slice(5, 40), flip=True),
    "doubled_all": lambda: doubled(BALL, slice(None)),
    "doubled_all_flipped": lambda: doubled(BALL, slice(None), flip=True),
    "pillow": lambda: doubled(triangles(1), slice(None), flip=True),
    "tripled": lambda: doubled(doubled(triangles(2), slice(0, 1)), slice(0, 1), flip=True),
    "loose_first": lambda: loose(BALL, 0),
    "loose_middle": lambda: loose(BALL, 80),
    "loose_last": lambda: loose(BALL, 162),
    "loose_far": lambda: loose(BALL, 3, (1e12, 1e12, 1e12)),
    "soup": lambda: soup(arrays(icosphere(1))),
    "nested": lambda: joined(BALL, moved(BALL, 0.5), moved(BALL, 0.25)),
    "same_place": lambda: joined(BALL, BALL),
    "huge": lambda: moved(BALL, 1e29),
    "tiny": lambda: moved(BALL, 1e-29),
    "huge_150": lambda: moved(BALL, 1e150),
    "tiny_150": lambda: moved(BALL, 1e-150),
    "tiny_310": lambda: moved(BALL, 1e-310),
    "far": lambda: moved(BALL, 1.0, 1e8),
    "far_lost": lambda: moved(BALL, 1.0, 1e16),
    "one_point": lambda: moved(BALL, 0.0),
    "mixed_scales": lambda: joined(BALL, moved(BALL, 1e-6, 3.0), moved(BALL, 1e6, 1e7)),
    "needle_6": lambda: needle(1e-6),
    "needle_12": lambda: needle(1e-12),
    "needle_15": lambda: needle(1e-15),
    "needle_0": lambda: needle(0.0),
    "needle_below": lambda: needle(-1e-12),
    "sheared": lambda: arrays(sheared(8, 1e3)),
    "sheared_6": lambda: arrays(sheared(8, 1e6)),
    "flat_vertex": flat_vertex,
    "tube": lambda: arrays(cylinder_band(3, 40)),
}
