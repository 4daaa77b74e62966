"""Distances against the exact polyhedral ones, beside potpourri3d's robust solver: mean relative errors.

``make bench`` runs it. The folder that GEOMHW_REFERENCE names adds its meshes to those of data/. Prints Markdown.
"""

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import potpourri3d as pp3d
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

from geomhw.arrays import Floats
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.io import read_mesh

DATA = Path(__file__).parents[2] / "data"
OURS = ["creature.obj", "torus.off", "genus2.off"]
REFERENCE = [
    *(f"closed/{name}" for name in ("moomoo.off", "spot.obj", "kitten.obj", "3holes.off", "eight.off", "fandisk.obj")),
    "closed/torus5k_surface.off",
    "hostile/camelhead.off",
]
SOURCES = (0, 100, 500)

Distance = Callable[[int], Floats]


def main() -> None:
    """The table, and the mean ratio to potpourri3d."""
    paths = [DATA / name for name in OURS]
    if folder := os.environ.get("GEOMHW_REFERENCE"):
        paths += [Path(folder) / "meshes" / name for name in REFERENCE]
    header = ["mesh", "vertices", "potpourri3d", "plain", "--robust --no-refine", "--robust", "ratio", "ms a source"]
    print("Mean relative error in %, t = h², sources 0, 100, 500; the ratio is that of --robust to potpourri3d.\n")
    print_row(header)
    print_row(["---"] * len(header))
    ratios = []
    for path in paths:
        mesh = read_mesh(path)
        exact = PyGeodesicAlgorithmExact(mesh.vertices, mesh.faces.astype(np.int32))
        truth = {s: exact.geodesicDistances(np.array([s]), None)[0] for s in SOURCES}
        peer = pp3d.MeshHeatMethodDistanceSolver(mesh.vertices, mesh.faces)
        ours = [
            HeatDistance(mesh, "h2"),
            HeatDistance(mesh, "h2", robust=True, refine=False),
            HeatDistance(mesh, "h2", robust=True),
        ]
        solvers = [peer.compute_distance, *(distances(solver) for solver in ours)]
        errors = [error(solver, truth) for solver in solvers]
        start = time.perf_counter()
        error(solvers[-1], truth)
        milliseconds = (time.perf_counter() - start) / len(SOURCES) * 1000
        ratios.append(errors[-1] / errors[0])
        figures = [f"{100 * e:.2f}" for e in errors]
        print_row([path.name, f"{mesh.n_vertices:,}", *figures, f"{ratios[-1]:.3f}", f"{milliseconds:.0f}"])
    print(f"\nOn average {np.mean(ratios):.3f} of potpourri3d's error, {max(ratios):.3f} at most.")


def distances(solver: HeatDistance) -> Distance:
    """A solver as a function of the source."""
    return lambda source: np.asarray(solver.from_vertices([source])["distance"])


def error(distance: Distance, truth: dict[int, Floats]) -> float:
    """Mean over the sources of the mean of |d - exact| / exact over the vertices that can be reached."""
    means = []
    for source, exact in truth.items():
        others = (exact > 0) & (exact < 1e30)
        means.append(np.mean(np.abs(distance(source) - exact)[others] / exact[others]))
    return float(np.mean(means))


def print_row(cells: list[str]) -> None:
    """Markdown."""
    print("| " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
