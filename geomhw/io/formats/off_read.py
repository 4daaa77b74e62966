"""Reader of OFF files, text and binary, with points in space: the keyword OFF with any of the prefixes ST, C and N.

Hand-written because meshio exits the process on a damaged OFF file.
"""

import re
from itertools import product

import numpy as np

from geomhw.arrays import Floats, Ints, ranges
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Place, Polygons
from geomhw.io.formats.text_file import NumberRows, TextFile
from geomhw.results import Result
from geomhw.wording import counted

# The counts may follow the keyword without a space, as in the files of ModelNet.
KEYWORD = re.compile(
    rb"((?:ST(?!(?:C|N)*ST)|C(?!(?:ST|N)*C)|N(?!(?:ST|C)*N))*)(4?n?)OFF(?=[\s\d#]|\Z)|()()off(?=[\s\d#]|\Z)"
)
#: The dimension after nOFF, with the blanks and comments before it.
_DIMENSION = re.compile(rb"((?:\s|#[^\r\n]*)+)(\d{1,9})(?!\S)")
BINARY = re.compile(rb"[ \t]+BINARY[ \t\r]*\n", re.IGNORECASE)
#: Numbers of a vertex for each prefix; some programs write colors without the fourth.
WIDTHS = {b"N": (3,), b"ST": (2,), b"C": (4, 3)}


def read_off(name: str, data: bytes) -> Result:
    """Return the vertices and faces; further numbers of a vertex and colors of faces are ignored."""
    begin = first_token(data)
    prefixes: list[bytes] = []
    if keyword := KEYWORD.match(data, begin):
        prefixes = re.findall(rb"ST|C|N", keyword[1] or b"")
        if keyword[2]:
            return read_off(name, _in_space(name, data, keyword))
        if binary := BINARY.match(data, keyword.end()):
            return _read_binary(name, data, binary.end(), prefixes)
    text = TextFile(name, data, comments=True)
    if not len(text):
        raise FormatError(f"{name} holds nothing but blank lines and comments")
    tokens, line = text.tokens(0), 0
    if keyword:
        tokens = [*filter(None, [tokens[0][len(keyword[0]) :]]), *tokens[1:]]
        if not tokens and len(text) == 1:
            raise FormatError(f"{name} ends after its header, before the numbers of vertices and faces")
        if not tokens:
            tokens, line = text.tokens(1), 1
    elif not re.fullmatch(r"[+-]?[\d.]+", tokens[0]):
        raise FormatError(f"{text.place(0)}: '{tokens[0]}' does not start an OFF file (OFF, COFF, NOFF, STOFF)")
    places: dict[str, Place] = {}
    try:
        n, m = counts_of(text.place(line), tokens)
        content = None
        if len(text) > line + 1 + n + m:
            content = _from_tokens(name, data, keyword, prefixes)
        if content is None:
            content, places = _from_lines(text, n, m, line + 1)
    except FormatError:
        content = _from_tokens(name, data, keyword, prefixes)  # records may cross lines
        if content is None:
            raise
    return build_result(name, "OFF", content, **places)


def _in_space(name: str, data: bytes, keyword: re.Match[bytes]) -> bytes:
    """Return a file of the keyword nOFF with points of dimension 3 as plain OFF; FormatError for other points."""
    line = data.count(b"\n", 0, keyword.start()) + 1
    place = f"{name}, line {line}: {keyword[0].decode()}"
    if keyword[2].startswith(b"4"):
        raise FormatError(
            f"{place} holds points of four coordinates, homogeneous or in space of dimension 4; write OFF"
        )
    if not (number := _DIMENSION.match(data, keyword.end())):
        raise FormatError(f"{place} is not followed by the dimension of its points")
    if int(number[2]) != 3:
        raise FormatError(f"{place} holds points in space of dimension {int(number[2])}; only dimension 3 is read")
    return data[: keyword.start()] + keyword[1] + b"OFF" + number[1] + data[number.end() :]


def first_token(data: bytes) -> int:
    """Offset of the first token that is no comment."""
    at = 3 if data.startswith(b"\xef\xbb\xbf") else 0
    blank, comment = re.compile(rb"\s*"), re.compile(rb"#[^\r\n]*")
    while True:
        at = blank.match(data, at).end()  # type: ignore[union-attr]  # matches anything
        if not (found := comment.match(data, at)):
            return at
        at = found.end()


def counts_of(place: str, tokens: list[str]) -> tuple[int, int]:
    shown = " ".join(tokens[:4])
    if len(tokens) not in (2, 3) or not all(re.fullmatch(r"[+-]?\d{1,18}", token) for token in tokens):
        raise FormatError(f"{place}: expected the numbers of vertices, faces and edges, not '{shown}'")
    n, m = int(tokens[0]), int(tokens[1])
    if n < 0 or m < 0:
        raise FormatError(f"{place}: {shown}: a number of vertices or faces cannot be negative")
    if n == 0 or m == 0:
        raise FormatError(f"{place}: the file has {n} vertices and {m} faces; a surface needs some of both")
    return n, m


