"""Seconds a source when many follow: `HeatDistance.rows` beside potpourri3d's prefactored heat method.

``make bench`` runs it. Each is asked in turn, in one process, and medians of the turns are told, in milliseconds; the
ratio is that of the medians. The folder that GEOMHW_REFERENCE names lends its armadillo. Prints Markdown.
"""

import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np
import potpourri3d as pp3d

from geomhw.geodesic.heat_method import HeatDistance, block_size
from geomhw.io import read_mesh
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.surface_points import vertex_points
from geomhw.mesh.triangle_mesh import TriangleMesh

TURNS = 5
#: Questions to the peer a turn.
ASKED = 4


def main() -> None:
    """The table."""
    meshes = {"icosphere(6)": icosphere(6), "icosphere(7)": icosphere(7)}
    if folder := os.environ.get("GEOMHW_REFERENCE"):
        meshes["armadillo"] = read_mesh(Path(folder) / "meshes/closed/armadillo.obj")
    print("| mesh | vertices | potpourri3d set-up | a source | geomhw set-up | a source | ratio |\n|" + "---|" * 7)
    for name, mesh in meshes.items():
        print(f"| {name} | {mesh.n_vertices:,} | {' | '.join(compared(mesh))} |", flush=True)
    print(f"\nnumpy {np.__version__}, Python {sys.version.split()[0]}, {TURNS} turns")


def compared(mesh: TriangleMesh) -> list[str]:
    """Milliseconds, and the ratio."""
    start = time.perf_counter()
    peer = pp3d.MeshHeatMethodDistanceSolver(mesh.vertices, mesh.faces, use_robust=False)
    peer.compute_distance(0)
    half = time.perf_counter()
    ours = HeatDistance(mesh, "h2", queries=10_000)
    ours.prepare()
    set_up = [half - start, time.perf_counter() - half]
    chosen = np.random.default_rng(0).choice(mesh.n_vertices, (TURNS + 1, block_size(mesh.n_vertices)), replace=False)
    times = []
    for block in chosen.tolist():
        queries = [vertex_points(mesh, [v]) for v in block]
        start = time.perf_counter()
        for vertex in block[:ASKED]:
            peer.compute_distance(vertex)
        half = time.perf_counter()
        ours.rows(queries)
        times.append([(half - start) / ASKED, (time.perf_counter() - half) / len(block)])
    theirs, mine = (statistics.median(column) for column in zip(*times[1:], strict=True))
    seconds = [set_up[0], theirs, set_up[1], mine]
    return [*(f"{1000 * x:.1f}" for x in seconds), f"{theirs / mine:.1f}"]


if __name__ == "__main__":
    main()
