"""Reading and writing beside meshio and libigl: seconds, their ratios, and memory over the size of the file.

``make bench`` runs it. Each figure comes from a process of its own, the three libraries in turn. Prints Markdown.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.io import write
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

LEVELS = (7, 8)
ROUNDS = 3
LIBRARIES = ("geomhw", "meshio", "libigl")
WRITTEN = ("vtk", "vtp", "vtu", "ply")


def main() -> None:
    """Both tables; or, as a process of its own, one figure."""
    if len(sys.argv) > 1:
        print(json.dumps(measured(*sys.argv[1:])))
        return
    with tempfile.TemporaryDirectory() as folder:
        for title, cases in (("read", readings), ("write, with three arrays a vertex, two vectors a face", writings)):
            row(title, "vertices", "MB", *(f"{name}, s" for name in LIBRARIES), "x meshio", "x libigl", "memory/file")
            row(*["---"] * 9)
            for level in LEVELS:
                cases(icosphere(level), Path(folder))
            print()


def readings(mesh: TriangleMesh, folder: Path) -> None:
    """A line for each format that is read."""
    for name, lines in texts(mesh).items():
        path = folder / f"ball.{name[:3]}"
        path.write_text("\n".join(lines) + "\n")
        compare(name, mesh, "read", path)
    write(Result(mesh), folder / "ball.ply")
    compare("ply, binary", mesh, "read", folder / "ball.ply")


def writings(mesh: TriangleMesh, folder: Path) -> None:
    """A line for each format that is written; libigl writes no arrays, and meshio no VTP."""
    a, b, c = mesh.vertices.T
    v, w = mesh.face_normals, mesh.face_centers
    np.savez(folder / "full.npz", p=mesh.vertices, t=mesh.faces, a=a, b=b, c=c, v=v, w=w)
    np.savez(folder / "bare.npz", p=mesh.vertices, t=mesh.faces)
    for kind in WRITTEN:
        peers = () if kind == "vtp" else ("meshio",)
        compare(kind, mesh, f"write {kind}", folder / "full.npz", ("geomhw", *peers))
    compare("ply, no arrays", mesh, "write ply", folder / "bare.npz")


def texts(mesh: TriangleMesh) -> dict[str, list[str]]:
    """The mesh in text formats, all digits."""
    n, m, faces = mesh.n_vertices, mesh.n_faces, mesh.faces.tolist()
    points = [" ".join(map(repr, point)) for point in mesh.vertices.tolist()]
    corners = [f"3 {a} {b} {c}" for a, b, c in faces]
    normals = [f"vn {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.vertices.tolist()]
    head = ["ply", "format ascii 1.0", f"element vertex {n}", *(f"property double {axis}" for axis in "xyz")]
    head += [f"element face {m}", "property list uchar int vertex_indices", "end_header"]
    vertices = [f"v {point}" for point in points]
    pairs = [f"f {a + 1}//{a + 1} {b + 1}//{b + 1} {c + 1}//{c + 1}" for a, b, c in faces]
    triples = ["f " + " ".join(f"{i + 1}/{i + 1}/{i + 1}" for i in face) for face in faces]
    return {
        "off": [f"OFF\n{n} {m} 0", *points, *corners],
        "obj": [*vertices, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces)],
        "obj v//vn": [*vertices, *normals, *pairs],
        "obj v/vt/vn": [*vertices, *(f"vt {x:.6f} {y:.6f}" for x, y, _ in mesh.vertices.tolist()), *normals, *triples],
        "ply, text": [*head, *points, *corners],
    }


def compare(name: str, mesh: TriangleMesh, action: str, path: Path, libraries: tuple[str, ...] = LIBRARIES) -> None:
    """A line of the table."""
    figures: dict[str, list[dict[str, float]]] = {library: [] for library in libraries}
    for _ in range(ROUNDS):
        for library in libraries:
            command = [sys.executable, __file__, library, action, str(path)]
            answer = subprocess.run(command, check=True, capture_output=True, text=True)
            figures[library].append(json.loads(answer.stdout.splitlines()[-1]))
    seconds = {library: statistics.median(one["seconds"] for one in found) for library, found in figures.items()}
    ours = figures["geomhw"][0]
    ratios = [f"{seconds[peer] / seconds['geomhw']:.1f}" if peer in seconds else "-" for peer in LIBRARIES[1:]]
    shown = [f"{seconds[library]:.3f}" if library in seconds else "-" for library in LIBRARIES]
    memory = f"{max(one['memory'] for one in figures['geomhw']):.1f}"
    row(name, f"{mesh.n_vertices:,}", f"{ours['bytes'] / 1e6:.1f}", *shown, *ratios, memory)


# -- one figure, in a process of its own -------------------------------------------------------------------------------


def measured(library: str, action: str, path: str) -> dict[str, float]:
    """Seconds (the median of some), bytes of the file, and by how many of its sizes memory grew the first time."""
    call, file = reader(library, path) if action == "read" else writer(library, action.split()[1], path)
    before = memory("VmRSS", reset=True)
    seconds: list[float] = []
    while not seconds or (sum(seconds) < 1 and len(seconds) < 9):
        start = time.perf_counter()
        answer = call()
        seconds.append(time.perf_counter() - start)
        del answer
        if len(seconds) == 1:
            grown = memory("VmHWM") - before
    size = Path(file).stat().st_size
    return {"seconds": statistics.median(seconds), "bytes": size, "memory": grown / size}


def memory(key: str, *, reset: bool = False) -> int:
    """Bytes that this process holds (VmRSS) or held at most since the reset (VmHWM); of Linux alone, else 0."""
    status = Path("/proc/self/status")
    if not status.exists():
        return 0
    if reset:
        Path("/proc/self/clear_refs").write_text("5")
    return 1024 * next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith(key))


def reader(library: str, path: str) -> tuple[Callable[[], Any], str]:
    """What reads the file, with everything imported that it takes."""
    if library == "meshio":
        import meshio

        return lambda: meshio.read(path), path
    if library == "libigl":
        import igl

        return lambda: igl.read_triangle_mesh(path), path
    from geomhw.io import read

    import_module("geomhw.io.formats.ply_read")  # else imported at the first file

    return lambda: read(path), path


def writer(library: str, kind: str, arrays: str) -> tuple[Callable[[], Any], str]:
    """What writes the arrays of the file to another, of this kind, beside it."""
    found = dict(np.load(arrays))
    points, faces = found.pop("p"), found.pop("t")
    target = str(Path(arrays).with_name(f"{library}.{kind}"))
    if library == "meshio":
        import meshio

        scalars = {name: values for name, values in found.items() if values.ndim == 1}
        vectors = {name: [values] for name, values in found.items() if values.ndim == 2}
        mesh = meshio.Mesh(points, [("triangle", faces)], point_data=scalars, cell_data=vectors)
        return lambda: meshio.write(target, mesh), target
    if library == "libigl":
        import igl

        wide = faces.astype(np.int64)
        return lambda: igl.write_triangle_mesh(target, points, wide), target
    fields = [Field(name, "vertex" if values.ndim == 1 else "face", values) for name, values in found.items()]
    result = Result(TriangleMesh(points, faces), fields)
    return lambda: write(result, target), target


def row(*cells: Any) -> None:
    """A line of a Markdown table."""
    print("|", " | ".join(map(str, cells)), "|", flush=True)


if __name__ == "__main__":
    main()
