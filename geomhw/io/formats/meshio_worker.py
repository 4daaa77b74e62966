"""The process in which meshio reads a file, with limits on processor time and memory.

Standard output carries the pickled `Polygons` of the file, or the pickled FormatError that refuses it.
"""

import contextlib
import io
import os
import pickle
import re
import signal
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.file_content import read_bytes
from geomhw.io.formats.polygons import Polygons, plane_pieces
from geomhw.wording import counted

#: Processor time for any file, in seconds, and for each byte: ten times what meshio takes on its slowest formats.
SECONDS, SECONDS_A_BYTE = 1.0, 1e-5
#: Memory for any file beyond that of the libraries, in bytes, and for each byte of the file.
MEMORY, MEMORY_A_BYTE = 1 << 25, 20
_TOO_MUCH = "it asks for more memory than a file of its size can need"
#: Sections of Gmsh files beside the geometry, as patterns: data on elements, which meshio reads only if all elements
#: have them, and groups of elements.
_GMSH_EXTRAS = ("Element(?:Node)?Data", "(?:Element|Node|ElementNode)Data|Periodic|PhysicalNames|Entities")
#: Faces by meshio's names: their corners, and nodes of second order.
_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
_CURVED = {"triangle6": 6, "quad8": 8, "quad9": 9}
_FACES = re.compile("triangle6?|quad[89]?|polygon.*")
_VOLUMES = ("tetra", "hexahedron", "wedge", "pyramid", "penta", "polyhedron", "voxel")


def main(path: Path, kind: str) -> None:
    """Read a file, reply on standard output, and exit; a signal ends the process after too much processor time."""
    import meshio  # noqa: F401  # before time and memory are counted

    limit(path.stat().st_size)
    with os.fdopen(1, "wb") as stream:
        reply(path, kind, stream)


def reply(path: Path, kind: str, stream: BinaryIO) -> None:
    """Write the polygons of a file, or the error that refuses it."""
    try:
        answer = pickle.dumps(surface(path.name, extract(path, kind)), protocol=5)
        # An array may have the length that a header announces, filled with other contents of the memory.
        if len(answer) > MEMORY_A_BYTE * max(path.stat().st_size, 1 << 10):
            raise unreadable(path, kind, _TOO_MUCH)
    except FormatError as error:
        answer = pickle.dumps(error)
    stream.write(answer)


def unreadable(path: Path, kind: str, reason: str) -> FormatError:
    """Return the error for a file that meshio cannot read."""
    return FormatError(f"{path.name} cannot be read as {kind}" + (f": {reason}" if reason else ""))


def extract(path: Path, kind: str) -> Any:
    """Return meshio's mesh; FormatError where meshio does anything but return."""
    try:
        return _meshio_mesh(path)
    except MemoryError:
        raise unreadable(path, kind, _TOO_MUCH) from None
    except (Exception, SystemExit) as error:
        if kind == "Gmsh":
            for sections in _GMSH_EXTRAS:
                with contextlib.suppress(Exception, SystemExit):
                    return _without_sections(path, sections)
        reason = "" if isinstance(error, SystemExit) else " ".join(str(error).split())[:200]
        if kind == "Gmsh" and (version := _gmsh_version(path)) not in ("2", "2.2", "4", "4.0", "4.1"):
            reason = f"it is in version {version} of the format; save it in version 2.2 or 4.1"
        raise unreadable(path, kind, reason) from error


def _gmsh_version(path: Path) -> str:
    """The version of the format of a Gmsh file; files of version 1 do not name it."""
    start = read_bytes(path, limit=1 << 10)
    found = re.search(rb"\$MeshFormat\s+(\d[\d.]{,9})", start)
    return found[1].decode() if found else "1" if re.match(rb"\s*\$(?:NOD|PTS)\b", start) else "2"


def _without_sections(path: Path, sections: str) -> Any:
    """Return meshio's mesh of a Gmsh file without some sections; ValueError if it has none of them."""
    pattern = re.compile(rb"^\$(%s)\b.*?^\$End\1[^\n]*\n?" % sections.encode(), re.DOTALL | re.MULTILINE)
    data = path.read_bytes()
    names = sorted({match[1].decode() for match in pattern.finditer(data)})
    if not names:
        raise ValueError("no such section")
    with tempfile.TemporaryDirectory() as folder:
        reduced = Path(folder) / path.name
        reduced.write_bytes(pattern.sub(b"", data))
        mesh = _meshio_mesh(reduced)
    mesh.info = {"remarks": [f"left out the sections {', '.join(names)}, which do not fit the elements"]}
    return mesh


