"""The one way in: a path, and the reader that its extension asks for."""

from collections.abc import Callable
from pathlib import Path

from geomhw.errors import FormatError
from geomhw.io.file_bytes import content
from geomhw.io.formats import meshio_read
from geomhw.io.formats.obj_read import read_obj
from geomhw.io.formats.off_read import read_off
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Result

_Reader = Callable[[str, bytes], Result]


def _vtp(name: str, data: bytes) -> Result:
    from geomhw.io.formats.vtk_xml_read import read_vtp

    return read_vtp(name, data)


def _vtu(name: str, data: bytes) -> Result:
    from geomhw.io.formats.vtk_xml_read import read_vtu

    return read_vtu(name, data)


def _vtk(name: str, data: bytes) -> Result:
    from geomhw.io.formats.vtk_read import read_vtk

    return read_vtk(name, data)


def _ply(name: str, data: bytes) -> Result:
    from geomhw.io.formats.ply_read import read_ply

    return read_ply(name, data)


def _stl(name: str, data: bytes) -> Result:
    from geomhw.io.formats.stl_read import read_stl

    return read_stl(name, data)


# Text formats are imported at once; the others when one is met, for the sake of start-up.
_READERS: dict[str, _Reader] = {
    ".off": read_off,
    ".obj": read_obj,
    ".ply": _ply,
    ".stl": _stl,
    ".vtk": _vtk,
    ".vtp": _vtp,
    ".vtu": _vtu,
}

#: Extensions that ``read`` knows.
READABLE = (*_READERS, *meshio_read.FORMATS)


def read(path: str | Path) -> Result:
    """The mesh in a file, the arrays on it as fields, and a report: file, format, ``polygons`` (those fanned), ...

    Vertices and faces keep the order of the file; a polygon becomes the fan of its first corner.
    """
    path = Path(path)
    extension = path.suffix.lower()
    if extension not in READABLE:
        said = f"'{path.suffix}' is not a mesh format that is read" if path.suffix else "the name has no extension"
        raise FormatError(f"{path}: {said}; known are {' '.join(READABLE)}")
    data = _bytes(path)
    return _READERS[extension](path.name, data) if extension in _READERS else meshio_read.read_external(path)


def read_mesh(path: str | Path) -> TriangleMesh:
    """The mesh alone."""
    return read(path).mesh


def read_cloud(path: str | Path) -> Cloud:
    """The points of a ``.vtp`` with the arrays on them; faces are passed over."""
    from geomhw.io.formats.vtk_xml_read import read_vtp_cloud

    path = Path(path)
    return read_vtp_cloud(path.name, _bytes(path))


def _bytes(path: Path) -> bytes:
    """What is in the file; one that is empty is refused."""
    return content(path, 1 if path.suffix.lower() in meshio_read.FORMATS else None)
