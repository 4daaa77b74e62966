"""Exact distances, and those by fast marching, beside pygeodesic and potpourri3d: one source, a disc, all pairs.

``make bench`` runs it. Seconds are processor time, the least of three runs, one of pygeodesic, except where they are
from start to end. Peak memory is measured in a process of its own for each solver. Prints Markdown.
"""

import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import potpourri3d as pp3d
from meshes import cortices, scans, spheres
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.fast_marching import FastMarchingDistance
from geomhw.mesh.named_points import region_points
from geomhw.mesh.triangle_mesh import TriangleMesh

RUNS = 3
#: Radius of discs, in mean edge lengths: 20 mm on a cortex of 10,242 vertices.
DISC = 6.5


def main() -> None:
    """Print both tables."""
    meshes = {**scans(), **cortices(), **spheres()}
    if len(sys.argv) > 1:
        print(peak_of(sys.argv[1], meshes[sys.argv[2]]()))
        return
    columns = ["mesh", "vertices", "exact", "pygeodesic", "ratio", "potpourri3d", "exact / it", "its error"]
    columns += ["fast-marching", "fast-marching / it", "error", "exact, disc", "from a region"]
    columns += ["peak memory", "of pygeodesic"]
    print("| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))
    for name, make in meshes.items():
        mesh = make()
        peaks = [peak(solver, name) for solver in ("exact", "pygeodesic")]
        print(f"| {name} | {mesh.n_vertices:,} | {' | '.join([*compared(mesh), *peaks])} |", flush=True)
    mesh = meshes["cortex-like"]()
    limit = DISC * mesh.mean_edge_length
    print(f"\nAll pairs within {DISC} edges, {mesh.n_vertices:,} vertices:")
    for solver in (ExactDistance(mesh), FastMarchingDistance(mesh)):
        solver.matrix(0.0)  # loads compiled code
        for share in (0.5, 1.0, 2.0):
            start = time.perf_counter()
            seconds, matrix = timed(partial(solver.matrix, share * limit), 1)
            wall, each = time.perf_counter() - start, 1e6 * seconds / matrix.nnz
            print(
                f"{solver.settings()['method']}, {share} of it: {seconds:.2f} s, {wall:.2f} s from start to end, "
                f"{each:.2f} µs a stored distance"
            )


def compared(mesh: TriangleMesh) -> list[str]:
    """Seconds of each solver from one vertex, and the error of fast marching."""
    solver = ExactDistance(mesh)
    solver.matrix(0.0)  # loads compiled code
    ours, exact = timed(lambda: solver.from_vertices([17])["distance"])
    disc, _ = timed(lambda: solver.from_vertices([17], limit=DISC * mesh.mean_edge_length), 20)
    peer = PyGeodesicAlgorithmExact(mesh.vertices, mesh.faces.astype(np.int32))
    theirs, other = timed(lambda: peer.geodesicDistances(np.array([17]), None)[0], 1)
    assert np.abs(exact - other).max() < 1e-9 * exact.max()
    fast = FastMarchingDistance(mesh)
    fast.from_vertices([17])  # lays out the angles
    quick, close = timed(lambda: fast.from_vertices([17])["distance"])
    marching = pp3d.MeshFastMarchingDistanceSolver(mesh.vertices, mesh.faces)
    march, near = timed(lambda: marching.compute_distance([[(17, [])]]))
    region = region_points(
        mesh, np.flatnonzero(solver.from_vertices([17], DISC * mesh.mean_edge_length)["distance"] < np.inf)
    )
    filled, _ = timed(lambda: solver.from_sources(region))
    others = exact > 0
    error, ours_off = (100 * float(np.mean(np.abs(d[others] / exact[others] - 1))) for d in (near, np.asarray(close)))
    return [
        f"{ours:.2f} s",
        f"{theirs:.2f} s",
        f"{theirs / ours:.1f}",
        f"{march:.2f} s",
        f"{ours / march:.1f}",
        f"{error:.2f} %",
        f"{quick:.3f} s",
        f"{quick / march:.2f}",
        f"{ours_off:.3f} %",
        f"{1000 * disc:.2f} ms",
        f"{filled:.2f} s",
    ]


def peak(solver: str, name: str) -> str:
    """Peak memory of a solver on a mesh, beyond that of the mesh, in a process of its own."""
    command = [sys.executable, __file__, solver, name]
    return f"{subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()} MB"


def peak_of(solver: str, mesh: TriangleMesh) -> int:
    """Peak memory in MB of one question, beyond that of the mesh and its edges; on Linux."""
    ExactDistance(mesh).from_vertices([17], limit=0.0)
    Path("/proc/self/clear_refs").write_text("5")  # the peak is that from here on
    before = _kilobytes("VmRSS")
    if solver == "exact":
        ExactDistance(mesh).from_vertices([17])
    else:
        PyGeodesicAlgorithmExact(mesh.vertices, mesh.faces.astype(np.int32)).geodesicDistances(np.array([17]), None)
    return (_kilobytes("VmHWM") - before) // 1024


def _kilobytes(name: str) -> int:
    """Memory of this process, from its status."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(f"{name}:"))


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
