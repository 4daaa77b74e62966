"""Reading meshes and points: the extension of a file chooses the reader."""

import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, Literal

from geomhw.errors import FormatError
from geomhw.io import formats
from geomhw.io.file_content import COMPRESSED, read_bytes, refuse_strangers
from geomhw.io.formats.freesurfer_read import is_surface
from geomhw.io.formats.gifti_read import GZIP
from geomhw.io.formats.meshio_read import FORMATS, read_external
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import UpAxis
from geomhw.results import Cloud, Result

#: Formats with a reader of our own, ``formats.read_off`` and so on.
_OWN = (".off", ".obj", ".ply", ".stl", ".vtk", ".vtp", ".vtu", ".gii", ".freesurfer", ".glb", ".gltf", ".3mf")
#: Extensions that ``read`` knows.
READABLE = (*_OWN, *FORMATS)
#: The axis that points up by definition of a format, by its name in a report.
_UPWARD: dict[str, UpAxis] = {"GIFTI": "z", "FreeSurfer": "z", "3MF": "z", "glTF": "y", "GLB": "y"}


def upward_axis(content: Result) -> UpAxis | Literal[""]:
    """Return the axis that points up by definition of the format that a mesh was read from; "": it defines none."""
    return _UPWARD.get(content.report.get("format", ""), "")


def read(source: str | Path | BinaryIO, extension: str = "") -> Result:
    """Read a mesh and the arrays on it.

    Parameters
    ----------
    source
        File, or stream of bytes, which is read to its end.
    extension
        One of ``READABLE``; by default that of the file.

    Returns
    -------
    The mesh, with vertices and faces in the order of the file; its numeric arrays of up to nine components as fields;
    and a report with ``file``, ``format``, and where they apply ``polygons`` (number of polygons that were divided into
    triangles), ``ignored`` (kinds of elements left out), ``single_precision`` (names of arrays stored with 4 bytes a
    number) and ``remarks`` (sentences on what was left out, joined or moved, such as faces of two corners).

    Raises
    ------
    FormatError
        If the file cannot be read, is no regular file, or is damaged; the message gives the line or the element.
    MeshError
        If a coordinate is not finite.

    Examples
    --------
    >>> from geomhw.io import read
    >>> result = read("data/creature.obj")
    >>> result.report
    {'file': 'creature.obj', 'format': 'OBJ'}
    """
    path = Path(source) if isinstance(source, str | Path) else Path("standard input")
    if isinstance(source, str | Path):
        extension = extension or mesh_extension(path)
    extension = extension or path.suffix.lower()
    if extension in COMPRESSED:
        raise FormatError(f"{path} is a compressed file or an archive; take the mesh out first")
    if extension not in READABLE:
        reason = f"'{extension}' is not a mesh format that is read" if extension else "the name has no extension"
        lost = "" if os.path.exists(path) else "there is no such file, and "
        raise FormatError(f"{path}: {lost}{reason}; known are {' '.join(READABLE)}")
    if isinstance(source, str | Path) and extension in FORMATS and extension == path.suffix.lower():
        refuse_strangers(path, read_bytes(path, limit=64))  # and what cannot be opened, as for other formats
        return read_external(path)
    data = read_bytes(path) if isinstance(source, str | Path) else source.read()
    if not data:
        raise FormatError(f"{path} is empty")
    if extension in FORMATS:
        return _read_as(path.name + extension, data)
    reader: Callable[..., Result] = getattr(formats, f"read_{extension[1:]}")
    beside = {"folder": path.parent} if extension == ".gltf" and isinstance(source, str | Path) else {}
    try:
        return reader(path.name, data, **beside)
    except FormatError:
        if not data.startswith({".gii": GZIP, ".3mf": b"PK"}.get(extension, b"\0\0none")):
            refuse_strangers(path, data)
        raise


def mesh_extension(path: Path) -> str:
    """Return the extension that stands for the format of a mesh file, or "" if it is unknown.

    A ``.gii.gz`` is ``.gii``; FreeSurfer's surfaces, such as ``lh.white``, are ``.freesurfer`` by their first bytes.
    """
    extension = path.suffix.lower()
    if extension in READABLE:
        return extension
    if path.name.lower().endswith(".gii.gz"):
        return ".gii"
    with suppress(FormatError):
        return ".freesurfer" if is_surface(read_bytes(path, limit=64), path.stat().st_size) else ""
    return ""


def _read_as(name: str, data: bytes) -> Result:
    """Read bytes in a format of meshio, which takes files with its extensions only."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        return read(path)


def read_mesh(path: str | Path) -> TriangleMesh:
    """Read a mesh without its arrays; parameters and errors are those of `read`."""
    return read(path).mesh


def read_cloud(path: str | Path) -> Cloud:
    """Read the points and polylines of a ``.vtp`` file with the arrays on the points; other cells are ignored.

    Raises
    ------
    FormatError
        If the file cannot be read or is damaged.
    """
    return formats.read_vtp_cloud(Path(path).name, read_bytes(Path(path)))
