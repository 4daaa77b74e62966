"""Numbers of vertices and faces of a mesh file, from the first bytes of the file or from its size."""

import json
import re
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from geomhw.errors import FormatError
from geomhw.io.file_content import read_bytes, refuse_strangers
from geomhw.io.formats.ply_header import read_header
from geomhw.io.reading import READABLE, mesh_extension

#: Bytes of a file that are read, at most.
HEAD = 1 << 16
#: Bytes of a file for each vertex, of formats without counts in their first bytes; of others, the value for a file
#: whose header lacks them.
BYTES = {".obj": 70, ".stl": 500, ".gltf": 50, ".glb": 40, ".3mf": 25, ".gii": 25, ".msh": 80, ".inp": 80}
OTHER_BYTES = 70
#: Largest count that a header may hold.
_MOST = 1 << 48
_OFF = re.compile(rb"\s*(?:(?:ST|C|N|4)*(n?)OFF(?=[\s\d]))?\s*", re.IGNORECASE)
_GZIP = b"\x1f\x8b"
_Counts = tuple[int | None, int | None]


@dataclass(frozen=True)
class MeshSize:
    """Numbers of vertices and faces.

    Attributes
    ----------
    vertices, faces : int
    source : {"header", "file size"}
        Where the number of vertices, or else that of faces, comes from. The other one, if it is unknown, is that of a
        closed surface of small genus, with two faces for each vertex.
    """

    vertices: int
    faces: int
    source: Literal["header", "file size"]


