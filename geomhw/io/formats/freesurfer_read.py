"""Readers of FreeSurfer's binary surfaces and of its arrays on vertices: curv, overlays (MGH), annot and label files.

Hand-written because these files have no extension of their own, and nibabel trusts the counts in them.
"""

import re
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FieldError, FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons
from geomhw.results import Field, Result
from geomhw.wording import counted

_TRIANGLES, _QUADS, _NEW_QUADS = b"\xff\xff\xfe", b"\xff\xff\xff", b"\xff\xff\xfd"
_CURV_HEAD, _MGH_HEAD = 15, 284
_MGH_TYPES = {0: "u1", 1: ">i4", 3: ">f4", 4: ">i2"}
_LABEL = re.compile(rb"#!ascii label")
_CENTER = re.compile(rb"cras\s*=\s*(\S+)\s+(\S+)\s+(\S+)")
#: Bytes that an ``.mgz`` may have unpacked, for any file and for each packed byte.
_LEAST_LIMIT, _MOST_RATIO = 1 << 20, 100


def is_surface(head: bytes, size: int) -> bool:
    """Whether a file of some size with these first bytes is a surface in one of FreeSurfer's binary formats."""
    return head[:3] in (_TRIANGLES, _NEW_QUADS) or (head[:3] == _QUADS and not _is_curv(head, size))


