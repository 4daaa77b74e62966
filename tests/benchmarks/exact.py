"""Exact distances beside pygeodesic and potpourri3d's fast marching: one source, a disc, and all pairs within a limit.

``make bench`` runs it. Seconds are processor time, the least of three runs, except where they are from start to end.
The folder that GEOMHW_REFERENCE names adds its armadillo. Prints Markdown.
"""

import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import potpourri3d as pp3d
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from geomhw.geodesic.exact import ExactDistance
from geomhw.io import read_mesh
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh

RUNS = 3
#: Radius of discs, in mean edge lengths: 20 mm on a cortex of 10,242 vertices.
DISC = 6.5


def main() -> None:
    """Print both tables."""
    meshes = {"cortex-like": folded_sphere(5), "cortex-like, finer": folded_sphere(6), "sphere": icosphere(6)}
    if folder := os.environ.get("GEOMHW_REFERENCE"):
        meshes["armadillo"] = read_mesh(Path(folder) / "meshes/closed/armadillo.obj")
    print("| mesh | vertices | exact | pygeodesic | ratio | fast marching | its error | exact, disc |\n|" + "---|" * 8)
    for name, mesh in meshes.items():
        print(f"| {name} | {mesh.n_vertices:,} | {' | '.join(compared(mesh))} |", flush=True)
    mesh = meshes["cortex-like"]
    limit, solver = DISC * mesh.mean_edge_length, ExactDistance(mesh)
    print(f"\nAll pairs within {DISC} edges, {mesh.n_vertices:,} vertices:")
    for share in (0.5, 1.0, 2.0):
        start = time.perf_counter()
        seconds, matrix = timed(partial(solver.matrix, share * limit), 1)
        wall, each = time.perf_counter() - start, 1e6 * seconds / matrix.nnz
        print(f"{share} of it: {seconds:.2f} s, {wall:.2f} s from start to end, {each:.2f} µs a stored distance")


def folded_sphere(level: int, seed: int = 0) -> TriangleMesh:
    """Return a folded sphere of 80 units with irregular faces, 30 % of them obtuse, as on a cortical surface."""
    rng, ball = np.random.default_rng(seed), icosphere(level)
    points = ball.vertices + 0.1 * ball.mean_edge_length * rng.normal(size=ball.vertices.shape)
    points /= np.linalg.norm(points, axis=1)[:, None]
    waves = rng.normal(size=(40, 3))
    waves *= 10 / np.linalg.norm(waves, axis=1)[:, None]
    height = np.sin(points @ waves.T + rng.uniform(0, 2 * np.pi, 40)).sum(axis=1) / np.sqrt(20)
    return TriangleMesh(80 * points * (1 + 0.245 * np.tanh(1.2 * height))[:, None], ball.faces)


def compared(mesh: TriangleMesh) -> list[str]:
    """Seconds of each solver from one vertex, and the error of fast marching."""
    solver = ExactDistance(mesh)
    solver.matrix(0.0)  # loads compiled code
    ours, exact = timed(lambda: solver.from_vertices([17])["distance"])
    disc, _ = timed(lambda: solver.from_vertices([17], limit=DISC * mesh.mean_edge_length), 20)
    peer = PyGeodesicAlgorithmExact(mesh.vertices, mesh.faces.astype(np.int32))
    theirs, other = timed(lambda: peer.geodesicDistances(np.array([17]), None)[0], 1)
    assert np.abs(exact - other).max() < 1e-9 * exact.max()
    marching = pp3d.MeshFastMarchingDistanceSolver(mesh.vertices, mesh.faces)
    march, near = timed(lambda: marching.compute_distance([[(17, [])]]))
    others = exact > 0
    error = 100 * float(np.mean(np.abs(near[others] / exact[others] - 1)))
    return [
        f"{ours:.2f} s",
        f"{theirs:.2f} s",
        f"{theirs / ours:.1f}",
        f"{march:.2f} s",
        f"{error:.2f} %",
        f"{1000 * disc:.2f} ms",
    ]


def timed(work: Callable[[], Any], runs: int = RUNS) -> tuple[float, Any]:
    """Least processor time of some runs, and the result."""
    seconds, result = np.inf, None
    for _ in range(runs):
        start = time.process_time()
        result = work()
        seconds = min(seconds, time.process_time() - start)
    return seconds, result


if __name__ == "__main__":
    main()
