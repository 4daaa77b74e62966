"""VTK writers: legacy ``.vtk``, and XML ``.vtp`` and ``.vtu``. Equal results give equal bytes: no date, no version."""

import binascii
import math
from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.io.formats.xml_tree import UNWRITABLE
from geomhw.options import Location
from geomhw.results import Cloud, Field, Result

_LEGACY_TYPES = {"i1": "char", "u1": "unsigned_char", "i2": "short", "u2": "unsigned_short", "i4": "int"}
_LEGACY_TYPES |= {"u4": "unsigned_int", "i8": "vtktypeint64", "u8": "vtktypeuint64", "f4": "float", "f8": "double"}
_XML_KINDS = {"i": "Int", "u": "UInt", "f": "Float"}
_TRIANGLE = 5
#: Bytes coded in base64 at a time, a multiple of three; rows written at a time.
_CODED, _ROWS = 3 << 16, 1 << 13

#: What is written, bit by bit.
Pieces = Iterable[bytes]


def write_legacy_vtk(result: Result, path: Path) -> None:
    """Polydata in the binary legacy format of version 3.0, which VTK has read since 2000."""
    mesh = result.mesh
    with path.open("wb") as stream:
        stream.write(b"# vtk DataFile Version 3.0\ngeomhw\nBINARY\nDATASET POLYDATA\n")
        stream.writelines(_legacy_fields(_at(result, "mesh")))
        stream.write(f"POINTS {mesh.n_vertices} double\n".encode())
        stream.writelines(_big_endian(mesh.vertices))
        stream.write(f"POLYGONS {mesh.n_faces} {4 * mesh.n_faces}\n".encode())
        stream.writelines(_big_endian(mesh.faces, counted=True))
        stream.writelines(_legacy_attributes(f"POINT_DATA {mesh.n_vertices}", _at(result, "vertex")))
        stream.writelines(_legacy_attributes(f"CELL_DATA {mesh.n_faces}", _at(result, "face")))


def write_vtp(result: Result, path: Path) -> None:
    """XML polydata, arrays inline in base64."""
    mesh = result.mesh
    size = f'NumberOfPoints="{mesh.n_vertices}" NumberOfPolys="{mesh.n_faces}"'
    polys = [_xml_array("connectivity", mesh.faces.ravel()), _xml_array("offsets", _offsets(mesh.n_faces))]
    _write_xml(result, mesh.vertices, path, "PolyData", size, _element("Polys", polys))


def write_vtp_cloud(cloud: Cloud, path: Path) -> None:
    """XML polydata of a vertex cell a point."""
    count = len(cloud.points)
    verts = [_xml_array("connectivity", np.arange(count)), _xml_array("offsets", np.arange(1, count + 1))]
    size = f'NumberOfPoints="{count}" NumberOfVerts="{count}"'
    _write_xml(cloud, cloud.points, path, "PolyData", size, _element("Verts", verts))


def write_vtu(result: Result, path: Path) -> None:
    """XML unstructured grid of triangles, arrays inline in base64."""
    mesh = result.mesh
    size = f'NumberOfPoints="{mesh.n_vertices}" NumberOfCells="{mesh.n_faces}"'
    cells = [_xml_array("connectivity", mesh.faces.ravel()), _xml_array("offsets", _offsets(mesh.n_faces))]
    cells.append(_xml_array("types", np.full(mesh.n_faces, _TRIANGLE, np.uint8)))
    _write_xml(result, mesh.vertices, path, "UnstructuredGrid", size, _element("Cells", cells))


def _at(result: Result | Cloud, location: Location) -> list[tuple[str, NDArray[Any]]]:
    """Fields of one location as (rows, components) arrays, scalars as (rows,)."""
    return [(field.name, _flat(field)) for field in result.fields if field.location == location]


def _flat(field: Field) -> NDArray[Any]:
    values = np.asarray(field.values)
    if values.dtype.kind == "b":
        values = values.astype(np.uint8)
    if values.dtype.kind == "f" and values.dtype.itemsize not in (4, 8):
        values = values.astype(np.float64)
    return np.atleast_1d(values) if values.ndim < 2 else values.reshape(len(values), math.prod(values.shape[1:]))


# -- legacy ------------------------------------------------------------------------------------------------------------