def read_freesurfer(name: str, data: bytes) -> Result:
    """Return the triangles, or the quads as triangles, of a surface; coordinates stay FreeSurfer's (tkRAS)."""
    if not is_surface(data, len(data)):
        raise FormatError(f"{name} is no surface of FreeSurfer: its first three bytes are not the mark of one")
    try:
        points, corners, width, end = _triangles(data) if data[:3] == _TRIANGLES else _quads(data)
    except ValueError as error:
        raise FormatError(f"{name} is not a whole surface of FreeSurfer: {error}") from None
    notes: dict[str, Any] = {}
    remarks: list[str] = []
    center = _CENTER.search(data, end)
    try:
        offset = [float(number) for number in center.groups()] if center else [0.0] * 3
    except ValueError:
        offset = [0.0] * 3
    if any(offset) and np.isfinite(offset).all():
        notes["c_ras"] = offset
        shown = ", ".join(f"{number:g}" for number in offset)
        remarks.append(
            f"the coordinates are FreeSurfer's (tkRAS), without the offset c_ras = ({shown}) to the scanner's"
        )
    sizes = np.full(len(corners) // width, width)
    return build_result(name, "FreeSurfer", Polygons(points, corners, sizes, notes=notes, remarks=remarks))


_Geometry = tuple[NDArray[Any], NDArray[Any], int, int]


def _triangles(data: bytes) -> _Geometry:
    """Points, corners, corners of a face, and the end of them: two lines of text come before the counts."""
    begin = data.find(b"\n", 3, 3 + (1 << 16)) + 1
    if not begin:
        raise ValueError("its first line does not end")
    begin += data[begin : begin + 1] == b"\n"
    n, m = _integers(data, begin, 2).tolist()
    points, begin = _taken(data, begin + 8, ">f4", 3 * n)
    corners, begin = _taken(data, begin, ">i4", 3 * m)
    return points.reshape(-1, 3), corners, 3, begin


def _quads(data: bytes) -> _Geometry:
    """As `_triangles`, of the older format: counts and corners of three bytes, coordinates in hundredths."""
    n, m = (int.from_bytes(data[k : k + 3], "big") for k in (3, 6))
    is_new = data[:3] == _NEW_QUADS
    points, begin = _taken(data, 9, ">f4" if is_new else ">i2", 3 * n)
    digits, begin = _taken(data, begin, "u1", 12 * m)
    corners = digits.reshape(-1, 3).astype(np.int32) @ np.array([1 << 16, 1 << 8, 1], np.int32)
    return (points if is_new else points / 100).reshape(-1, 3), corners, 4, begin


def _taken(data: bytes, begin: int, kind: str, count: int) -> tuple[NDArray[Any], int]:
    """Numbers, and where they end; ValueError if they are not all there."""
    end = begin + np.dtype(kind).itemsize * count
    if count < 0 or end > len(data):
        raise ValueError(f"it needs {end} bytes and has {len(data)}" if count >= 0 else f"a count is {count}")
    return np.frombuffer(data, kind, count, begin), end


def _integers(data: bytes, begin: int, count: int) -> NDArray[Any]:
    return _taken(data, begin, ">i4", count)[0]


def _is_curv(head: bytes, size: int) -> bool:
    """Whether a file has the size of a curv file with the counts in it; quads start with the same mark."""
    n, _, width = np.frombuffer(head[3:_CURV_HEAD], ">i4").tolist() if len(head) >= _CURV_HEAD else [0, 0, 0]
    return bool(n > 0 and width > 0 and size == _CURV_HEAD + 4 * n * width)


def read_freesurfer_arrays(name: str, data: bytes, vertices: int) -> list[Field]:
    """Return the arrays of a file on a mesh with a number of vertices; an empty list if it is none of FreeSurfer's.

    A label file gives ``label``, 1 on its vertices, and ``value``, its last column, 0 elsewhere.
    """
    try:
        if data.startswith(b"\x1f\x8b") and name.lower().endswith(".mgz"):
            data = _unzipped(data)
        if _LABEL.match(data):
            return _label(name, data, vertices)
        if data[:3] == _QUADS and _is_curv(data, len(data)):
            n, _, width = np.frombuffer(data[3:_CURV_HEAD], ">i4").tolist()
            return _columns(name, np.frombuffer(data, ">f4", n * width, _CURV_HEAD).reshape(n, width).T, vertices)
        if len(data) == 6 + 2 * vertices and int.from_bytes(data[:3], "big") == vertices:
            return _columns(
                name, np.frombuffer(data, ">i2", vertices, 6)[None] / 100, vertices
            )  # curv files of the past
        if data[:4] == b"\0\0\0\1" and len(data) >= _MGH_HEAD:
            return _columns(name, _overlay(data), vertices)
        if name.lower().endswith(".annot"):
            return [_annotation(name.removesuffix(".annot"), data)]
    except (ValueError, OverflowError, zlib.error) as error:
        raise FormatError(f"{name} is not a whole file of FreeSurfer: {' '.join(str(error).split())[:150]}") from None
    return []


def _columns(name: str, columns: NDArray[Any], vertices: int) -> list[Field]:
    """Arrays by the name of the file, numbered if there are several."""
    if columns.shape[1] != vertices:
        raise FieldError(f"{name} has {columns.shape[1]} rows; the mesh has {vertices} vertices")
    stem = name.removesuffix(".mgz").removesuffix(".mgh")
    names = [stem] if len(columns) == 1 else [f"{stem}_{k}" for k in range(len(columns))]
    return [Field(name, "vertex", values) for name, values in zip(names, columns, strict=True)]


def _unzipped(data: bytes) -> bytes:
    unpacker = zlib.decompressobj(wbits=31)
    limit = _LEAST_LIMIT + _MOST_RATIO * len(data)
    plain = unpacker.decompress(data, limit)
    if not unpacker.eof:
        raise ValueError("the compressed file ends early" if len(plain) < limit else f"it unpacks to {limit} bytes")
    return plain


def _overlay(data: bytes) -> NDArray[Any]:
    """The frames of an MGH file, (frames, vertices)."""
    *sizes, frames, kind = _integers(data, 4, 5).tolist()
    if min(*sizes, frames) < 1 or kind not in _MGH_TYPES:
        raise ValueError(f"an image of {sizes} voxels in {frames} frames of type {kind}")
    rows = sizes[0] * sizes[1] * sizes[2]
    values, _ = _taken(data, _MGH_HEAD, _MGH_TYPES[kind], rows * frames)
    return values.reshape(frames, rows)


def _label(name: str, data: bytes, vertices: int) -> list[Field]:
    """The vertices of a text file: a remark, their number, and a line of index, position and value for each."""
    lines = data.decode("utf-8").split("\n")[1:]
    count = int(lines[0]) if lines else 0
    rows = [line.split() for line in lines[1:] if line.strip()]
    if len(rows) != count or any(len(row) != 5 for row in rows):
        raise ValueError(f"it says {counted(count, 'vertex', 'vertices')} and has {counted(len(rows), 'line')}")
    listed = np.array([int(row[0]) for row in rows], np.int64)
    if len(listed) and not 0 <= listed.min() <= listed.max() < vertices:
        bad = int(listed[np.argmax((listed < 0) | (listed >= vertices))])
        raise FieldError(f"{name} names vertex {bad}; the mesh has {vertices} vertices")
    inside, values = np.zeros(vertices, np.uint8), np.zeros(vertices)
    inside[listed] = 1
    values[listed] = [float(row[4]) for row in rows]
    return [Field("label", "vertex", inside), Field("value", "vertex", values)]


def _annotation(stem: str, data: bytes) -> Field:
    """Labels as numbers of structures in the table of the file, -1 for none of them, with the names of these."""
    (n,) = _integers(data, 0, 1).tolist()
    pairs, begin = _taken(data, 4, ">i4", 2 * n)
    listed, codes = pairs.reshape(-1, 2).T
    if n < 1 or not np.array_equal(np.sort(listed), np.arange(n)):
        raise ValueError(f"it does not give each of {counted(n, 'vertex', 'vertices')} one label")
    if _integers(data, begin, 1)[0] != 1:
        raise ValueError("it has no table of labels")
    names, colors = _color_table(data, begin + 4)
    values = np.full(n, -1, np.int32)
    order = np.argsort(list(colors.values()), kind="stable")
    known = np.array(list(colors.values()), np.int64)[order]
    at = np.minimum(np.searchsorted(known, codes), len(known) - 1)
    values[listed] = np.where(known[at] == codes, np.array(list(colors), np.int32)[order][at], -1)
    return Field(stem, "vertex", values, names)


def _color_table(data: bytes, begin: int) -> tuple[dict[int, str], dict[int, int]]:
    """Names of structures by number, and the colors that stand for them: red + 256 green + 65536 blue."""
    (count,) = _integers(data, begin, 1).tolist()
    is_second = count < 0
    begin = _text(data, begin + 4 + 4 * is_second)[1]  # after the name of the file that the table comes from
    if is_second:
        if count != -2:
            raise ValueError(f"a table of labels of version {-count}")
        (count,), begin = _integers(data, begin, 1).tolist(), begin + 4
    names: dict[int, str] = {}
    colors: dict[int, int] = {}
    for entry in range(count):
        number = int(_integers(data, begin, 1)[0]) if is_second else entry
        name, begin = _text(data, begin + 4 * is_second)
        red, green, blue, _ = _integers(data, begin, 4).tolist()
        names[number], colors[number] = name, red + (green << 8) + (blue << 16)
        begin += 16
    if not names:
        raise ValueError("its table of labels is empty")
    return names, colors


def _text(data: bytes, begin: int) -> tuple[str, int]:
    """A text with its length before it, and where it ends."""
    (size,) = _integers(data, begin, 1).tolist()
    raw, end = _taken(data, begin + 4, "u1", size)
    return raw.tobytes().split(b"\0")[0].decode("utf-8", "replace"), end
