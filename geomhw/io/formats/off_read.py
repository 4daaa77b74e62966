"""OFF files, in the text dialects that carry points in space: OFF with any of the prefixes ST, C and N."""

import re

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.assemble import Polygons, assemble
from geomhw.io.formats.polygons import check_polygons, ragged
from geomhw.io.formats.tokens import Lines, Numbers
from geomhw.results import Result

# The counts may follow the keyword without a space, as in the files of ModelNet.
_KEYWORD = re.compile(r"((?:ST)?C?N?)(4?n?)OFF(\d+)?|off")


def read_off(name: str, data: bytes) -> Result:
    """Vertices and faces of an OFF file; numbers after the three coordinates, and colors of faces, are passed over."""
    lines = Lines(name, data, comments=True)
    n, m, start = _header(lines)
    _check_length(lines, n, m, start)
    points = _vertices(lines, np.arange(start, start + n))
    corners, sizes = _faces(lines, np.arange(start + n, start + n + m), n)
    return assemble(name, "OFF", Polygons(points, corners, sizes), checked=True)


def _header(lines: Lines) -> tuple[int, int, int]:
    """Number of vertices, number of faces, first line after the header."""
    if not len(lines):
        raise FormatError(f"{lines.name} holds nothing but blank lines and comments")
    tokens, row = lines.tokens(0), 0
    keyword = _KEYWORD.fullmatch(tokens[0])
    if keyword:
        if keyword[2]:
            raise FormatError(
                f"{lines.place(0)}: {tokens[0]} holds points of another dimension than 3; write it as plain OFF"
            )
        tokens = ([keyword[3]] if keyword[3] else []) + tokens[1:]
        if tokens and tokens[0].upper() == "BINARY":
            raise FormatError(f"{lines.place(0)}: binary OFF is not read; write it as text, or as PLY")
        if not tokens:
            row = 1
            if len(lines) == 1:
                raise FormatError(f"{lines.name} ends after its header, before the numbers of vertices and faces")
            tokens = lines.tokens(1)
    elif not re.fullmatch(r"[+-]?[\d.]+", tokens[0]):
        raise FormatError(f"{lines.place(0)}: '{tokens[0]}' is not how an OFF file starts (OFF, COFF, NOFF, STOFF)")
    return (*_counts(lines, row, tokens), row + 1)


def _counts(lines: Lines, row: int, tokens: list[str]) -> tuple[int, int]:
    shown = " ".join(tokens[:4])
    if len(tokens) not in (2, 3) or not all(re.fullmatch(r"[+-]?\d{1,18}", token) for token in tokens):
        raise FormatError(f"{lines.place(row)}: expected the numbers of vertices, faces and edges, not '{shown}'")
    n, m = int(tokens[0]), int(tokens[1])
    if n < 0 or m < 0:
        raise FormatError(f"{lines.place(row)}: {shown}: a number of vertices or faces cannot be negative")
    if n == 0 or m == 0:
        raise FormatError(f"{lines.place(row)}: the file has {n} vertices and {m} faces; a surface needs some of both")
    return n, m


def _check_length(lines: Lines, n: int, m: int, start: int) -> None:
    there = len(lines) - start
    if there < n:
        raise FormatError(f"{lines.name} ends after {there} of {n} vertices")
    if there < n + m:
        raise FormatError(f"{lines.name} ends after {there - n} of {m} faces")
    if there > n + m:
        raise FormatError(
            f"{lines.place(start + n + m)}: the file goes on after the {n} vertices and {m} faces of its header"
        )


def _vertices(lines: Lines, rows: Ints) -> Floats:
    numbers = lines.numbers(rows)
    return coordinates(lines, rows, numbers)


def coordinates(lines: Lines, rows: Ints, numbers: Numbers) -> Floats:
    """The first three numbers of each line, (lines, 3), or FormatError where there are fewer or one is not finite."""
    if (short := numbers.counts < 3).any():
        bad = int(np.argmax(short))
        raise FormatError(f"{lines.place(rows[bad])}: a vertex needs 3 coordinates, not {numbers.counts[bad]}")
    points = numbers.columns(3)
    if not (finite := np.isfinite(points)).all():
        bad = int(np.argmin(finite.all(axis=1)))
        shown = " ".join(map(str, points[bad].tolist()))
        raise FormatError(f"{lines.place(rows[bad])}: a coordinate is not a finite number: {shown}")
    return points


def _faces(lines: Lines, rows: Ints, n: int) -> tuple[Ints, Ints]:
    """Corners of all faces, flat, and how many each has."""
    numbers = lines.numbers(rows, whole=True)
    sizes = whole(lines, rows, numbers.values[numbers.begins], numbers.begins, numbers)
    if (few := sizes < 3).any():
        bad = int(np.argmax(few))
        raise FormatError(f"{lines.place(rows[bad])}: a face needs at least 3 corners, not {sizes[bad]}")
    if (short := numbers.counts - 1 < sizes).any():
        bad = int(np.argmax(short))
        raise FormatError(
            f"{lines.place(rows[bad])}: the face says {sizes[bad]} corners, but {numbers.counts[bad] - 1} follow"
        )
    corners = _corners(lines, rows, numbers, sizes)
    check_polygons(corners, sizes, n, lambda i: lines.place(rows[i]))
    return corners, sizes


def _corners(lines: Lines, rows: Ints, numbers: Numbers, sizes: Ints) -> Ints:
    """The numbers behind the first of each line, as many as it says, flat."""
    width = int(sizes[0])
    alike = len(numbers.values) == (width + 1) * len(sizes) and (sizes == width).all()
    if alike and numbers.values.dtype.kind == "i":
        return numbers.values.reshape(-1, width + 1)[:, 1:].ravel()
    at = ragged(numbers.begins + 1, sizes)
    return whole(lines, rows, numbers.values[at], at, numbers)


def whole(lines: Lines, rows: Ints, values: Floats | Ints, at: Ints | None, numbers: Numbers) -> Ints:
    """Values as integers, or FormatError with the line of one that is none.

    at: where in ``numbers`` they are, if they are not all of them.
    """
    if values.dtype.kind != "f":
        return values
    bad = ~(np.abs(values) < 2.0**62) | (values != np.floor(values))
    if bad.any():
        where = int(np.argmax(bad)) if at is None else int(at[np.argmax(bad)])
        row = int(rows[np.searchsorted(numbers.begins, where, side="right") - 1])
        raise FormatError(f"{lines.place(row)}: '{numbers.values[where]:g}' is not a whole number")
    return values.astype(np.int64)
