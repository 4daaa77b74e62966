"""Make the meshes in this folder: ``python data/generate.py``; ``--check`` compares the files with what would be made.

All come from formulas in geomhw.mesh and in this file; nothing is taken from anywhere else.
"""

import hashlib
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh import genus_two, implicit_surface, primitives
from geomhw.mesh.triangle_mesh import TriangleMesh

FOLDER = Path(__file__).parent
#: Significant digits of coordinates.
DIGITS = 12


# -- the creature ------------------------------------------------------------------------------------------------


def creature() -> TriangleMesh:
    """A small horned grazer, y up, facing +x: rounded cones joined by smooth minima, contoured."""
    cells = np.array([34, 26, 20])  # an even number across, so that left and right are alike
    center, half = np.array([0.01, 0.955, 0.0]), 0.081 * cells / 2
    return implicit_surface(_creature, center - half, center + half, cells.tolist(), relax=30)


def _creature(x: Floats, y: Floats, z: Floats) -> Floats:
    p = np.stack([x, y, z], axis=-1)
    side = np.stack([x, y, np.abs(z)], axis=-1)  # legs, ears and horns come in mirrored pairs
    body = [
        _cone(p, (-0.40, 0.68, 0.0), (0.26, 0.71, 0.0), 0.36, 0.34),
        _cone(p, (0.32, 0.84, 0.0), (0.56, 1.14, 0.0), 0.25, 0.21),  # neck
    ]
    legs = [
        _cone(side, (0.27, 0.55, 0.21), (0.31, 0.14, 0.24), 0.15, 0.135),
        _cone(side, (-0.47, 0.56, 0.21), (-0.54, 0.14, 0.24), 0.18, 0.135),
    ]
    tail = [
        _cone(p, (-0.72, 0.86, 0.0), (-1.00, 0.86, 0.0), 0.115, 0.11),
        _cone(p, (-1.00, 0.86, 0.0), (-1.13, 0.60, 0.0), 0.11, 0.125),
    ]
    head = [
        _cone(p, (0.58, 1.27, 0.0), (0.76, 1.22, 0.0), 0.26, 0.235),  # skull
        _cone(p, (0.86, 1.12, 0.0), (1.06, 1.03, 0.0), 0.185, 0.195),  # muzzle
    ]
    ears = _cone(side, (0.52, 1.21, 0.22), (0.44, 1.14, 0.54), 0.125, 0.10)
    horns = [
        _cone(side, (0.60, 1.48, 0.12), (0.58, 1.60, 0.25), 0.125, 0.11),
        _cone(side, (0.58, 1.60, 0.25), (0.64, 1.71, 0.28), 0.11, 0.09),
    ]
    trunk = _smooth_min([_smooth_min(body, 0.12), *legs, _smooth_min(tail, 0.03)], 0.10)
    bare = _smooth_min([trunk, _smooth_min(head, 0.08)], 0.08)
    return _smooth_min([bare, ears, _smooth_min(horns, 0.02)], 0.05)


def _cone(p: Floats, start: tuple[float, ...], end: tuple[float, ...], radius: float, end_radius: float) -> Floats:
    """Distance (nearly) to a segment thickened by a radius that changes along it."""
    a, along = np.array(start), np.array(end) - start
    t = np.clip((p - a) @ along / (along @ along), 0, 1)
    return np.asarray(np.linalg.norm(p - a - t[..., None] * along, axis=-1) - radius - t * (end_radius - radius))


def _smooth_min(values: list[Floats], blend: float) -> Floats:
    """-k log Σ exp(-v/k): the least of the values, with fillets of about the size k."""
    stacked = np.stack(values)
    least = stacked.min(axis=0)
    k = blend / 2
    return np.asarray(least - k * np.log(np.exp((least - stacked) / k).sum(axis=0)))


# -- the folder --------------------------------------------------------------------------------------------------

MESHES: dict[str, Callable[[], TriangleMesh]] = {
    "sphere.off": lambda: primitives.icosphere(3),
    "sphere_2562.off": lambda: primitives.icosphere(4),
    "torus.off": lambda: primitives.torus(60, 28),
    "genus2.off": lambda: genus_two(44),
    "strip.off": lambda: primitives.strip(300),
    "creature.obj": creature,
}

MADE = {
    "sphere.off": "icosahedron, faces split in four 3 times, on the unit sphere",
    "sphere_2562.off": "the same, split 4 times",
    "torus.off": "60 x 28 lattice on the torus of radii 1 and 0.4",
    "genus2.off": "(x(x-1)²(x-2) + y²)² + z² = 0.15², contoured",
    "strip.off": "300 x 1 flat cells of size 1",
    "creature.obj": "rounded cones joined by smooth minima, contoured; y up, facing +x",
}


def main(arguments: list[str]) -> int:
    """Write the files, or with ``--check`` report those that differ; the exit code is 1 if any does."""
    if arguments == ["--check"]:
        problems = check()
        print("\n".join(problems) or f"{len(MESHES)} meshes are as generated")
        return int(bool(problems))
    meshes = {name: make() for name, make in MESHES.items()}
    for name, mesh in meshes.items():
        (FOLDER / name).write_bytes(text(mesh, name).encode())
    (FOLDER / "README.md").write_text(readme(meshes), encoding="utf-8")
    return 0


def check(folder: Path = FOLDER) -> list[str]:
    """What is wrong with the files: other faces, coordinates off by 1e-9, a sha256 that the README does not have."""
    table = (folder / "README.md").read_text(encoding="utf-8")
    problems = []
    for name, make in MESHES.items():
        data = (folder / name).read_bytes()
        if hashlib.sha256(data).hexdigest() not in table:
            problems.append(f"{name}: its sha256 is not in README.md")
        made, found = _numbers(text(make(), name)), _numbers(data.decode())
        if made.shape != found.shape or not np.allclose(made, found, rtol=0, atol=1e-9):
            problems.append(f"{name}: differs from what generate.py makes")
    return problems


def text(mesh: TriangleMesh, name: str) -> str:
    """The mesh as OFF or OBJ text."""
    points = [" ".join(f"{x + 0.0:.{DIGITS}g}" for x in row) for row in np.round(mesh.vertices, 12).tolist()]
    if name.endswith(".obj"):
        corners = [" ".join(str(v + 1) for v in row) for row in mesh.faces.tolist()]
        return "".join([f"v {row}\n" for row in points] + [f"f {row}\n" for row in corners])
    corners = [" ".join(map(str, row)) for row in mesh.faces.tolist()]
    lines = ["OFF", f"{mesh.n_vertices} {mesh.n_faces} 0", *points, *(f"3 {row}" for row in corners)]
    return "\n".join(lines) + "\n"


def readme(meshes: dict[str, TriangleMesh]) -> str:
    """The table of the meshes."""
    rows = [
        f"| `{name}` | {mesh.n_vertices} | {mesh.n_faces} | {mesh.genus} | {MADE[name]} "
        f"| `{_sha256(text(mesh, name))}` |"
        for name, mesh in meshes.items()
    ]
    return "\n".join(
        [
            "# Meshes",
            "",
            "Made by `python data/generate.py` from formulas, and under the project's license; `--check` compares.",
            "",
            "| name | vertices | faces | genus | how it is made | sha256 |",
            "|---|---|---|---|---|---|",
            *rows,
            "",
        ]
    )


def _sha256(content: str) -> str:
    return hashlib.sha256(content.encode()).hexdigest()


def _numbers(content: str) -> Floats:
    return np.array([float(word) for word in content.split() if word not in ("OFF", "v", "f")])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
