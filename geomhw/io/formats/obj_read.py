"""Reader of Wavefront OBJ files: vertices and faces; normals, texture coordinates, groups and materials are ignored.

Hand-written because meshio reads the index -4 as -5.
"""

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, check_distinct, polygon_of
from geomhw.io.formats.text_file import NumberRows, TextFile
from geomhw.results import Result


def read_obj(name: str, data: bytes) -> Result:
    """Return the vertices and faces of all objects and groups, in file order."""
    text = TextFile(name, data, comments=True, continued=True)
    vertex_lines, face_lines = text.starting_with("v"), text.starting_with("f")
    if not len(vertex_lines):
        raise FormatError(f"{name} has no vertices: none of its lines starts with 'v'")
    if not len(face_lines):
        raise FormatError(f"{name} has no faces: none of its lines starts with 'f'")
    points = text.numbers(vertex_lines, keyword="v").coordinates()
    rows = text.numbers(face_lines, keyword="f", integers=True, attributes=True)
    return build_result(name, "OBJ", Polygons(points, _corners(rows, vertex_lines), rows.counts), checked=True)


def _corners(rows: NumberRows, vertex_lines: Ints) -> Ints:
    """Corners of all faces, flat and counted from 0."""
    sizes, n = rows.counts, len(vertex_lines)
    if (few := sizes < 3).any():
        bad = int(np.argmax(few))
        raise FormatError(f"{rows.place(bad)}: a face needs at least 3 corners, not {sizes[bad]}")
    indices = rows.integers(slice(None))
    corners = indices - 1
    if (negative := indices < 0).any():  # counted back from the last vertex before the face
        before = np.repeat(np.searchsorted(vertex_lines, rows.lines), sizes)
        corners = np.where(negative, indices + before, corners)
    if corners.min() < 0 or corners.max() >= n:
        at = int(np.argmax((corners < 0) | (corners >= n)))
        index = int(indices[at])
        reason = f"but there are {n} (1 to {n})"
        if index == 0:
            reason = "but an OBJ file counts from 1"
        elif index < 0:
            reason = f"but only {int(corners[at]) - index} come before it"
        raise FormatError(f"{rows.place(polygon_of(at, sizes))}: face names vertex {index}, {reason}")
    check_distinct(corners, sizes, rows.place, base=1)
    return corners
