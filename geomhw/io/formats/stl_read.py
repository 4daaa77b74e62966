"""Reader of STL files, text and binary: separate triangles, joined where corners have equal coordinates.

Hand-written because meshio exits the process on a damaged text file, and VTK ignores the count of a binary one.
"""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons
from geomhw.io.formats.text_file import TextFile
from geomhw.results import Result

_HEAD = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(name: str, data: bytes) -> Result:
    """Return the welded mesh; vertices are in the order of their first occurrence."""
    count = int.from_bytes(data[80:_HEAD], "little")
    if len(data) >= _HEAD and len(data) == _HEAD + _FACET.itemsize * count:
        soup = np.frombuffer(data, dtype=_FACET, offset=_HEAD)["corners"].reshape(-1, 3)
    elif data[:5].lower() == b"solid":
        text = TextFile(name, data)
        soup = text.numbers(text.starting_with("vertex"), keyword="vertex").coordinates()
        if len(soup) % 3:
            raise FormatError(f"{name} holds {len(soup)} triangle corners, which is not three for each triangle")
    elif len(data) < _HEAD:
        raise FormatError(f"{name} is no STL file: it neither starts with 'solid' nor has a header of {_HEAD} bytes")
    else:
        found = (len(data) - _HEAD) / _FACET.itemsize
        raise FormatError(f"{name} says {count} triangles, but there are bytes for {found:.8g}")
    if not len(soup):
        raise FormatError(f"{name} holds no triangles")
    points, corners = weld(soup)
    return build_result(name, "STL", Polygons(points, corners, np.full(len(soup) // 3, 3)))


def weld(soup: Floats) -> tuple[Floats, Ints]:
    """Return the distinct rows in order of first occurrence, and the index of each row among them; -0.0 equals 0.0."""
    order = np.lexsort(soup.T)
    ranked = soup[order]
    new = np.ones(len(soup), dtype=bool)
    new[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    first = order[new]  # lexsort is stable: the first of a group is its first occurrence
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    corners = np.empty(len(soup), dtype=np.int64)
    corners[order] = rank[np.cumsum(new) - 1]
    return soup[np.sort(first)], corners
