"""STL files, text and binary: a soup of triangles, welded where corners have equal coordinates."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.assemble import Polygons, assemble
from geomhw.io.formats.off_read import coordinates
from geomhw.io.formats.tokens import Lines
from geomhw.results import Result

_HEAD = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(name: str, data: bytes) -> Result:
    """The welded mesh; vertices come in the order in which the file first names them."""
    binary = len(data) >= _HEAD and len(data) == _HEAD + _FACET.itemsize * int.from_bytes(data[80:84], "little")
    if binary:
        soup = np.frombuffer(data, dtype=_FACET, offset=_HEAD)["corners"].reshape(-1, 3)
    elif data[:5].lower() == b"solid":
        soup = _text(name, data)
    else:
        raise _wrong_size(name, data)
    if not len(soup):
        raise FormatError(f"{name} holds no triangles")
    points, corners = weld(soup)
    sizes = np.full(len(soup) // 3, 3)
    return assemble(name, "STL", Polygons(points, corners, sizes))


def _wrong_size(name: str, data: bytes) -> FormatError:
    if len(data) < _HEAD:
        return FormatError(f"{name} is no STL file: it neither starts with 'solid' nor has a header of {_HEAD} bytes")
    said = int.from_bytes(data[80:84], "little")
    there = (len(data) - _HEAD) / _FACET.itemsize
    return FormatError(f"{name} says {said} triangles, but there are bytes for {there:.8g}")


def _text(name: str, data: bytes) -> Floats:
    lines = Lines(name, data)
    rows = lines.starting_with("vertex")
    points = coordinates(lines, rows, lines.numbers(rows, keyword="vertex"))
    if len(rows) % 3:
        raise FormatError(f"{name} holds {len(rows)} triangle corners, which is not three for each triangle")
    return points


def weld(soup: Floats) -> tuple[Floats, Ints]:
    """Unique rows in order of first occurrence, and for each row of the soup its place among them; -0.0 equals 0.0."""
    order = np.lexsort(soup.T)
    ranked = soup[order]
    new = np.ones(len(soup), dtype=bool)
    new[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    group = np.cumsum(new) - 1
    first = order[new]  # lexsort is stable: the first of a group is its first occurrence
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    corners = np.empty(len(soup), dtype=np.int64)
    corners[order] = rank[group]
    return soup[np.sort(first)], corners