def mesh_size(path: str | Path, extension: str = "") -> MeshSize:
    """Return the numbers of vertices and faces that the first 64 kB of a mesh file state, without reading on.

    Formats that state no counts there, such as OBJ, give estimates from the size of the file. Damage beyond the first
    bytes is not found.

    Parameters
    ----------
    path
        The file.
    extension
        One of ``READABLE``; by default that of the file.

    Raises
    ------
    FormatError
        If the file cannot be read or is in no format that is read.

    Examples
    --------
    >>> mesh_size("data/torus.off")
    MeshSize(vertices=1680, faces=3360, source='header')
    """
    path = Path(path)
    extension = extension or mesh_extension(path)
    head = read_bytes(path, HEAD)
    if extension not in READABLE:
        raise FormatError(f"{path}: the extension '{path.suffix}' is no mesh format that is read")
    n, m = None, None
    with suppress(ValueError, IndexError, KeyError, TypeError, FormatError, RecursionError):
        n, m = _COUNTS.get(extension, _unknown)(head, path.stat().st_size)
    counts = [count if count is not None and 0 <= count <= _MOST else None for count in (n, m)]
    match counts:
        case [None, None]:
            if not (extension == ".gii" and head.startswith(_GZIP)) and extension != ".3mf":
                refuse_strangers(path.with_suffix(extension), head)
            n = max(3, path.stat().st_size // BYTES.get(extension, OTHER_BYTES))
            return MeshSize(n, 2 * n, "file size")
        case [None, int(m)]:
            return MeshSize(m // 2 + 2, m, "header")
        case [int(n), None]:
            return MeshSize(n, max(0, 2 * n - 4), "header")
    return MeshSize(int(counts[0] or 0), int(counts[1] or 0), "header")


def _unknown(head: bytes, size: int) -> _Counts:
    """No counts."""
    return None, None


def _off(head: bytes, size: int) -> _Counts:
    """Counts after the keyword and comments, as text or as binary numbers."""
    text = re.sub(rb"#[^\r\n]*", b"", head)
    keyword = _OFF.match(text)
    begin = keyword.end() if keyword else 0
    if binary := re.match(rb"BINARY[ \t\r]*\n", text[begin:], re.IGNORECASE):
        begin = head.index(binary[0].strip()) + len(binary[0])
        return int.from_bytes(head[begin : begin + 4], "big"), int.from_bytes(head[begin + 4 : begin + 8], "big")
    numbers = text[begin:].split(maxsplit=4)
    first = int(bool(keyword and keyword[1]))  # nOFF has the dimension first
    return int(numbers[first]), int(numbers[first + 1])


def _ply(head: bytes, size: int) -> _Counts:
    """Counts of the elements."""
    _, elements, _ = read_header("", head)
    counts = {element.name: element.size for element in elements}
    return counts["vertex"], counts.get("face")


def _stl(head: bytes, size: int) -> _Counts:
    """The number of triangles of a binary file."""
    count = int.from_bytes(head[80:84], "little")
    is_text = head.lstrip().lower().startswith(b"solid") and size != 84 + 50 * count and b"\0" not in head[:84]
    return None, None if is_text or len(head) < 84 else count


def _vtk(head: bytes, size: int) -> _Counts:
    """Counts behind the keywords, as far as they are in the first bytes."""
    n = re.search(rb"^[ \t]*POINTS\s+(\d+)", head, re.MULTILINE | re.IGNORECASE)
    m = re.search(rb"^[ \t]*(?:POLYGONS|CELLS)\s+(\d+)", head, re.MULTILINE | re.IGNORECASE)
    return int(n[1]) if n else None, int(m[1]) if m else None


def _vtk_xml(head: bytes, size: int) -> _Counts:
    """Counts of the pieces, as far as they are in the first bytes."""
    pieces = re.findall(rb"<Piece\b[^>]*>", head)
    counts = [
        sum(int(found[1]) for piece in pieces for found in re.finditer(rb"\b%s\s*=\s*[\"'](\d+)" % name, piece))
        for name in (rb"NumberOfPoints", rb"NumberOf(?:Polys|Strips|Cells)")
    ]
    return (counts[0], counts[1]) if pieces else (None, None)


def _gifti(head: bytes, size: int) -> _Counts:
    """Dimensions of the arrays, as far as they are in the first bytes, which may be compressed."""
    if head.startswith(_GZIP):
        with suppress(zlib.error):
            head = zlib.decompressobj(31).decompress(head, 4 * HEAD)
    sizes: dict[bytes, int] = {}
    for array in re.findall(rb"<DataArray\b[^>]*>", head):
        intent = re.search(rb"Intent\s*=\s*[\"']NIFTI_INTENT_(\w+)", array)
        if intent and (rows := re.search(rb"Dim0\s*=\s*[\"'](\d+)", array)):
            sizes.setdefault(intent[1], int(rows[1]))
    return sizes.get(b"POINTSET"), sizes.get(b"TRIANGLE")


def _freesurfer(head: bytes, size: int) -> _Counts:
    """Counts of triangles after two lines of text, or of quads."""
    if head[:3] != b"\xff\xff\xfe":
        return int.from_bytes(head[3:6], "big"), 2 * int.from_bytes(head[6:9], "big")
    begin = head.index(b"\n", 3) + 1
    begin += head[begin : begin + 1] == b"\n"
    return int.from_bytes(head[begin : begin + 4], "big"), int.from_bytes(head[begin + 4 : begin + 8], "big")


def _glb(head: bytes, size: int) -> _Counts:
    """Counts of all primitives, if the JSON chunk is in the first bytes."""
    tree = json.loads(head[20 : 20 + int.from_bytes(head[12:16], "little")])
    parts = [part for mesh in tree["meshes"] for part in mesh["primitives"]]
    counts = [item["count"] for item in tree["accessors"]]
    points = [counts[part["attributes"]["POSITION"]] for part in parts]
    corners = [counts[part["indices"]] if "indices" in part else n for part, n in zip(parts, points, strict=True)]
    return sum(points), sum(corners) // 3


#: Functions from the first bytes and the size of a file to its numbers of vertices and faces, None if unknown.
_COUNTS: dict[str, Callable[[bytes, int], _Counts]] = {
    ".off": _off,
    ".ply": _ply,
    ".stl": _stl,
    ".vtk": _vtk,
    ".vtp": _vtk_xml,
    ".vtu": _vtk_xml,
    ".gii": _gifti,
    ".freesurfer": _freesurfer,
    ".glb": _glb,
}