def _meshio_mesh(path: Path) -> Any:
    """Return meshio's mesh of a file; what it prints is lost."""
    import meshio

    silent = io.StringIO()
    with (
        contextlib.redirect_stdout(silent),
        contextlib.redirect_stderr(silent),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        return meshio.read(path)


def surface(name: str, mesh: Any) -> Polygons:
    """Return the triangles, quads and polygons of meshio's mesh in file order, with arrays that all of them have."""
    faces = [i for i, block in enumerate(mesh.cells) if _FACES.fullmatch(block.type)]
    ignored = sorted({block.type for i, block in enumerate(mesh.cells) if i not in faces})
    if not faces:
        kinds = ", ".join(ignored)
        if any(kind.startswith(_VOLUMES) for kind in ignored):
            raise FormatError(f"{name} holds volume cells ({kinds}) and no faces; extract its surface first")
        raise FormatError(f"{name} holds no triangles or polygons" + (f", only {kinds}" if kinds else ""))
    pieces = [_pieces(name, mesh.cells[i]) for i in faces]
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise FormatError(f"{name} holds points of shape {points.shape}; they need two or three coordinates")
    remarks = [*(mesh.info or {}).get("remarks", ())]
    if any(kind.startswith(_VOLUMES) for kind in ignored):
        remarks.append(f"left out cells that are no faces: {', '.join(ignored)}")
    if curved := sum(len(mesh.cells[i].data) for i in faces if _is_curved(mesh.cells[i])):
        remarks.append(f"divided {counted(curved, 'face')} of second order into plane pieces at their nodes")
    partial = [key for key, values in mesh.cell_data.items() if not _on_all(values, mesh.cells)]
    remarks += [f"left out the array {key}, which not all cells have" for key in partial]
    return Polygons(
        points=np.pad(points, ((0, 0), (0, 3 - points.shape[1]))),  # a flat file has z = 0
        corners=np.concatenate([corners for corners, _, _ in pieces]).astype(np.int64),
        sizes=np.concatenate([sizes for _, sizes, _ in pieces]),
        vertex_arrays=_joined({key: [values] for key, values in mesh.point_data.items()}),
        face_arrays=_joined(
            {
                key: [np.asarray(values[i])[origin] for i, (_, _, origin) in zip(faces, pieces, strict=True)]
                for key, values in mesh.cell_data.items()
                if key not in partial
            }
        ),
        notes={"ignored": ignored} if ignored else {},
        remarks=remarks,
    )


def _pieces(name: str, cells: Any) -> tuple[Ints, Ints, Any]:
    """Corners, flat, and sizes of the polygons of a block of cells, and the cell of each.

    The nodes on the sides of Nastran's faces of second order may be left blank, all of them.
    """
    nodes = np.asarray(cells.data)
    if nodes.ndim != 2 or nodes.dtype.kind not in "iu":
        raise FormatError(f"{name} holds faces without corners")
    if _is_curved(cells):
        return plane_pieces(nodes)
    if nodes.shape[1] != _CORNERS.get(cells.type, nodes.shape[1]):
        raise FormatError(f"{name} holds faces of kind {cells.type} with {nodes.shape[1]} nodes")
    return nodes.ravel(), np.full(len(nodes), nodes.shape[1]), slice(None)


def _is_curved(cells: Any) -> bool:
    return np.shape(cells.data)[1:] == (_CURVED.get(cells.type),)


def _on_all(values: list[Any], cells: list[Any]) -> bool:
    """Whether an array has a value for each cell; Nastran files may name the property of some of them."""
    sizes = [np.asarray(part).shape[:1] for part in values]
    return sizes == [(len(block.data),) for block in cells]


def _joined(arrays: dict[str, list[Any]]) -> dict[str, NDArray[Any]]:
    """Arrays by name, with the parts of all blocks concatenated; without those that some block lacks."""
    joined = {}
    for name, values in arrays.items():
        parts = [np.asarray(part) for part in values]
        if all(part.ndim and part.dtype.kind in "fiub" for part in parts) and len({p.shape[1:] for p in parts}) == 1:
            joined[str(name)] = np.concatenate(parts)
    return joined


def limit(size: int) -> None:
    """Let SIGPROF end this process after its time for a file, and limit its memory; without effect outside of Unix."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, SECONDS + SECONDS_A_BYTE * size)
    if sys.platform.startswith("linux"):
        import resource

        most = address_space(size)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def address_space(size: int) -> int:
    """Return the bytes that this process (on Linux) may have in all while it reads a file of a size."""
    import resource

    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    return used + MEMORY + MEMORY_A_BYTE * size
