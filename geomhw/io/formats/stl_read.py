"""Reader of STL files, text and binary: separate triangles, joined where corners have the same position.

Hand-written because meshio exits the process on a damaged text file, and VTK ignores the count of a binary one.
"""

import re

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons
from geomhw.io.formats.text_file import TextFile
from geomhw.mesh.welding import distinct_points, first_nearby
from geomhw.results import Result
from geomhw.wording import counted

_HEAD = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_SOLID = re.compile(rb"(?:\xef\xbb\xbf)?\s*solid(?![^\s])", re.IGNORECASE)
_WORDS = re.compile(rb"[ \t](?=(?:vertex|endloop|endfacet|facet|outer)\b)", re.IGNORECASE)
_SIGNIFICANT = re.compile(rb"[+-]?0*\.?0*(\d*\.?\d*)(?:[eE].*)?")
#: Roundings of single precision, over the largest coordinate, that positions of one corner may differ by.
_SINGLE = 2.0**-22
#: The least tolerance, over the extent, for numbers of double precision; and the most, over extent and median edge.
_DOUBLE, _COARSEST, _MEDIAN = 1e-9, 1e-3, 0.1
#: Numbers whose digits are counted, and facets whose first edge is measured; digits below which nothing is known of
#: their precision.
_SAMPLE, _FEWEST = 3000, 6


def read_stl(name: str, data: bytes) -> Result:
    """Return the welded mesh; vertices are in the order of their first occurrence."""
    count = int.from_bytes(data[80:_HEAD], "little")
    found = (len(data) - _HEAD) / _FACET.itemsize
    head = data[:_HEAD] if len(data) > _HEAD else data.rstrip(b"\0\r\n")
    is_text = found != count and _SOLID.match(data) is not None and b"\0" not in head
    remarks: list[str] = []
    if is_text:
        soup, sizes, precision, remarks = _from_text(name, data)
    elif len(data) < _HEAD or (found < count and b"\0" not in data[:_HEAD]):
        raise FormatError(f"{name} is no STL file: it neither starts with 'solid' nor has a header of {_HEAD} bytes")
    elif found < count or count == 0 < found:
        raise FormatError(f"{name} says {count} triangles, but there are bytes for {found:.8g}")
    else:
        soup = np.frombuffer(data, dtype=_FACET, count=count, offset=_HEAD)["corners"].reshape(-1, 3)
        sizes, precision = np.full(count, 3), _SINGLE
        if surplus := len(data) - _HEAD - count * _FACET.itemsize:
            remarks.append(f"left out {counted(surplus, 'byte')} after the last of {count} triangles")
    if not len(soup):
        raise FormatError(f"{name} holds no triangles")
    points, corners = weld(soup, precision, remarks)
    return build_result(name, "STL", Polygons(points, corners, sizes, remarks=remarks))


def _from_text(name: str, data: bytes) -> tuple[Floats, Ints, float, list[str]]:
    """Corners of all loops, the number of them in each, their precision over the largest coordinate, and remarks."""
    text, lines = _vertex_lines(name, data)
    rows = text.numbers(lines, keyword="vertex")
    soup, remarks = rows.coordinates()
    begins, sizes = _loops(data, lines)
    if (short := sizes < 3).any():
        bad = int(np.argmax(short))
        raise FormatError(f"{rows.place(int(begins[bad]))}: a loop has {sizes[bad]} corners; a triangle needs 3")
    if not (finite := np.isfinite(soup).all(axis=1)).all():
        bad = int(np.argmin(finite))
        shown = " ".join(map(str, soup[bad].tolist()))
        raise FormatError(f"{rows.place(bad)}: a coordinate is not a finite number: {shown}")
    tokens = [token for line in lines[: _SAMPLE // 3].tolist() for token in text.tokens(line)[1:4]]
    return soup, sizes, _printed_precision([token.encode() for token in tokens], soup), [*text.remarks, *remarks]


def _vertex_lines(name: str, data: bytes) -> tuple[TextFile, Ints]:
    """The lines that start with 'vertex', of a text with a line for each word of the format where it has none."""
    text = TextFile(name, data)
    lines = text.starting_with("vertex")
    if not len(lines):
        lines = text.starting_with("vertex", any_case=True)
    if not len(lines) or (text.counts[lines] != 4).any() or (_loops(data, lines)[1] < 3).any():
        split = TextFile(name, _WORDS.sub(b"\n", data))
        found = split.starting_with("vertex", any_case=True)
        if len(found) and (split.counts[found] == 4).all() and (_loops(data, found)[1] >= 3).all():
            return split, found
    return text, lines


def _loops(data: bytes, lines: Ints) -> tuple[Ints, Ints]:
    """First corner and number of corners of the loops; every three corners, if there is nothing between them."""
    begins = np.flatnonzero(np.diff(lines, prepend=-2) > 1)
    if len(begins) * 3 != len(lines) and b"loop" not in data.lower():
        begins = np.arange(0, len(lines), 3)
    return begins, np.diff(begins, append=len(lines))


def _printed_precision(tokens: list[bytes], soup: Floats) -> float:
    """The last printed place, over the largest coordinate, with half a place for the rounding of each of two numbers.

    Numbers that single precision holds exactly have that precision.
    """
    largest = float(np.abs(soup).max(initial=0))
    if not tokens or not largest:
        return _SINGLE
    decimals = {len(token.partition(b".")[2]) if b"e" not in token.lower() else -1 for token in tokens}
    place = np.floor(np.log10(largest))
    if len(decimals) == 1 and min(decimals) >= 3:  # all are printed with the same number of decimals
        return max(1.5 * 10.0 ** -min(decimals) / largest, _DOUBLE)
    digits = max(len(_SIGNIFICANT.sub(rb"\1", token).replace(b".", b"")) for token in tokens)
    with np.errstate(over="ignore"):
        if digits < _FEWEST or (soup == soup.astype(np.float32)).all():
            return _SINGLE
    return max(1.5 * 10.0 ** (place + 1 - digits) / largest, _DOUBLE)


def weld(soup: Floats, precision: float, remarks: list[str]) -> tuple[Floats, Ints]:
    """Return the distinct points in order of first occurrence, and the index of each corner among them.

    Points that differ by the precision of the file, over the largest coordinate, are one; a remark counts those that
    are not equal. The tolerance is bounded by the extent of the mesh and its median edge.
    """
    first, corners = distinct_points(soup)
    distinct = soup[first]
    with np.errstate(invalid="ignore", over="ignore"):
        points = distinct.astype(np.float64)
        columns = points.T
        low, high = np.array([[c.min(), c.max()] for c in columns]).T  # nan or infinite if a coordinate is
        extent, largest = float((high - low).max()), float(np.maximum(-low, high).max())
        step = 3 * max(1, len(corners) // (3 * _SAMPLE))
        edges = points[corners[1::step]] - points[corners[: len(corners) - 1 : step]]
        median = float(np.median(np.linalg.norm(edges, axis=1)))
        tolerance = min(precision * largest, _COARSEST * extent, _MEDIAN * median)
    if not (0 < tolerance < np.inf and np.isfinite(extent)):
        return distinct, corners
    group = first_nearby(points, tolerance)
    kept = group == np.arange(len(group))
    if kept.all():
        return distinct, corners
    gap = float(np.abs(points - points[group]).max())
    joined = counted(int(np.count_nonzero(~kept)), "position")
    remarks.append(f"joined {joined} with another one within {tolerance:.3g}, at most {gap:.3g} apart")
    return distinct[kept], (np.cumsum(kept) - 1)[group[corners]]
