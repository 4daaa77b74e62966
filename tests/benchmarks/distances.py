"""Times, memory and errors of geodesic distance from one vertex: this project and its peers, in turn, in one run.

``make bench`` runs it on meshes of 41,000 and 164,000 vertices and more; ``distances.py --large`` adds 655,000, where
peers take minutes; ``distances.py --scaling`` is for this project alone, up to ten million. Prints Markdown, and draws
``build/bench/*.png``. The folder that GEOMHW_REFERENCE names lends its armadillo. Each solver runs in a process of its
own, so that peak memory is its own, from arrays to distances; a peer that is not installed is left out.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from solvers import SOLVERS

from geomhw.arrays import Floats
from geomhw.io import read_mesh
from geomhw.mesh.primitives import icosphere, strip
from geomhw.mesh.topology import unique_edges
from geomhw.mesh.triangle_mesh import TriangleMesh

HERE = Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build" / "bench"
#: Errors count from so many edges off the source on.
NEAR = 50
#: Repeats; those that take longer than so many seconds are run once.
REPEATS, PATIENCE = 3, 10.0
TIMEOUT = 3600
MODULES = {"potpourri3d": "potpourri3d", "libigl": "igl", "pymeshlab": "pymeshlab"}
#: Slow ones that another row stands for.
SKIPPED_WHEN_LARGE = ("geomhw --solver direct", "potpourri3d heat, robust", "pymeshlab heat")


@dataclass
class Case:
    """A mesh, a source vertex, and the distances that are known, (n,), NaN where they are not."""

    name: str
    mesh: TriangleMesh
    source: int
    truth: Floats


@dataclass
class Figures:
    """Medians of seconds, those of a second question, and of megabytes; error in %, nan where none is known."""

    seconds: float
    again: float
    megabytes: float
    error: float


def main() -> None:
    """Tables for each mesh, and a picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--large", action="store_true", help="655,000 vertices as well")
    parser.add_argument("--scaling", action="store_true", help="this project alone, up to ten million vertices")
    parser.add_argument("--levels", type=int, nargs="*", help="spheres subdivided so often")
    chosen = parser.parse_args()
    BUILD.mkdir(parents=True, exist_ok=True)
    if chosen.scaling:
        scaling()
        return
    names = [name for name in SOLVERS if installed(name)]
    results: dict[str, dict[str, Figures]] = {}
    for case in cases(chosen.levels or ([6, 7, 8] if chosen.large else [6, 7])):
        large = case.mesh.n_vertices > 300_000
        asked = [name for name in names if not (large and name in SKIPPED_WHEN_LARGE)]
        results[case.name] = measure(case, asked)
        report(case, results[case.name])
    draw(results)


def installed(name: str) -> bool:
    """Whether what that solver needs is there."""
    module = MODULES.get(name.split()[0])
    return module is None or find_spec(module) is not None


def cases(levels: list[int]) -> list[Case]:
    """Spheres, and the armadillo as it is and with each face cut in four, which is the same surface."""
    found = []
    for level in levels:
        mesh = icosphere(level)
        truth = np.arccos(np.clip(mesh.vertices @ mesh.vertices[5], -1, 1))
        found.append(Case(f"sphere, {mesh.n_vertices:,} vertices", mesh, 5, truth))
    if folder := os.environ.get("GEOMHW_REFERENCE"):
        mesh = read_mesh(Path(folder) / "meshes" / "closed" / "armadillo.obj")
        truth = exact(mesh, 0)
        found.append(Case(f"armadillo, {mesh.n_vertices:,} vertices", mesh, 0, truth))
        finer = quartered(mesh)
        known = np.full(finer.n_vertices, np.nan)
        known[: mesh.n_vertices] = truth
        found.append(Case(f"armadillo cut finer, {finer.n_vertices:,} vertices", finer, 0, known))
    return found


def exact(mesh: TriangleMesh, source: int) -> Floats:
    """Exact distance on the polyhedron, (n,)."""
    from pygeodesic.geodesic import PyGeodesicAlgorithmExact

    found = PyGeodesicAlgorithmExact(mesh.vertices, mesh.faces.astype(np.int32))
    return np.asarray(found.geodesicDistances(np.array([source]), None)[0])


def quartered(mesh: TriangleMesh) -> TriangleMesh:
    """Each face cut in four at the middles of its edges; the vertices of the mesh come first."""
    edges = unique_edges(mesh.faces)
    a, b, c = mesh.faces.T
    at_a, at_b, at_c = (edges.of_faces + mesh.n_vertices).T
    corners = [(a, at_c, at_b), (at_c, b, at_a), (at_b, at_a, c), (at_a, at_b, at_c)]
    faces = np.concatenate([np.stack(face, axis=1) for face in corners])
    return TriangleMesh(np.concatenate([mesh.vertices, mesh.vertices[edges.vertices].mean(axis=1)]), faces)


def measure(case: Case, names: list[str]) -> dict[str, Figures]:
    """All solvers in turn, round after round, each twice in a row unless it is slow.

    The second run counts: how fast a machine hands out memory depends on what the program before has left behind, and
    with this each comes after itself.
    """
    runs: dict[str, list[Figures]] = {name: [] for name in names}
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "mesh.npz"
        np.savez(stored, vertices=case.mesh.vertices, faces=case.mesh.faces, source=case.source)
        for _ in range(REPEATS):
            for name, done in runs.items():
                if not done or done[-1].seconds < PATIENCE:
                    found = run(case, name, stored)
                    done.append(run(case, name, stored) if found.seconds < PATIENCE else found)
    middle = statistics.median
    return {
        name: Figures(
            middle(f.seconds for f in done),
            middle(f.again for f in done),
            middle(f.megabytes for f in done),
            done[0].error,
        )
        for name, done in runs.items()
    }


