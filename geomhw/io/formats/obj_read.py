"""Reader of Wavefront OBJ files: vertices and faces; normals, texture coordinates, groups and materials are ignored.

Hand-written because meshio reads the index -4 as -5.
"""

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, polygon_of
from geomhw.io.formats.text_file import NumberRows, TextFile
from geomhw.results import Result

#: Elements that a backslash at the end of a line continues. It ends names in comments and in lines such as usemtl.
_CONTINUED = ("v", "vt", "vn", "vp", "f", "fo", "l", "p")


def read_obj(name: str, data: bytes) -> Result:
    """Return the vertices and faces of all objects and groups, in file order."""
    text = TextFile(name, data, comments=True, continued=_CONTINUED)
    vertex_lines, face_lines = text.starting_with("v"), text.starting_with("f")
    if not len(vertex_lines):
        raise FormatError(f"{name} has no vertices: none of its lines starts with 'v'")
    if not len(face_lines):
        raise FormatError(f"{name} has no faces: none of its lines starts with 'f'")
    vertices = text.numbers(vertex_lines, keyword="v")
    points, remarks = vertices.coordinates()
    rows = text.numbers(face_lines, keyword="f", integers=True, attributes=True)
    content = Polygons(points, _corners(rows, vertex_lines), rows.counts, remarks=text.remarks + remarks)
    return build_result(name, "OBJ", content, face_place=rows.place, vertex_place=vertices.place)


def _corners(rows: NumberRows, vertex_lines: Ints) -> Ints:
    """Corners of all faces, flat and counted from 0."""
    sizes, n = rows.counts, len(vertex_lines)
    indices = rows.integers(slice(None))
    corners = indices - 1
    if (negative := indices < 0).any():  # counted back from the last vertex before the face
        before = np.repeat(np.searchsorted(vertex_lines, rows.lines), sizes)
        corners = np.where(negative, indices + before, corners)
    if corners.min(initial=0) < 0 or corners.max(initial=-1) >= n:
        at = int(np.argmax((corners < 0) | (corners >= n)))
        index = int(indices[at])
        reason = f"but there are {n} (1 to {n})"
        if index == 0:
            reason = "but an OBJ file counts from 1"
        elif index < 0:
            reason = f"but only {int(corners[at]) - index} come before it"
        raise FormatError(f"{rows.place(polygon_of(at, sizes))}: face names vertex {index}, {reason}")
    return corners
