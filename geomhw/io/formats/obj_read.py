"""Reader of Wavefront OBJ files: vertices, faces, groups and materials; normals and texture coordinates are ignored.

Hand-written because meshio reads the index -4 as -5.
"""

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, polygon_of
from geomhw.io.formats.text_file import NumberRows, TextFile
from geomhw.results import Result

#: Changes of the group or material between faces, at most.
MOST_LABELS = 1 << 16
#: Elements that a backslash at the end of a line continues. It ends names in comments and in lines such as usemtl.
_CONTINUED = ("v", "vt", "vn", "vp", "f", "fo", "l", "p")


def read_obj(name: str, data: bytes) -> Result:
    """Return the vertices and faces of all objects and groups, in file order.

    Where faces belong to several groups or materials, the arrays ``group`` and ``material`` on faces number them by
    their first line, with their names as labels. Objects stand for groups where there is none.
    """
    text = TextFile(name, data, comments=True, continued=_CONTINUED)
    vertex_lines, face_lines = text.starting_with("v"), text.starting_with("f")
    if not len(vertex_lines):
        raise FormatError(f"{name} has no vertices: none of its lines starts with 'v'")
    if not len(face_lines):
        raise FormatError(f"{name} has no faces: none of its lines starts with 'f'")
    vertices = text.numbers(vertex_lines, keyword="v")
    points, remarks = vertices.coordinates()
    rows = text.numbers(face_lines, keyword="f", integers=True, attributes=True)
    remarks = text.remarks + remarks
    arrays, labels = {}, {}
    for key, keywords in (("group", ("g", "o")), ("material", ("usemtl",))):
        if found := next(filter(None, (_labels(text, face_lines, word, remarks) for word in keywords)), None):
            arrays[key], labels[key] = found
    corners = _corners(rows, vertex_lines)
    content = Polygons(points, corners, rows.counts, face_arrays=arrays, labels=labels, remarks=remarks)
    return build_result(name, "OBJ", content, face_place=rows.place, vertex_place=vertices.place)


def _labels(text: TextFile, face_lines: Ints, keyword: str, remarks: list[str]) -> tuple[Ints, dict[int, str]] | None:
    """Label of each face by the last line with a keyword before it, and the names of labels; None if all are equal."""
    lines = text.starting_with(keyword)
    before = np.searchsorted(lines, face_lines)
    used = np.unique(before)
    if len(used) < 2:
        return None
    if len(used) > MOST_LABELS:
        remarks.append(f"left out the names after '{keyword}', which change {len(used)} times between faces")
        return None
    numbers: dict[str, int] = {}
    names = [text.rest(lines[k - 1], len(keyword)) if k else "default" for k in used.tolist()]
    label = np.array([numbers.setdefault(name, len(numbers)) for name in names], np.int32)
    if len(numbers) < 2:
        return None
    return label[np.searchsorted(used, before)], {number: name for name, number in numbers.items()}


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