def run(case: Case, name: str, stored: Path) -> Figures:
    """One solver in a process of its own, algebra on one thread; infinite seconds where it fails."""
    out = stored.with_name("out.npz")
    threads = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}
    command = [sys.executable, str(HERE / "solvers.py"), name, str(stored), str(out)]
    try:
        done = subprocess.run(command, env={**os.environ, **threads}, timeout=TIMEOUT, capture_output=True, text=True)
    except subprocess.TimeoutExpired:
        return Figures(np.inf, np.inf, np.nan, np.nan)
    if done.returncode:
        print(f"{name}: {done.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
        return Figures(np.inf, np.inf, np.nan, np.nan)
    answer = np.load(out)
    wrong = np.nan if "vec" in name else error(case, answer["distance"])
    return Figures(float(answer["seconds"]), float(answer["again"]), float(answer["megabytes"]), wrong)


def error(case: Case, distance: Floats) -> float:
    """Mean relative error in %, away from the source."""
    known = case.truth > NEAR * case.mesh.mean_edge_length  # not where it is NaN
    return 100 * float(np.mean(np.abs(distance[known] / case.truth[known] - 1)))


def report(case: Case, figures: dict[str, Figures]) -> None:
    """A table in Markdown; ratios are to this project's row of the same kind."""
    print(f"\n{case.name}, {case.mesh.n_faces:,} faces\n")
    row(["", "seconds", "ratio", "second question", "peak memory", "mean error"])
    row(["---"] * 6)
    for name, found in figures.items():
        ours = figures["geomhw vecdiffuse" if "vec" in name else "geomhw"]
        row(
            [
                name,
                f"{found.seconds:.2f} s",
                f"{found.seconds / ours.seconds:.1f}",
                f"{1000 * found.again:.0f} ms",
                f"{found.megabytes:.0f} MB",
                "" if np.isnan(found.error) else f"{found.error:.2f} %",
            ]
        )


def row(cells: list[str]) -> None:
    """One row of a table."""
    print("| " + " | ".join(cells) + " |", flush=True)


def draw(results: dict[str, dict[str, Figures]]) -> None:
    """Seconds of all solvers on all meshes, as bars on a logarithmic axis."""
    import matplotlib.pyplot as plt

    names = [name for name in SOLVERS if any(name in found for found in results.values())]
    figure, axes = plt.subplots(figsize=(9, 1 + 0.28 * len(names) * len(results)), layout="constrained")
    place = 0
    ticks, labels = [], []
    for mesh, found in results.items():
        for name in names:
            if name in found and np.isfinite(found[name].seconds):
                color = "#c2410c" if name.startswith("geomhw") else "#64748b"
                axes.barh(place, found[name].seconds, color=color)
                axes.text(found[name].seconds, place, f" {found[name].seconds:.2f} s", va="center", fontsize=8)
                ticks.append(place)
                labels.append(name)
                place -= 1
        axes.text(
            0.02, (place + len(found)) + 0.9, mesh, fontsize=9, weight="bold", transform=axes.get_yaxis_transform()
        )
        place -= 1.5
    axes.set_yticks(ticks, labels, fontsize=8)
    axes.set_xscale("log")
    axes.set_xlabel("seconds from arrays to distances or vectors")
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(BUILD / "distances.png", dpi=130)
    print(f"\n{BUILD / 'distances.png'} is drawn", file=sys.stderr)


def scaling() -> None:
    """Seconds and memory of this project on spheres and strips up to ten million vertices."""
    print("mean error from 50 edges off the source on\n")
    row(["mesh", "vertices", "seconds", "µs a vertex", "bytes a vertex", "mean error"])
    row(["---"] * 6)
    found: dict[str, list[tuple[int, Figures]]] = {"sphere": [], "strip": []}
    for level in range(5, 11):
        mesh = icosphere(level)
        truth = np.arccos(np.clip(mesh.vertices @ mesh.vertices[5], -1, 1))
        found["sphere"].append(scaled(Case(f"sphere {level}", mesh, 5, truth)))
    for cells in (5_000, 50_000, 500_000, 5_000_000):
        mesh = strip(cells)
        found["strip"].append(
            scaled(Case(f"strip {cells:,} x 1", mesh, 0, np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)))
        )
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for label, points in found.items():
        axes.loglog([n for n, _ in points], [figures.seconds for _, figures in points], "o-", label=label)
    axes.set_xlabel("vertices")
    axes.set_ylabel("seconds from arrays to distances")
    axes.grid(True, which="both", alpha=0.2)
    axes.legend()
    figure.savefig(BUILD / "scaling.png", dpi=130)


def scaled(case: Case) -> tuple[int, Figures]:
    """One row of the scaling table."""
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "mesh.npz"
        np.savez(stored, vertices=case.mesh.vertices, faces=case.mesh.faces, source=case.source)
        n = case.mesh.n_vertices
        figures = run(case, "geomhw", stored)
    bytes_each = figures.megabytes * 2**20 / n
    cells = [
        f"{figures.seconds:.2f}",
        f"{1e6 * figures.seconds / n:.1f}",
        f"{bytes_each:.0f}",
        f"{figures.error:.3f} %",
    ]
    row([case.name, f"{n:,}", *cells])
    return n, figures


if __name__ == "__main__":
    main()
