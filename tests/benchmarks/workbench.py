"""Workbench's questions, asked of wb_command and of geomhw: errors and seconds of processor time, as Markdown.

``python tests/benchmarks/workbench.py [NAME=SURFACE.gii,SPHERE.gii ...]``, with ``wb_command`` on the path (Debian:
connectome-workbench). Without surfaces it runs on folded spheres, like a cortex, of 10,242 and 40,962 vertices.
Distances are compared with exact ones, gradients and smoothing with formulas on the sphere.
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import nibabel
import numpy as np
from meshes import folded_sphere
from numpy.polynomial.legendre import legval

from geomhw.arrays import Floats
from geomhw.geodesic import ExactDistance
from geomhw.io import read, read_arrays, read_field, read_polylines, write
from geomhw.mesh import TriangleMesh
from geomhw.results import Field, Result
from geomhw.scalars import diffusion_time, local_extrema

GEOMHW = str(Path(sys.executable).with_name("geomhw"))
LIMIT, WIDTH, APART = 20.0, 12.0, 10.0


class Bench:
    """Files of one surface in a folder, and the rows of its table."""

    def __init__(self, name: str, mesh: TriangleMesh, folder: Path) -> None:
        self.name, self.mesh, self.folder = name, mesh, folder
        write(Result(mesh), folder / "s.surf.gii")
        self.mesh = read(folder / "s.surf.gii").mesh  # both read single precision

    def run(self, *command: str) -> float:
        """Return the seconds of processor time of one run, the start of the program included."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, cwd=self.folder, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def both(self, theirs: str, ours: str) -> tuple[float, float]:
        """Run a call of each."""
        return self.run("wb_command", *theirs.split()), self.run(GEOMHW, *ours.split())

    def array(self, name: str, key: str = "0") -> Floats:
        return np.asarray(read_field(f"{self.folder / name}:{key}", self.mesh).values, dtype=float)

    def row(self, call: str, unit: str, errors: tuple[float, float], seconds: tuple[float, float]) -> None:
        """Print a row: error and time of Workbench, then of geomhw."""
        print(f"| {self.name} | `{call}` | {unit} | {errors[0]:.3g} | {errors[1]:.3g} | "
              f"{seconds[0]:.2f} | {seconds[1]:.2f} |", flush=True)  # fmt: skip


def distances(b: Bench) -> None:
    """Distance from a vertex, everywhere and within a limit."""
    exact = np.asarray(ExactDistance(b.mesh).from_vertices([100])["distance"])
    for limit in (np.inf, LIMIT):
        near = (exact > 0) & (exact <= limit)
        w, g = ("", "") if limit == np.inf else (f"-limit {limit}", f"--limit {limit} --beyond -1")
        seconds = b.both(
            f"-surface-geodesic-distance s.surf.gii 100 w.func.gii {w}",
            f"geodesic s.surf.gii --method exact --source 100 {g} -o g.func.gii --no-png -q",
        )
        errors = []
        for name in ("w", "g"):
            found = b.array(f"{name}.func.gii")
            errors.append(float(100 * np.abs(found[near] / exact[near] - 1)[found[near] >= 0].mean()))
        b.row(f"-surface-geodesic-distance {w}".strip(), "mean error, %", (errors[0], errors[1]), seconds)


def all_to_all(b: Bench) -> None:
    """Distances between all vertices within a limit, and between those of a region."""
    inside = np.isfinite(ExactDistance(b.mesh).from_vertices([100], limit=30)["distance"]).astype(float)
    write(Result(b.mesh, [Field("roi", "vertex", inside)]), b.folder / "roi.func.gii")
    seconds = b.both(
        f"-surface-geodesic-distance-all-to-all s.surf.gii w.dconn.nii -limit {LIMIT}",
        f"geodesic s.surf.gii --method fast-marching --all-pairs --limit {LIMIT} -o g.npz --no-png -q",
    )
    theirs, ours = nibabel.load(b.folder / "w.dconn.nii").dataobj, read_arrays(b.folder / "g.npz")["values"]
    errors = [[], []]
    for v in np.random.default_rng(2).choice(b.mesh.n_vertices, 50, replace=False):
        exact = np.asarray(ExactDistance(b.mesh).from_vertices([v], limit=LIMIT)["distance"])
        near = (exact > 0) & np.isfinite(exact)
        for found, row in zip(errors, (np.asarray(theirs[v]), ours[[v]].toarray()[0]), strict=True):
            found.append(np.abs(row[near] / exact[near] - 1)[row[near] > 0])
    means = [float(100 * np.concatenate(found).mean()) for found in errors]
    b.row(f"-surface-geodesic-distance-all-to-all -limit {LIMIT:g}", "mean error, %", (means[0], means[1]), seconds)
    (b.folder / "roi.txt").write_text("\n".join(map(str, np.flatnonzero(inside))) + "\n")
    seconds = b.both(
        "-surface-geodesic-distance-all-to-all s.surf.gii w.dconn.nii -roi roi.func.gii",
        "geodesic s.surf.gii --method exact --sources roi.txt --to @roi.txt -o g.npy --no-png -q",
    )
    listed = np.flatnonzero(inside)
    exact = np.stack([ExactDistance(b.mesh).from_vertices([v])["distance"] for v in listed[:50]])[:, listed]
    off = exact > 0
    found = (np.asarray(nibabel.load(b.folder / "w.dconn.nii").dataobj)[:50], np.load(b.folder / "g.npy")[:50])
    errors = [float(100 * np.abs(d[off] / exact[off] - 1).mean()) for d in found]
    call = f"-surface-geodesic-distance-all-to-all -roi ({len(listed)} vertices)"
    b.row(call, "mean error, %", (errors[0], errors[1]), seconds)


