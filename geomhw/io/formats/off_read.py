"""Reader of OFF text files with points in space: the keyword OFF with any of the prefixes ST, C and N.

Hand-written because meshio exits the process on a damaged OFF file.
"""

import re

import numpy as np

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, check_polygons, ranges
from geomhw.io.formats.text_file import NumberRows, TextFile
from geomhw.results import Result

# The counts may follow the keyword without a space, as in the files of ModelNet.
_KEYWORD = re.compile(r"((?:ST)?C?N?)(4?n?)OFF(\d+)?|off")


def read_off(name: str, data: bytes) -> Result:
    """Return the vertices and faces; further numbers of a vertex and colors of faces are ignored."""
    text = TextFile(name, data, comments=True)
    n, m, start = _header(text)
    _check_length(text, n, m, start)
    points = text.numbers(np.arange(start, start + n)).coordinates()
    corners, sizes = _faces(text.numbers(np.arange(start + n, start + n + m), integers=True), n)
    return build_result(name, "OFF", Polygons(points, corners, sizes), checked=True)


def _header(text: TextFile) -> tuple[int, int, int]:
    """Number of vertices, number of faces, first line after the header."""
    if not len(text):
        raise FormatError(f"{text.name} holds nothing but blank lines and comments")
    tokens, line = text.tokens(0), 0
    if keyword := _KEYWORD.fullmatch(tokens[0]):
        if keyword[2]:
            raise FormatError(
                f"{text.place(0)}: {tokens[0]} holds points of another dimension than 3; write it as plain OFF"
            )
        tokens = [*filter(None, [keyword[3]]), *tokens[1:]]
        if tokens and tokens[0].upper() == "BINARY":
            raise FormatError(f"{text.place(0)}: binary OFF is not read; write it as text, or as PLY")
        if not tokens:
            if len(text) == 1:
                raise FormatError(f"{text.name} ends after its header, before the numbers of vertices and faces")
            tokens, line = text.tokens(1), 1
    elif not re.fullmatch(r"[+-]?[\d.]+", tokens[0]):
        raise FormatError(f"{text.place(0)}: '{tokens[0]}' does not start an OFF file (OFF, COFF, NOFF, STOFF)")
    return (*_counts(text.place(line), tokens), line + 1)


def _counts(place: str, tokens: list[str]) -> tuple[int, int]:
    shown = " ".join(tokens[:4])
    if len(tokens) not in (2, 3) or not all(re.fullmatch(r"[+-]?\d{1,18}", token) for token in tokens):
        raise FormatError(f"{place}: expected the numbers of vertices, faces and edges, not '{shown}'")
    n, m = int(tokens[0]), int(tokens[1])
    if n < 0 or m < 0:
        raise FormatError(f"{place}: {shown}: a number of vertices or faces cannot be negative")
    if n == 0 or m == 0:
        raise FormatError(f"{place}: the file has {n} vertices and {m} faces; a surface needs some of both")
    return n, m


def _check_length(text: TextFile, n: int, m: int, start: int) -> None:
    found = len(text) - start
    if found < n:
        raise FormatError(f"{text.name} ends after {found} of {n} vertices")
    if found < n + m:
        raise FormatError(f"{text.name} ends after {found - n} of {m} faces")
    if found > n + m:
        raise FormatError(
            f"{text.place(start + n + m)}: the file goes on after the {n} vertices and {m} faces of its header"
        )


def _faces(rows: NumberRows, n: int) -> tuple[Ints, Ints]:
    """Corners of all faces, flat, and the number of corners of each."""
    sizes = rows.integers(rows.begins)
    if (few := sizes < 3).any():
        bad = int(np.argmax(few))
        raise FormatError(f"{rows.place(bad)}: a face needs at least 3 corners, not {sizes[bad]}")
    if (short := rows.counts - 1 < sizes).any():
        bad = int(np.argmax(short))
        raise FormatError(f"{rows.place(bad)}: the face says {sizes[bad]} corners, but {rows.counts[bad] - 1} follow")
    is_corner = np.ones(len(rows.values), dtype=bool)
    is_corner[rows.begins] = False
    has_color = (rows.counts - 1 > sizes).any()
    corners = rows.integers(ranges(rows.begins + 1, sizes) if has_color else is_corner)
    check_polygons(corners, sizes, n, rows.place)
    return corners, sizes
