"""Time a source, for one and for many: `HeatDistance` beside potpourri3d's prefactored heat method, in turn.

``make bench`` runs it. Prints Markdown: medians of processor time in milliseconds, and their ratios.
"""

import statistics
import sys
import time

import numpy as np
import potpourri3d as pp3d
from meshes import scans, spheres

from geomhw.geodesic.heat_method import HeatDistance, block_size
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.triangle_mesh import TriangleMesh

TURNS = 5
#: Questions to the peer a turn.
ASKED = 4


def main() -> None:
    """Print the table."""
    columns = ["mesh", "vertices", "one source: potpourri3d", "geomhw", "ratio", "potpourri3d set-up", "geomhw set-up"]
    columns += ["a source of many: potpourri3d", "geomhw", "ratio"]
    print("| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))
    for name, make in {**scans(), **spheres()}.items():
        mesh = make()
        print(f"| {name} | {mesh.n_vertices:,} | {' | '.join([*one_source(mesh), *many_sources(mesh)])} |", flush=True)
    print(f"\nnumpy {np.__version__}, Python {sys.version.split()[0]}, {TURNS} turns")


def one_source(mesh: TriangleMesh) -> list[str]:
    """Milliseconds of each from arrays to distances, and the ratio of geomhw to potpourri3d."""
    times = []
    for turn in range(TURNS):
        start = time.process_time()
        pp3d.MeshHeatMethodDistanceSolver(mesh.vertices, mesh.faces, use_robust=False).compute_distance(turn)
        half = time.process_time()
        HeatDistance(TriangleMesh(mesh.vertices, mesh.faces), "h2").from_vertices([turn])
        times.append([half - start, time.process_time() - half])
    theirs, mine = (statistics.median(column) for column in zip(*times[1:], strict=True))
    return [f"{1000 * theirs:.0f}", f"{1000 * mine:.0f}", f"{mine / theirs:.2f}"]


def many_sources(mesh: TriangleMesh) -> list[str]:
    """Milliseconds of each to prepare, and for one of many sources, and the ratio of geomhw to potpourri3d."""
    start = time.process_time()
    peer = pp3d.MeshHeatMethodDistanceSolver(mesh.vertices, mesh.faces, use_robust=False)
    peer.compute_distance(0)
    half = time.process_time()
    ours = HeatDistance(mesh, "h2", queries=10_000)
    ours.prepare()
    set_up = [half - start, time.process_time() - half]
    chosen = np.random.default_rng(0).choice(mesh.n_vertices, (TURNS + 1, block_size(mesh.n_vertices)), replace=False)
    times = []
    for block in chosen.tolist():
        queries = [vertex_points(mesh, [v]) for v in block]
        start = time.process_time()
        for vertex in block[:ASKED]:
            peer.compute_distance(vertex)
        half = time.process_time()
        ours.rows(queries)
        times.append([(half - start) / ASKED, (time.process_time() - half) / len(block)])
    theirs, mine = (statistics.median(column) for column in zip(*times[1:], strict=True))
    seconds = [*set_up, theirs, mine]
    return [*(f"{1000 * x:.1f}" for x in seconds), f"{mine / theirs:.2f}"]


if __name__ == "__main__":
    main()
