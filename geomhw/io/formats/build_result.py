"""The last step of every reader: polygons become triangles, and arrays become fields of a Result."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError, MeshError
from geomhw.io.formats.polygons import Arrays, Place, Polygons, check_indices, without_repetitions
from geomhw.io.formats.triangulation import triangulate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.results import Field, Result
from geomhw.wording import counted


def build_result(
    name: str, kind: str, content: Polygons, *, face_place: Place | None = None, vertex_place: Place | None = None
) -> Result:
    """Return the Result of a file; each triangle of a polygon gets the face values of its polygon.

    face_place, vertex_place: by default, faces are counted from 0, and vertices named by the mesh.
    """
    face_place = face_place or (lambda i: f"{name}, face {i}")
    check_indices(content.corners, content.sizes, len(content.points), face_place)
    remarks = [*content.remarks]
    corners, sizes, kept = without_repetitions(content.corners, content.sizes)
    remarks += _repetitions(content, corners, sizes, kept, face_place)
    if not len(sizes):
        raise FormatError(f"{name} has no faces of three different corners" + "".join(f": {r}" for r in remarks[-1:]))
    points = _finite_points(content.points, corners, vertex_place, remarks)
    small = np.int32 if len(points) < 2**31 else np.int64
    division = triangulate(points, corners.astype(small, copy=False), sizes)
    if failed := len(division.failed):
        remarks.append(
            f"divided {counted(failed, 'polygon')} with crossing sides or without area from the first corner, "
            f"the first at {face_place(int(kept[division.failed[0]]))}"
        )
    try:
        mesh = TriangleMesh(points, division.triangles)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None
    report: dict[str, Any] = {"file": name, "format": kind}
    if polygons := int(np.count_nonzero(sizes > 3)):
        report["polygons"] = polygons
    report |= content.notes
    if single := _single_precision(content):
        report["single_precision"] = single
    if remarks:
        report["remarks"] = remarks
    origin = kept[division.polygons] if polygons or len(kept) < len(content.sizes) else None
    fields = [
        *_fields(name, content.vertex_arrays, "vertex", len(points)),
        *(
            _named(field, content.labels)
            for field in _fields(name, content.face_arrays, "face", len(content.sizes), origin)
        ),
        *_fields(name, content.mesh_arrays, "mesh"),
    ]
    return Result(mesh, fields, report)


def _named(field: Field, labels: Mapping[str, Mapping[int, str]]) -> Field:
    return replace(field, labels=labels[field.name]) if field.name in labels else field


def _repetitions(content: Polygons, corners: Ints, sizes: Ints, kept: Ints, place: Place) -> Iterator[str]:
    """Remarks on faces and corners that are left out."""
    if left_out := len(content.sizes) - len(kept):
        first = int(np.argmax(np.append(kept, -1) != np.arange(len(kept) + 1)))
        what = counted(left_out, "face")
        yield f"left out {what} with fewer than three different corners, the first at {place(first)}"
    if dropped := int(content.sizes[kept].sum()) - len(corners):
        first = int(kept[np.argmax(content.sizes[kept] != sizes)])
        yield f"left out {counted(dropped, 'repeated corner')} of faces, the first at {place(first)}"


def _finite_points(points: Floats, corners: Ints, place: Place | None, remarks: list[str]) -> Floats:
    """Points in double precision, with those of no face that are not finite moved to the middle of the others."""
    with np.errstate(invalid="ignore"):  # a signaling NaN of single precision
        points = points.astype(np.float64, copy=False)
    if np.isfinite(points).all():
        return points
    sound = np.asarray(np.isfinite(points).all(axis=1))
    used = np.zeros(len(points), dtype=bool)
    used[corners] = True
    if (bad := used & ~sound).any():
        if place is None:
            return points  # TriangleMesh refuses them
        row = int(np.argmax(bad))
        shown = " ".join(map(str, points[row].tolist()))
        raise FormatError(f"{place(row)}: a coordinate is not a finite number: {shown}")
    within = points[used]
    points = np.where(sound[:, None], points, within.min(axis=0) / 2 + within.max(axis=0) / 2)
    remarks.append(
        f"moved to the center of the mesh {counted(int((~sound).sum()), 'vertex', 'vertices')} of no face without "
        f"finite coordinates, the first is vertex {int(np.argmin(sound))}"
    )
    return points


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
