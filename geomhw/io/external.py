"""Formats that meshio reads; whatever it does when it fails becomes one FormatError."""

import contextlib
import io
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.assemble import Polygons, assemble
from geomhw.mesh.arrays import Floats
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


def read_external(path: Path) -> Result:
    """The triangles, quads and polygons of a file that meshio reads, in file order."""
    name, kind = path.name, FORMATS[path.suffix.lower()]
    content = _read(path, kind)
    faces = [i for i, block in enumerate(content.cells) if _is_face(block.type)]
    ignored = sorted({block.type for i, block in enumerate(content.cells) if i not in faces})
    if not faces:
        raise FormatError(_no_faces(name, ignored))
    blocks = [np.asarray(content.cells[i].data) for i in faces]
    return assemble(
        name,
        kind,
        Polygons(
            points=_in_space(name, np.asarray(content.points, dtype=np.float64)),
            corners=np.concatenate([block.ravel() for block in blocks]).astype(np.int64),
            sizes=np.concatenate([np.full(len(block), block.shape[1]) for block in blocks]),
            vertex_arrays={key: np.asarray(array) for key, array in content.point_data.items()},
            face_arrays=_face_arrays(content.cell_data, faces),
            notes={"ignored": ignored} if ignored else {},
        ),
    )


def _read(path: Path, kind: str) -> Any:
    """meshio's mesh. It may print, warn, call sys.exit or raise nearly anything on a file it does not like."""
    import meshio

    silent = io.StringIO()
    try:
        with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = "" if isinstance(error, SystemExit) else " ".join(str(error).split())[:200]
        raise FormatError(f"{path.name} cannot be read as {kind}" + (f": {reason}" if reason else "")) from error


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


def _face_arrays(cell_data: dict[str, list[Any]], faces: list[int]) -> dict[str, NDArray[Any]]:
    return {key: np.concatenate([np.asarray(blocks[i]) for i in faces]) for key, blocks in cell_data.items()}
