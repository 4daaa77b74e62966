"""The last step of every reader: polygons become triangles, and arrays become fields of a Result."""

import math
from typing import Any

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError, MeshError
from geomhw.io.formats.polygons import Arrays, Polygons, check_polygons, fan_triangles
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.results import Field, Result


def build_result(name: str, kind: str, content: Polygons, *, checked: bool = False) -> Result:
    """Return the Result of a file; each triangle of a fan gets the face values of its polygon.

    checked: the reader has checked the polygons itself, with line numbers.
    """
    if not checked:
        check_polygons(content.corners, content.sizes, len(content.points), lambda i: f"{name}, face {i}")
    small = np.int32 if len(content.points) < 2**31 else np.int64
    triangles, origin = fan_triangles(content.corners.astype(small, copy=False), content.sizes)
    try:
        with np.errstate(invalid="ignore"):  # a signaling NaN of single precision; it is refused as any NaN is
            mesh = TriangleMesh(content.points.astype(np.float64, copy=False), triangles)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None
    report: dict[str, Any] = {"file": name, "format": kind}
    if polygons := int(np.count_nonzero(content.sizes > 3)):
        report["polygons"] = polygons
    report |= content.notes
    if single := _single_precision(content):
        report["single_precision"] = single
    fields = [
        *_fields(name, content.vertex_arrays, "vertex", len(content.points)),
        *_fields(name, content.face_arrays, "face", len(content.sizes), origin if polygons else None),
        *_fields(name, content.mesh_arrays, "mesh"),
    ]
    return Result(mesh, fields, report)


def _single_precision(content: Polygons) -> list[str]:
    """Names of positions and arrays that the file holds in single precision, exact to a relative 6e-8."""
    arrays = {"positions": content.points, **content.vertex_arrays, **content.face_arrays, **content.mesh_arrays}
    return [name for name, array in arrays.items() if array.dtype.kind == "f" and array.dtype.itemsize <= 4]


def _fields(
    name: str, arrays: Arrays, location: Location, rows: int | None = None, origin: Ints | None = None
) -> list[Field]:
    """Numeric arrays of 1 to 9 components as fields, floats in double precision; other arrays are left out."""
    found = []
    for key, array in arrays.items():
        if array.dtype.kind not in "fiub":
            continue
        if rows is not None and len(array) != rows:
            raise FormatError(f"{name}: array '{key}' has {len(array)} rows where the file has {rows} {location} rows")
        if rows is not None and not 1 <= math.prod(array.shape[1:]) <= 9:
            continue
        kinds: dict[str, Any] = {"f": np.float64, "b": np.uint8}
        kind = kinds.get(array.dtype.kind, array.dtype.newbyteorder("="))
        with np.errstate(invalid="ignore"):
            found.append(Field(key, location, (array if origin is None else array[origin]).astype(kind)))
    return found
