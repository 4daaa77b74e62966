"""Writer of PLY files: binary, little-endian, coordinates in double precision, arrays on vertices and faces.

Hand-written because pyvista's writer drops arrays.
"""

import re
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FieldError
from geomhw.io.formats.vtk_write import active_arrays, arrays_at
from geomhw.options import Location
from geomhw.results import Field, Result

_NAMES = {"<f8": "double", "|i1": "char", "|u1": "uchar", "<i2": "short", "<u2": "ushort", "<i4": "int", "<u4": "uint"}
#: Rows written at a time.
_ROWS = 1 << 12
#: Remark before the name of the array that ``quality`` repeats: MeshLab shows the property of that name.
QUALITY = "comment quality is a copy of"
_Column = tuple[str, NDArray[Any]]


def write_ply(result: Result, stream: BinaryIO) -> None:
    """Write the mesh and its fields; vectors ``v`` become ``v_x v_y v_z``, arrays of other widths ``v_0 v_1 ...``.

    The scalar that viewers show first is there twice, as ``quality`` too.
    """
    mesh = result.mesh
    axes = [(axis, mesh.vertices[:, k]) for k, axis in enumerate("xyz")]
    vertex = axes + _columns(result, "vertex")
    copied = _active_scalar(result)
    face = _columns(result, "face")
    header = ["ply", "format binary_little_endian 1.0", "comment geomhw"]
    header += [_comment(field) for field in result.fields if field.location == "mesh"]
    if copied:
        header.append(f"{QUALITY} {copied}")
        vertex.append(("quality", dict(vertex)[copied]))
    header += [f"element vertex {mesh.n_vertices}", *_declarations(vertex)]
    header += [f"element face {mesh.n_faces}", "property list uchar int vertex_indices", *_declarations(face)]
    header += ["end_header", ""]
    corners: list[_Column] = [("corners", np.full(mesh.n_faces, 3, np.uint8)), ("indices", mesh.faces)]
    stream.write("\n".join(header).encode("ascii"))
    stream.writelines(_records(vertex))
    stream.writelines(_records(corners + face))


def _active_scalar(result: Result) -> str:
    """The column of the scalar that viewers show first, "" if there is none, or an array is named quality."""
    arrays = arrays_at(result, "vertex")
    scalar, _ = active_arrays([array for array in arrays if array[1].ndim == 1])
    return _plain(scalar[0]) if scalar and all(_plain(name) != "quality" for name, _ in arrays) else ""


def _columns(result: Result, location: Location) -> list[_Column]:
    """Scalar columns of the fields at one location, in types that PLY has."""
    columns: dict[str, NDArray[Any]] = {}
    for field in result.fields:
        if field.location != location:
            continue
        values = np.asarray(field.values)
        rows = values.reshape(len(values), -1)
        ends = "xyz" if rows.shape[1] == 3 else range(rows.shape[1])
        for end, column in zip(ends, rows.T, strict=True):
            name = _plain(field.name) + (f"_{end}" if values.ndim > 1 else "")
            if name in columns or name in (("x", "y", "z") if location == "vertex" else ("vertex_indices",)):
                raise FieldError(f"two {location} arrays would both be '{name}' in PLY; rename field '{field.name}'")
            columns[name] = _storable(column)
    return list(columns.items())


def _plain(name: str) -> str:
    """The name in printable ASCII without spaces, which would end it."""
    return re.sub(r"[^!-~]", "_", name)


def _storable(column: NDArray[Any]) -> NDArray[Any]:
    """The column in a PLY type that holds all its values; PLY has no integers of 8 bytes."""
    if column.dtype.kind == "b":
        return column.astype(np.uint8)
    if column.dtype.kind in "iu" and column.dtype.itemsize < 8:
        return column
    small = np.iinfo(np.int32)
    if column.dtype.kind in "iu" and column.min(initial=0) >= small.min and column.max(initial=0) <= small.max:
        return column.astype(np.int32)
    return column.astype(np.float64, copy=False)


def _declarations(columns: list[_Column]) -> list[str]:
    return [f"property {_NAMES[values.dtype.newbyteorder('<').str]} {name}" for name, values in columns]


def _records(columns: list[_Column]) -> Iterator[bytes]:
    """The rows of some columns, ``_ROWS`` at a time."""
    layout = [(f"c{i}", column.dtype.newbyteorder("<"), column.shape[1:]) for i, (_, column) in enumerate(columns)]
    rows = len(columns[0][1])
    for begin in range(0, rows, _ROWS):
        records = np.empty(min(_ROWS, rows - begin), dtype=layout)
        for i, (_, column) in enumerate(columns):
            records[f"c{i}"] = column[begin : begin + _ROWS]
        yield records.tobytes()


def _comment(field: Field) -> str:
    values = " ".join(map(repr, np.asarray(field.values).ravel().tolist()))
    return f"comment {_plain(field.name)} {values}"
