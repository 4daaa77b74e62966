"""Meshes of the benchmarks of distances: scans first, where GEOMHW_REFERENCE names a folder with an armadillo."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from geomhw.io import read_mesh
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh

Meshes = dict[str, Callable[[], TriangleMesh]]


def scans() -> Meshes:
    """Return the armadillo, and the same surface with four times as many faces."""
    folder = os.environ.get("GEOMHW_REFERENCE")
    if not folder:
        return {}
    armadillo = Path(folder) / "meshes/closed/armadillo.obj"
    return {"armadillo": lambda: read_mesh(armadillo), "armadillo, finer": lambda: finer(read_mesh(armadillo))}


def cortices() -> Meshes:
    """Return two meshes like cortical surfaces."""
    return {"cortex-like": lambda: folded_sphere(5), "cortex-like, finer": lambda: folded_sphere(6)}


def spheres() -> Meshes:
    """Return two spheres."""
    return {"sphere": lambda: icosphere(6), "sphere, finer": lambda: icosphere(7)}


def finer(mesh: TriangleMesh) -> TriangleMesh:
    """Return the same surface with each face cut into four at the midpoints of its edges."""
    sides, corners = mesh.edge_table.of_faces + mesh.n_vertices, mesh.faces
    cut = [np.stack([corners[:, k], sides[:, k - 1], sides[:, k - 2]], axis=1) for k in range(3)]
    middles = mesh.vertices[mesh.edges].mean(axis=1)
    return TriangleMesh(np.concatenate([mesh.vertices, middles]), np.concatenate([*cut, sides]))


def folded_sphere(level: int, seed: int = 0) -> TriangleMesh:
    """Return a folded sphere of 80 units with irregular faces, 30 % of them obtuse, as on a cortical surface."""
    rng, ball = np.random.default_rng(seed), icosphere(level)
    points = ball.vertices + 0.1 * ball.mean_edge_length * rng.normal(size=ball.vertices.shape)
    points /= np.linalg.norm(points, axis=1)[:, None]
    waves = rng.normal(size=(40, 3))
    waves *= 10 / np.linalg.norm(waves, axis=1)[:, None]
    height = np.sin(points @ waves.T + rng.uniform(0, 2 * np.pi, 40)).sum(axis=1) / np.sqrt(20)
    return TriangleMesh(80 * points * (1 + 0.245 * np.tanh(1.2 * height))[:, None], ball.faces)
