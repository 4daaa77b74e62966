"""Wavefront OBJ files: their vertices and faces; normals, texture coordinates, groups and materials are passed over."""

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.assemble import Polygons, assemble
from geomhw.io.formats.off_read import coordinates, whole
from geomhw.io.formats.polygons import check_distinct, polygon_of
from geomhw.io.formats.tokens import Lines
from geomhw.results import Result


def read_obj(name: str, data: bytes) -> Result:
    """Vertices and faces of an OBJ file, all its objects and groups together, in file order."""
    lines = Lines(name, data, comments=True, continued=True)
    vertex_rows, face_rows = lines.starting_with("v"), lines.starting_with("f")
    if not len(vertex_rows):
        raise FormatError(f"{name} has no vertices: none of its lines starts with 'v'")
    if not len(face_rows):
        raise FormatError(f"{name} has no faces: none of its lines starts with 'f'")
    points = coordinates(lines, vertex_rows, lines.numbers(vertex_rows, keyword="v"))
    corners, sizes = _faces(lines, face_rows, vertex_rows)
    return assemble(name, "OBJ", Polygons(points, corners, sizes), checked=True)


def _faces(lines: Lines, rows: Ints, vertex_rows: Ints) -> tuple[Ints, Ints]:
    """Corners of all faces, flat and counted from 0, and how many each has."""
    numbers = lines.numbers(rows, keyword="f", whole=True, attributes=True)
    sizes = numbers.counts
    if (few := sizes < 3).any():
        bad = int(np.argmax(few))
        raise FormatError(f"{lines.place(rows[bad])}: a face needs at least 3 corners, not {sizes[bad]}")
    indices = whole(lines, rows, numbers.values, None, numbers)
    corners = _absolute(indices, sizes, rows, vertex_rows)
    _check_range(lines, rows, indices, corners, sizes, len(vertex_rows))
    check_distinct(corners, sizes, lambda i: lines.place(rows[i]), base=1)
    return corners, sizes


def _absolute(indices: Ints, sizes: Ints, rows: Ints, vertex_rows: Ints) -> Ints:
    """Indices from 0; a negative one counts back from the last vertex that comes before its face in the file."""
    corners = indices - 1
    if (negative := indices < 0).any():
        read_before = np.repeat(np.searchsorted(vertex_rows, rows), sizes)
        corners = np.where(negative, indices + read_before, corners)
    # Out of range either way: 0 is no index in this format, and -99 must not turn into a large positive one.
    return corners


def _check_range(lines: Lines, rows: Ints, indices: Ints, corners: Ints, sizes: Ints, n: int) -> None:
    if corners.min() >= 0 and corners.max() < n:
        return
    at = int(np.argmax((corners < 0) | (corners >= n)))
    row = rows[polygon_of(at, sizes)]
    index = int(indices[at])
    if index == 0:
        raise FormatError(f"{lines.place(row)}: face names vertex 0, but an OBJ file counts from 1")
    if index < 0:
        before = int(corners[at]) - index
        raise FormatError(f"{lines.place(row)}: face names vertex {index}, but only {before} come before it")
    raise FormatError(f"{lines.place(row)}: face names vertex {index}, but there are {n} (1 to {n})")
