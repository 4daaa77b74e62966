"""Formats that meshio reads, in a process of its own with limits on time and memory; whatever it does becomes an error.

meshio trusts the counts in a file: on a damaged one it may loop for minutes or ask for all memory, and it may print or
call ``sys.exit``.
"""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import FormatError
from geomhw.io.formats import meshio_worker
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons
from geomhw.results import Result

#: Extension to the name of the format, as the report gives it.
FORMATS = {
    ".msh": "Gmsh",
    ".mesh": "Medit",
    ".meshb": "Medit",
    ".inp": "Abaqus",
    ".bdf": "Nastran",
    ".nas": "Nastran",
    ".vol": "Netgen",
    ".su2": "SU2",
}
_VOLUMES = ("tetra", "hexahedron", "wedge", "pyramid", "penta", "polyhedron", "voxel")
#: By the clock, where a machine is busy or knows no processor time, that many times the limit and a while to start.
_PATIENCE, _START = 20.0, 60.0


def read_external(path: Path) -> Result:
    """The triangles, quads and polygons of a file that meshio reads, in file order."""
    kind = FORMATS[path.suffix.lower()]
    try:
        found = _in_another_process(path)
    except FormatError as error:
        reason = f": {error}" if str(error) else ""
        raise FormatError(f"{path.name} cannot be read as {kind}{reason}") from error
    return surface(path.name, kind, found)


def _in_another_process(path: Path) -> dict[str, Any]:
    """What ``extract`` finds in the file."""
    # Isolated, so that no file of the user's folder is taken for a module; then with this process's own paths.
    program = f"import sys; sys.path[:] = {sys.path!r}; from pathlib import Path; "
    program += f"from {meshio_worker.__name__} import main; main(Path({str(path.absolute())!r}))"
    seconds = meshio_worker.SECONDS + meshio_worker.SECONDS_A_BYTE * path.stat().st_size
    try:
        answer = subprocess.run(
            [sys.executable, "-I", "-c", program],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_START + _PATIENCE * seconds,
        )
    except subprocess.TimeoutExpired:
        raise FormatError(_endless(seconds)) from None
    return parse_reply(answer.returncode, answer.stdout, seconds)


def parse_reply(code: int, output: bytes, seconds: float) -> dict[str, Any]:
    """What the other process says; FormatError without a file's name where it refuses, or did not get that far."""
    if code == -getattr(signal, "SIGPROF", 0):
        raise FormatError(_endless(seconds))
    if code:
        raise FormatError("its reader breaks down on it")
    if output.startswith(meshio_worker.REFUSAL):
        raise FormatError(output.removeprefix(meshio_worker.REFUSAL).decode())
    return meshio_worker.read_arrays(output)


def _endless(seconds: float) -> str:
    return f"not done after {seconds:.3g} s of computing, far more than its size explains; it is damaged"


def surface(name: str, kind: str, found: dict[str, Any]) -> Result:
    """The Result of a file, from what the other process found in it."""
    faces = [i for i, cell in enumerate(found["kinds"]) if _is_face(cell)]
    ignored = sorted({cell for i, cell in enumerate(found["kinds"]) if i not in faces})
    if not faces:
        raise FormatError(_no_faces(name, ignored))
    blocks = [found.get(f"cells_{i}", np.empty(0)) for i in faces]
    if any(block.ndim != 2 or block.dtype.kind not in "iu" for block in blocks):
        raise FormatError(f"{name} holds faces without corners")
    return build_result(
        name,
        kind,
        Polygons(
            points=_in_space(name, found["points"]),
            corners=np.concatenate([block.ravel() for block in blocks]).astype(np.int64),
            sizes=np.concatenate([np.full(len(block), block.shape[1]) for block in blocks]),
            vertex_arrays=_arrays(found, "vertex", [""]),
            face_arrays=_arrays(found, "cell", [f"_{i}" for i in faces]),
            notes={"ignored": ignored} if ignored else {},
        ),
    )


def _is_face(kind: str) -> bool:
    return kind in ("triangle", "quad") or (kind.startswith("polygon") and not kind.startswith("polyhedron"))


def _no_faces(name: str, ignored: list[str]) -> str:
    if any(kind.startswith(_VOLUMES) for kind in ignored):
        return f"{name} holds volume cells ({', '.join(ignored)}) and no faces; extract its surface first"
    return f"{name} holds no triangles or polygons" + (f", only {', '.join(ignored)}" if ignored else "")


def _in_space(name: str, points: Floats) -> Floats:
    """Points with a z, which is 0 where the file is flat."""
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise FormatError(f"{name} holds points of shape {points.shape}; they need two or three coordinates")
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def _arrays(found: dict[str, Any], place: str, ends: list[str]) -> dict[str, NDArray[Any]]:
    """Arrays by name, the parts of all blocks one after the other; without those that some block lacks."""
    arrays = {}
    for j, name in enumerate(found[f"{place}_names"]):
        parts = [found[key] for end in ends if (key := f"{place}_{j}{end}") in found]
        if (
            len(parts) == len(ends)
            and all(part.ndim for part in parts)
            and len({part.shape[1:] for part in parts}) == 1
        ):
            arrays[str(name)] = np.concatenate(parts)
    return arrays
