"""The last step of every reader: polygons become triangles, arrays become fields, and all of it a Result."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError, MeshError
from geomhw.io.formats.polygons import check_polygons, fan
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.results import Field, Result

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Polygons:
    """What a file holds: points (n, 3), polygons flat (vertex indices and sizes), arrays, and notes for the report."""

    points: Floats
    corners: Ints
    sizes: Ints
    vertex_arrays: Arrays = field(default_factory=dict)
    face_arrays: Arrays = field(default_factory=dict)
    mesh_arrays: Arrays = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)


def assemble(name: str, kind: str, content: Polygons, *, checked: bool = False) -> Result:
    """The Result of a file; a fanned polygon gives its face values to each of its triangles.

    checked: the reader has looked at the polygons itself, because it can name lines.
    """
    if not checked:
        check_polygons(content.corners, content.sizes, len(content.points), face_place(name))
    small = np.int32 if len(content.points) < 2**31 else np.int64
    triangles, origin = fan(content.corners.astype(small, copy=False), content.sizes)
    try:
        with np.errstate(invalid="ignore"):  # a signaling NaN of single precision; it is refused as any NaN is
            mesh = TriangleMesh(content.points.astype(np.float64, copy=False), triangles)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None
    report: dict[str, Any] = {"file": name, "format": kind}
    if polygons := int(np.count_nonzero(content.sizes > 3)):
        report["polygons"] = polygons
    report.update(content.notes)
    if single := _single_precision(content):
        report["single_precision"] = single
    fields = [
        *_fields(name, content.vertex_arrays, "vertex", len(content.points), None),
        *_fields(name, content.face_arrays, "face", len(content.sizes), origin if polygons else None),
        *_fields(name, content.mesh_arrays, "mesh", None, None),
    ]
    return Result(mesh, fields, report)


def _single_precision(content: Polygons) -> list[str]:
    """Which of positions and arrays the file holds in single precision: they are exact to 6e-8 and no more."""
    arrays = {"positions": content.points, **content.vertex_arrays, **content.face_arrays, **content.mesh_arrays}
    return [name for name, array in arrays.items() if array.dtype.kind == "f" and array.dtype.itemsize <= 4]


def face_place(name: str) -> Callable[[int], str]:
    """Says where face i of a file without lines is."""
    return lambda i: f"{name}, face {i}"


def _fields(name: str, arrays: Arrays, location: Location, rows: int | None, origin: Ints | None) -> list[Field]:
    """Numeric arrays of 1 to 9 components as fields, floats in double precision; others are no fields."""
    found = []
    for key, array in arrays.items():
        if array.dtype.kind not in "fiub":
            continue
        if rows is not None and len(array) != rows:
            raise FormatError(f"{name}: array '{key}' has {len(array)} rows where the file has {rows} {location} rows")
        wide = array.reshape(len(array), -1) if array.size else array
        if rows is not None and not 1 <= (wide.shape[1] if wide.ndim > 1 else 1) <= 9:
            continue
        values = array if origin is None else array[origin]
        if array.dtype.kind == "f":
            with np.errstate(invalid="ignore"):
                values = values.astype(np.float64)
        elif array.dtype.kind == "b":
            values = values.astype(np.uint8)
        else:
            values = values.astype(values.dtype.newbyteorder("="))
        found.append(Field(key, location, values))
    return found