def _from_lines(text: TextFile, n: int, m: int, start: int) -> tuple[Polygons, dict[str, Place]]:
    """Read a file that has a line for each vertex and face; with the places of both for messages."""
    found = len(text) - start
    if found < n:
        raise FormatError(f"{text.name} ends after {found} of {n} vertices")
    if found < n + m:
        raise FormatError(f"{text.name} ends after {found - n} of {m} faces")
    vertices = text.numbers(np.arange(start, start + n))
    points, remarks = vertices.coordinates()
    faces = text.numbers(np.arange(start + n, start + n + m), integers=True)
    corners, sizes = corners_of_faces(faces)
    if surplus := found - n - m:
        place = text.place(start + n + m)
        remarks.append(f"left out {counted(surplus, 'line')} after the {n} vertices and {m} faces, from {place}")
    content = Polygons(points, corners, sizes, remarks=[*text.remarks, *remarks])
    return content, {"face_place": faces.place, "vertex_place": vertices.place}


def corners_of_faces(rows: NumberRows) -> tuple[Ints, Ints]:
    """Corners of all faces, flat, and the number of corners of each."""
    sizes = rows.integers(rows.begins)
    if (bad := (sizes < 0) | (rows.counts - 1 < sizes)).any():
        row = int(np.argmax(bad))
        raise FormatError(f"{rows.place(row)}: the face says {sizes[row]} corners, but {rows.counts[row] - 1} follow")
    is_corner = np.ones(len(rows.values), dtype=bool)
    is_corner[rows.begins] = False
    has_color = (rows.counts - 1 > sizes).any()
    return rows.integers(ranges(rows.begins + 1, sizes) if has_color else is_corner), sizes


def _from_tokens(name: str, data: bytes, keyword: re.Match[bytes] | None, prefixes: list[bytes]) -> Polygons | None:
    """Read a file as numbers, wherever its lines end, if there is one way to use up all of them."""
    if keyword:
        data = b" " * keyword.end() + data[keyword.end() :]
    text = TextFile(name, data, comments=True)
    try:
        rows = text.numbers(np.arange(len(text)))
        values = rows.values
        n, m, _ = (int(count) for count in values[:3])
    except (FormatError, ValueError, OverflowError):
        return None
    if not 0 < n < len(values) or not 0 < m < len(values):
        return None
    found = []
    for extra in product(*(WIDTHS[prefix] for prefix in prefixes)):
        begin = 3 + n * (3 + sum(extra))
        begins: list[int] = []
        at = begin
        while len(begins) < m and at < len(values) and 1 <= values[at] <= len(values) - at - 1:
            begins.append(at)
            at += int(values[at]) + 1
        if len(begins) == m and at == len(values):
            is_corner = np.arange(len(values)) >= begin
            is_corner[begins] = False
            try:
                corners = rows.integers(np.flatnonzero(is_corner))
                sizes = rows.integers(np.array(begins))
            except FormatError:
                continue
            points = values[3:begin].reshape(n, -1)[:, :3]
            found.append(Polygons(points, corners, sizes, remarks=text.remarks))
    return found[0] if len(found) == 1 else None


def _read_binary(name: str, data: bytes, start: int, prefixes: list[bytes]) -> Result:
    """Read numbers of four bytes, big-endian: counts; vertices; faces, each with its number of colors and colors."""
    words = (len(data) - start) // 4
    integers = np.frombuffer(data, ">i4", words, start)
    if words < 3:
        raise FormatError(f"{name} ends inside its header")
    n, m, _ = integers[:3].tolist()
    width = 3 + sum(WIDTHS[prefix][0] for prefix in prefixes)
    if n <= 0 or m <= 0 or n * width > words - 3:
        raise FormatError(f"{name} says {n} vertices and {m} faces, but has {len(data) - start} bytes for them")
    begins, sizes, at = [], [], 3 + n * width
    for face in range(m):
        size = int(integers[at]) if at < words else -1
        colors = int(integers[at + 1 + size]) if 0 <= size < words - at - 1 else -1
        if not 0 <= colors <= words - at - 2 - size:
            raise FormatError(f"{name} ends inside face {face} of {m}, or the face is damaged")
        begins.append(at + 1)
        sizes.append(size)
        at += 2 + size + colors
    surplus = len(data) - start - 4 * at
    points: Floats = np.frombuffer(data, ">f4", n * width, start + 12).reshape(n, width)[:, :3].astype("=f4")
    corners = integers[ranges(np.array(begins), np.array(sizes))].astype(np.int64)
    remarks = [f"left out {counted(surplus, 'byte')} after the last face"] if surplus else []
    return build_result(name, "OFF", Polygons(points, corners, np.array(sizes), remarks=remarks))
