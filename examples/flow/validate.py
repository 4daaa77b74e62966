"""Measure what the fluid schemes conserve and their errors against an exact wave: two plots, and tables in Markdown.

    python validate.py --levels 3 4 5 --steps 1000 -o .

leaves errors.png and conservation.png. A level k is a sphere of 10 * 4**k + 2 vertices.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from geomhw.flow import random_field
from geomhw.fluid import Diagnostics, FlowState, Plan, Scheme, VorticityModel, rossby_haurwitz, run, scheme_of
from geomhw.mesh import TriangleMesh, icosphere
from geomhw.options import SchemeName

SCHEMES: dict[SchemeName, str] = {"conservative": "#1b6ca8", "rk4": "#d1495b", "stable-fluids": "#8d99ae"}
DEGREE = 4
#: Radians a unit of time that the wave turns while the sphere below turns one [Haurwitz 1940].
RATE = 1 - 2 / (DEGREE * (DEGREE + 1))
REVOLUTION = 2 * np.pi / RATE
COURANT = 1.0


def main() -> None:
    """Both plots."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--levels", type=int, nargs="+", default=[3, 4, 5], help="spheres of the wave")
    parser.add_argument("--steps", type=int, default=1000, help="of the random flow")
    parser.add_argument("-o", "--output", type=Path, default=Path(), help="folder of the plots")
    choices = parser.parse_args()
    errors(choices.levels, choices.output / "errors.png")
    print()
    conservation(icosphere(max(choices.levels[:2])), choices.steps, choices.output / "conservation.png")


def errors(levels: list[int], picture: Path) -> None:
    """Relative L2 error of the vorticity of a Rossby-Haurwitz wave over one revolution of its pattern."""
    figure, axes = plt.subplots(
        1, len(levels), figsize=(4.2 * len(levels), 3.6), sharey=True, squeeze=False, layout="constrained"
    )
    rows = []
    for axis, level in zip(axes[0], levels, strict=True):
        mesh = icosphere(level)
        velocity = rossby_haurwitz(VorticityModel(mesh), DEGREE)
        for name, color in SCHEMES.items():
            scheme = scheme_of(mesh, name)
            state = scheme.start(velocity)
            course, at = [], []
            for share in (0.8, 1.0):
                for snapshot in run(scheme, state, Plan(cfl=COURANT, until=share * REVOLUTION, every=5)):
                    state = snapshot.state
                    course.append((state.time / REVOLUTION, wave_error(scheme, state)))
                at.append(course[-1][1])
            axis.semilogy(*np.transpose(course[1:]), color=color, label=name)
            rows.append([f"{mesh.n_vertices:,}", name, *(f"{100 * error:.2f} %" for error in at)])
        axis.set(title=f"{mesh.n_vertices:,} vertices", xlabel="revolutions of the pattern")
        axis.grid(alpha=0.3)
    axes[0, 0].set_ylabel("relative L2 error of the vorticity")
    axes[0, -1].legend(frameon=False)
    figure.savefig(picture, dpi=110, metadata={"Software": None})
    print_table(["vertices", "scheme", "after 0.8 revolutions", "after 1"], rows)


def conservation(mesh: TriangleMesh, steps: int, picture: Path) -> None:
    """Energy, enstrophy and the largest vorticity of a random flow over time."""
    velocity = random_field(mesh, 1)
    figure, axes = plt.subplots(1, 3, figsize=(12.6, 3.6), layout="constrained")
    rows = []
    for name, color in SCHEMES.items():
        scheme = scheme_of(mesh, name)
        diagnostics = Diagnostics(scheme)
        table = []
        start = scheme.start(velocity)
        for snapshot in run(scheme, start, Plan(cfl=COURANT, steps=steps, every=10)):
            row = diagnostics(snapshot.state, snapshot.dt)
            largest = float(np.abs(scheme.vorticity(snapshot.state)).max())
            table.append((snapshot.state.step, row["energy"], row["enstrophy"], largest, row["circulation"]))
        step, energy, enstrophy, largest, circulation = np.transpose(table)
        axes[0].semilogy(step[1:], np.maximum(np.abs(energy / energy[0] - 1)[1:], 1e-16), color=color, label=name)
        axes[1].plot(step, enstrophy / enstrophy[0], color=color)
        axes[2].plot(step, largest / largest[0], color=color)
        size = mesh.vertex_areas.sum() * largest[0]
        drift = f"{np.abs(energy / energy[0] - 1).max():.1e}"
        lost = f"{np.abs(circulation - circulation[0]).max() / size:.1e}"
        rows.append([name, drift, lost, f"{enstrophy[-1] / enstrophy[0]:.3f}", f"{(largest / largest[0]).max():.3f}"])
    for axis, title in zip(axes, ("|E/E₀ - 1|", "enstrophy", "largest |vorticity|"), strict=True):
        axis.set(title=title, xlabel="step")
        axis.grid(alpha=0.3)
    axes[0].legend(frameon=False)
    figure.savefig(picture, dpi=110, metadata={"Software": None})
    print_table(
        ["scheme", "energy drift", "circulation drift", "enstrophy left", "largest vorticity, times initial"], rows
    )


def wave_error(scheme: Scheme, state: FlowState) -> float:
    """Relative L2 distance of the vorticity from 2z + 2 Re(x+iy)⁴, turned by as much as the exact wave has."""
    x, y, z = scheme.mesh.vertices.T
    turned = (x + 1j * y) * np.exp(-1j * RATE * state.time)
    exact = 2 * z + 2 * (turned**DEGREE).real
    areas = scheme.mesh.vertex_areas
    difference = scheme.vorticity(state) - exact
    return float(np.sqrt((areas @ difference**2) / (areas @ exact**2)))


def print_table(header: list[str], rows: list[list[str]]) -> None:
    """Markdown."""
    for row in [header, ["---"] * len(header), *rows]:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