def _legacy_attributes(heading: str, fields: Sequence[tuple[str, NDArray[Any]]]) -> Iterable[bytes]:
    """The first scalar and the first vector under their keywords, which VTK reads one each of; the rest as a FIELD."""
    if fields:
        yield f"{heading}\n".encode()
    scalar = next((field for field in fields if field[1].ndim == 1), None)
    vector = next((f for f in fields if f[1].shape[1:] == (3,) and f[1].dtype.kind == "f"), None)
    if scalar is not None:
        yield f"SCALARS {_word(scalar[0])} {_legacy_type(scalar[1])} 1\nLOOKUP_TABLE default\n".encode()
        yield from _big_endian(scalar[1])
    if vector is not None:
        yield f"VECTORS {_word(vector[0])} {_legacy_type(vector[1])}\n".encode()
        yield from _big_endian(vector[1])
    yield from _legacy_fields([field for field in fields if field is not scalar and field is not vector])


def _legacy_fields(fields: Sequence[tuple[str, NDArray[Any]]]) -> Iterable[bytes]:
    if fields:
        yield f"FIELD FieldData {len(fields)}\n".encode()
    for name, values in fields:
        width = values.shape[1] if values.ndim > 1 else 1
        yield f"{_word(name)} {width} {len(values)} {_legacy_type(values)}\n".encode()
        yield from _big_endian(values)


def _word(name: str) -> str:
    """The name as one word: VTK reads percent-encoded names back."""
    return quote(name, safe="!#$&'()*+,-./:;<=>?@[\\]^_`{|}~")


def _legacy_type(values: NDArray[Any]) -> str:
    return _LEGACY_TYPES[values.dtype.str[1:]]


def _big_endian(values: NDArray[Any], counted: bool = False) -> Pieces:
    """The numbers and a line end; ``counted``: with the length of each row in front of it."""
    order = values.dtype.newbyteorder(">")
    for begin in range(0, len(values), _ROWS):
        rows = values[begin : begin + _ROWS]
        if counted:
            rows = np.insert(rows, 0, rows.shape[1], axis=1)
        yield rows.astype(order, copy=False).tobytes()
    yield b"\n"


# -- XML ---------------------------------------------------------------------------------------------------------------


def _write_xml(result: Result | Cloud, points: Floats, path: Path, kind: str, size: str, cells: Pieces) -> None:
    head = f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
    whole = _element("FieldData", [_xml_array(*field, tuples=True) for field in _at(result, "mesh")])
    piece = [
        _element("Points", [_xml_array("Points", points)]),
        cells,
        _element("PointData", [_xml_array(*field) for field in _at(result, "vertex")]),
        _element("CellData", [_xml_array(*field) for field in _at(result, "face")]),
    ]
    with path.open("wb") as stream:
        stream.write(f'<?xml version="1.0"?>\n{head}\n<{kind}>\n'.encode())
        stream.writelines(whole)
        stream.write(f"<Piece {size}>\n".encode())
        stream.writelines(chain.from_iterable(piece))
        stream.write(f"</Piece>\n</{kind}>\n</VTKFile>\n".encode())


def _element(name: str, children: Sequence[Pieces]) -> Pieces:
    """An element round its children; nothing where it has none."""
    if children:
        yield f"<{name}>\n".encode()
        yield from chain.from_iterable(children)
        yield f"</{name}>\n".encode()


def _xml_array(name: str, values: NDArray[Any], tuples: bool = False) -> Pieces:
    """A DataArray; ``tuples``: it says its length itself, as field data must."""
    kind = f"{_XML_KINDS[values.dtype.kind]}{8 * values.dtype.itemsize}"
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    length = f' NumberOfTuples="{len(values)}"' if tuples else ""
    raw = np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"), copy=False)).reshape(-1).view(np.uint8)
    head = f'<DataArray type="{kind}" Name="{_attribute(name)}"{width}{length} format="binary">'
    yield head.encode()
    length_too = 3 * 8  # the length of the array, 8 bytes, is coded in one with it
    yield binascii.b2a_base64(raw.nbytes.to_bytes(8, "little") + raw[: length_too - 8].tobytes(), newline=False)
    for begin in range(length_too - 8, raw.nbytes, _CODED):
        yield binascii.b2a_base64(raw[begin : begin + _CODED].data, newline=False)
    yield b"</DataArray>\n"


def _attribute(name: str) -> str:
    """The name as an XML attribute, without the characters that XML has no way to write there."""
    name = UNWRITABLE.sub("_", name)
    return name.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")


def _offsets(n_faces: int) -> NDArray[np.int64]:
    return np.arange(3, 3 * n_faces + 3, 3)
