"""Processor seconds and peak memory of whole runs of ``geomhw geodesic``, from which ``--estimate`` has its constants.

``python tests/benchmarks/costs.py`` prints a row for each run: options, mesh, vertices, seconds, megabytes, and what
``--estimate`` says of both. With words, only rows in which one of them occurs. The folder that GEOMHW_REFERENCE names
adds its armadillo and camel head.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

#: Writes the meshes in a process of its own, whose memory would count for its children.
MESHES = """
import os
from pathlib import Path
from distances import quartered
from geomhw.io import read_mesh, write
from geomhw.mesh.primitives import icosphere, torus
from geomhw.results import Result
meshes = {f"sphere{k}": icosphere(k) for k in range(3, 9)} | {"torus": torus(1000, 1000)}
if folder := os.environ.get("GEOMHW_REFERENCE"):
    meshes["camelhead"] = read_mesh(Path(folder) / "meshes/hostile/camelhead.off")
    meshes["armadillo"] = read_mesh(Path(folder) / "meshes/closed/armadillo.obj")
    meshes["armadillo4"] = quartered(meshes["armadillo"])
for name, mesh in meshes.items():
    write(Result(mesh), [f"{name}-{mesh.n_vertices}.ply"])
    if mesh.n_vertices > 1e5:
        lines = [f"OFF\\n{mesh.n_vertices} {mesh.n_faces} 0"]
        lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
        lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
        Path(f"{name}-{mesh.n_vertices}.off").write_text("\\n".join(lines))
"""
#: Options of runs, and the most vertices that they are for.
RUNS = {
    "--no-png": 2_000_000,
    "--no-png -q": 2_000_000,
    "": 700_000,
    "--no-png --method exact": 700_000,
    "-q --no-png --method fast-marching": 1_000_000,
    "--no-png --refine": 200_000,
    "--no-png --robust": 200_000,
    "--no-png --robust --no-refine": 700_000,
    "--no-png --solver direct": 200_000,
    "--no-png --solver multigrid": 20_000,
    "--sources 8.txt": 200_000,
    "--sources 72.txt": 200_000,
    "--sources 8.txt --method exact": 50_000,
    "--sources 72.txt --method exact": 20_000,
    "--sources 8.txt --solver multigrid": 200_000,
    "--sources 8.txt --robust --no-refine": 50_000,
    "--all-pairs --single": 12_000,
    "--all-pairs --method exact": 3_000,
    "--all-pairs --method exact --limit 0.4 -o D.npz": 50_000,
}


def main() -> None:
    """Print the rows."""
    folder = Path(tempfile.mkdtemp())
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    subprocess.run([sys.executable, "-c", MESHES], cwd=folder, env=environment, check=True)
    for count in (8, 72):
        (folder / f"{count}.txt").write_text("".join(f"{k}\n" for k in range(count)))
    meshes = sorted(folder.glob("*-*.*"), key=lambda path: (path.suffix, int(path.stem.partition("-")[2])))
    for options, most in RUNS.items():
        for mesh in meshes:
            n = int(mesh.stem.partition("-")[2])
            row = f"{options or 'default':40} {mesh.name:24} {n:9}"
            is_wanted = len(sys.argv) < 2 or any(word in row for word in sys.argv[1:])
            if is_wanted and n <= most and (mesh.suffix == ".ply" or options == "--no-png -q"):
                print(row, *measured(folder, mesh.name, options), flush=True)


def measured(folder: Path, mesh: str, options: str) -> list[str]:
    """Processor seconds and megabytes of a run, and those of its estimate."""
    many = "--sources" in options or "--all-pairs" in options
    words = [mesh, *options.split(), "--json"]
    output = ["-o", "D.npy"] if many and "-o" not in options else ["-o", "D.vtp"] if options and not many else []
    seconds, megabytes = consumed(folder, [*words, *output])
    answer = subprocess.run(command([*words, *output, "--estimate"]), cwd=folder, capture_output=True, text=True)
    found = json.loads(answer.stdout) if answer.returncode == 0 else {"processor_seconds": 0.0, "memory": 0}
    return [f"{seconds:9.2f} {megabytes:9.0f}", f"{found['processor_seconds']:9.2f} {found['memory'] / 1e6:9.0f}"]


def command(words: list[str]) -> list[str]:
    """The command line of a run."""
    return [sys.executable, "-m", "geomhw_cli", "geodesic", *words]


def consumed(folder: Path, words: list[str]) -> tuple[float, float]:
    """Processor seconds and megabytes that a run takes."""
    process = subprocess.Popen(command(words), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        return float("nan"), float("nan")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


if __name__ == "__main__":
    main()