def disks(b: Bench) -> None:
    """Disks round 20 vertices, of which each vertex belongs to the nearest, with weights."""
    centers = np.random.default_rng(0).choice(b.mesh.n_vertices, 20, replace=False)
    (b.folder / "centers.txt").write_text("\n".join(map(str, centers)) + "\n")
    D = ExactDistance(b.mesh)
    rows = np.stack([D.from_vertices([v])["distance"] for v in centers], axis=1)
    inside = (rows <= LIMIT) & (rows.argmin(axis=1)[:, None] == np.arange(20))
    weights = np.where(inside, np.exp(-0.5 * (np.where(inside, rows, 0) / 8) ** 2), 0)
    weights /= weights.sum(axis=0)
    for words, option, truth, unit in (
        ("-overlap-logic CLOSEST", "--overlap closest", inside, "wrong vertices, % of disks"),
        ("-gaussian 8 -overlap-logic CLOSEST", "--gaussian 8 --overlap closest", weights, "error of weights, %"),
    ):
        seconds = b.both(
            f"-surface-geodesic-rois s.surf.gii {LIMIT} centers.txt w.func.gii {words}",
            f"rois s.surf.gii --center @centers.txt --radius {LIMIT} {option} -o g.func.gii --no-png -q",
        )
        errors = []
        for name in ("w", "g"):
            found = np.stack([b.array(f"{name}.func.gii", str(k)) for k in range(20)], axis=1)
            errors.append(float(100 * np.abs(found - truth).sum() / truth.sum()))
        b.row(f"-surface-geodesic-rois {words}", unit, (errors[0], errors[1]), seconds)


def extrema(b: Bench) -> None:
    """Extrema of a random smooth function, with 10 units between them."""
    waves = np.random.default_rng(1).normal(size=(20, 3)) * 0.06
    values = np.sin(b.mesh.vertices @ waves.T + np.arange(20)).sum(axis=1)
    write(Result(b.mesh, [Field("u", "vertex", values)]), b.folder / "u.func.gii")
    seconds = b.both(
        f"-metric-extrema s.surf.gii u.func.gii {APART} w.func.gii",
        f"extrema s.surf.gii --array u.func.gii --distance {APART} -o g.func.gii --no-png -q",
    )
    exact = local_extrema(b.mesh, b.array("u.func.gii"), APART)
    marks = np.zeros(b.mesh.n_vertices)
    marks[exact.maxima], marks[exact.minima] = 1, -1
    wrong = [float((b.array(f"{name}.func.gii") != marks).sum()) for name in ("w", "g")]
    b.row("-metric-extrema", f"wrong of {int(np.abs(marks).sum())}", (wrong[0], wrong[1]), seconds)


