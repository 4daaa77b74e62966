"""The mesh zoo: every operator and identity is tested on all of it."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from geomhw.mesh.primitives import genus_two, grid, icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh

# The same examples every time; HYPOTHESIS_PROFILE=long looks for new ones.
settings.register_profile("ci", derandomize=True, database=None, deadline=None, max_examples=25)
settings.register_profile("long", derandomize=False, database=None, deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# A shell starts what runs in its background with interrupts ignored, and that is inherited; tests send themselves some.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

REFERENCE = os.environ.get("GEOMHW_REFERENCE") and Path(os.environ["GEOMHW_REFERENCE"]).resolve()
needs_reference = pytest.mark.skipif(not REFERENCE, reason="GEOMHW_REFERENCE names no folder of reference meshes")


def reference(path: str) -> Path:
    """A file of the reference folder; only in tests marked ``needs_reference``."""
    assert REFERENCE
    return REFERENCE / path


def crumpled(mesh: TriangleMesh, seed: int = 5) -> TriangleMesh:
    """The same connectivity with every vertex shaken by a fifth of an edge: no symmetry to hide behind."""
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    return TriangleMesh(mesh.vertices + 0.2 * mesh.mean_edge_length * noise, mesh.faces)


def two_spheres() -> TriangleMesh:
    """Two components and, between them, a vertex that no face uses."""
    ball = icosphere(2)
    n = ball.n_vertices
    vertices = np.concatenate([ball.vertices, [[9.0, 9.0, 9.0]], ball.vertices * 0.5 + [4.0, 0.0, 0.0]])
    return TriangleMesh(vertices, np.concatenate([ball.faces, ball.faces + n + 1]))


def annulus() -> TriangleMesh:
    """A flat square with a square hole: two boundary loops."""
    square = grid(9, 9)
    inside = np.abs(square.face_centers[:, :2] - square.vertices.mean(axis=0)[:2]).max(axis=1) < 0.17
    return TriangleMesh(square.vertices, square.faces[~inside])


def sheared(cells: int = 12, shear: float = 20.0) -> TriangleMesh:
    """A flat parallelogram of slivers."""
    square = grid(cells, cells)
    return TriangleMesh(square.vertices + shear * square.vertices[:, [1, 2, 2]], square.faces)


def book(pages: int = 3, cells: int = 6) -> TriangleMesh:
    """Square pages that share a spine, the z axis; page p takes the vertices after those of page p-1 but the spine."""
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
    """A flat unit square whose diagonals have a vertex in the middle on one side only: a face without area in each."""
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
    """That mesh of the zoo, built once."""
    if name not in _built:
        _built[name] = ZOO[name]()
    return _built[name]


@pytest.fixture(params=ZOO)
def mesh(request: pytest.FixtureRequest) -> TriangleMesh:
    """Each mesh of the zoo in turn."""
    return zoo_mesh(request.param)


@pytest.fixture(params=CLOSED)
def closed_mesh(request: pytest.FixtureRequest) -> tuple[TriangleMesh, int]:
    """Each closed connected mesh with its genus."""
    return zoo_mesh(request.param), CLOSED[request.param]