def border(b: Bench) -> None:
    """Length of the border of a disc: the sum of the lengths of its segments."""
    b.run(GEOMHW, "rois", "s.surf.gii", "--center", "100", "--radius", str(LIMIT), "-o", "r.func.gii", "--no-png", "-q")
    for file in ("s.surf.gii", "r.func.gii"):
        b.run("wb_command", "-set-structure", file, "CORTEX_LEFT")
    b.run("wb_command", "-metric-rois-to-border", "s.surf.gii", "r.func.gii", "disc", "b.border")
    curve = read_polylines(b.folder / "b.border", b.mesh.vertices)
    inside = np.setdiff1d(np.arange(1, len(curve.points)), curve.lines)
    exact = np.linalg.norm(curve.points[inside] - curve.points[inside - 1], axis=1).sum()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = ["wb_command", "-border-length", "b.border", "s.surf.gii"]
    theirs = subprocess.run(command, cwd=b.folder, check=True, capture_output=True, text=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    ours = b.run(GEOMHW, "split", "s.surf.gii", "--curve", "b.border", "-o", "g.vtp", "--no-png", "-q")
    cut = read(b.folder / "g.vtp")
    table = cut.mesh.edge_table
    length = cut.mesh.edge_lengths[table.face_counts == 1].sum() / 2
    errors = [100 * abs(value / exact - 1) for value in (float(theirs.rsplit(":", 1)[1]), length)]
    b.row("-border-length", "error, %", (errors[0], errors[1]), (seconds, ours))


def on_a_sphere(b: Bench, mesh: TriangleMesh) -> None:
    """Gradient and smoothing against formulas, on a sphere of 100 units with these faces."""
    points = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1)[:, None]
    sphere = Bench(b.name, TriangleMesh(100 * points, mesh.faces), b.folder)
    x, y, z = (sphere.mesh.vertices / 100).T
    points, areas = np.stack([x, y, z], axis=1), sphere.mesh.vertex_areas
    write(Result(sphere.mesh, [Field("u", "vertex", x**2 + y * z)]), b.folder / "u.func.gii")
    ambient = np.stack([2 * x, z, y], axis=1)
    exact = (ambient - (ambient * points).sum(axis=1)[:, None] * points) / 100
    seconds = sphere.both(
        "-metric-gradient s.surf.gii u.func.gii w.func.gii -vectors v.func.gii",
        "gradient s.surf.gii --array u.func.gii -o g.func.gii --no-png -q",
    )
    found = [np.stack([sphere.array(name, str(k + shift)) for k in range(3)], axis=1)
             for name, shift in (("v.func.gii", 0), ("g.func.gii", 1))]  # fmt: skip
    errors = [
        float(100 * np.sqrt(areas @ ((v - exact) ** 2).sum(axis=1) / (areas @ (exact**2).sum(axis=1)))) for v in found
    ]
    sphere.row("-metric-gradient", "error, % (mean square)", (errors[0], errors[1]), seconds)
    center, t = 100, diffusion_time(WIDTH / 100)
    write(Result(sphere.mesh, [Field("u", "vertex", np.eye(1, len(points), center)[0])]), b.folder / "u.func.gii")
    seconds = sphere.both(
        f"-metric-smoothing s.surf.gii u.func.gii {WIDTH} w.func.gii -fwhm",
        f"smooth s.surf.gii --array u.func.gii --fwhm {WIDTH} -o g.func.gii --no-png -q",
    )
    degrees = np.arange(400)
    kernel = legval(points @ points[center], (2 * degrees + 1) / (4 * np.pi) * np.exp(-degrees * (degrees + 1) * t))
    kernel *= areas[center] / 100**2
    found = [sphere.array(f"{name}.func.gii") for name in "wg"]
    errors = [float(100 * np.sqrt(areas @ (u - kernel) ** 2 / (areas @ kernel**2))) for u in found]
    sphere.row(
        f"-metric-smoothing {WIDTH:g} -fwhm", "error of a point, % (mean square)", (errors[0], errors[1]), seconds
    )
    totals = [abs(float(areas @ u) / areas[center] - 1) * 100 for u in found]
    sphere.row(f"-metric-smoothing {WIDTH:g} -fwhm", "integral lost, %", (totals[0], totals[1]), seconds)


def main() -> None:
    """Print the table."""
    surfaces = [
        (f"folded sphere, {10 * 4**level + 2:,}", folded_sphere(level), folded_sphere(level)) for level in (5, 6)
    ]
    if sys.argv[1:]:
        surfaces = []
        for argument in sys.argv[1:]:
            name, _, files = argument.partition("=")
            surface, sphere = (read(path).mesh for path in files.split(","))
            surfaces.append((name, surface, sphere))
    print("| surface | call | error | wb_command | geomhw | wb_command, s | geomhw, s |\n|---|---|---|---|---|---|---|")
    for name, mesh, sphere in surfaces:
        with tempfile.TemporaryDirectory() as folder:
            bench = Bench(name, mesh, Path(folder))
            for part in (distances, disks, extrema, border, all_to_all):
                part(bench)
            on_a_sphere(bench, sphere)


if __name__ == "__main__":
    main()
