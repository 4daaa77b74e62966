"""Reader of legacy VTK files of polydata and unstructured grids, text and binary, versions 1 to 5."""

import re
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.number_parsing import parse_array
from geomhw.io.formats.text_file import token_starts
from geomhw.io.formats.vtk_cells import LINE, POLYGON, STRIP, VERTEX, Cells, Dataset, from_offsets, surface
from geomhw.results import Result

_TYPES = {"char": "i1", "signed_char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2"}
_TYPES |= {"int": "i4", "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "float": "f4", "double": "f8"}
_TYPES |= {"vtkidtype": "i4", "vtktypeint64": "i8", "vtktypeuint64": "u8"}
_CELLS = {"VERTICES": VERTEX, "LINES": LINE, "POLYGONS": POLYGON, "TRIANGLE_STRIPS": STRIP, "CELLS": 0}
_WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}


def read_vtk(name: str, data: bytes) -> Result:
    """Triangles, quads and polygons of a legacy VTK file, with its arrays."""
    return surface(name, "VTK", _Legacy(name, data).dataset)


class _Legacy:
    """Walks through a file once; ``dataset`` holds what it found."""

    def __init__(self, name: str, data: bytes) -> None:
        self.name, self.data = name, data
        self.dataset = Dataset()
        self._arrays, self._rows = self.dataset.mesh_arrays, 0
        self._parts: dict[str, Cells] = {}
        match = re.match(rb"# vtk DataFile Version (\d{1,9})\.\d+[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s", data)
        if match is None:
            raise FormatError(f"{name} does not start as a legacy VTK file does ('# vtk DataFile Version 3.0')")
        self._version, self._text = int(match[1]), match[2] == b"ASCII"
        self._at = match.end()
        self._starts = token_starts(np.frombuffer(data, np.uint8)) if self._text else np.empty(0, np.int64)
        try:
            while words := self._line():
                self._section(words)
        except (ValueError, IndexError, KeyError) as error:
            raise FormatError(f"{name}, line {self._number()}: not understood as legacy VTK ({error})") from error
        # Cell data go by this order, whatever the order in the file.
        self.dataset.cells = [self._parts[keyword] for keyword in _CELLS if keyword in self._parts]

    def _section(self, words: list[str]) -> None:
        keyword = words[0].upper()
        if keyword == "DATASET":
            if words[1].upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                raise FormatError(f"{self.name} holds a {words[1]}, not polydata or an unstructured grid")
        elif keyword == "POINTS":
            self.dataset.points = self._take(3 * int(words[1]), words[2]).reshape(-1, 3)
        elif keyword in _CELLS:
            self._parts[keyword] = self._cells(int(words[1]), int(words[2]), _CELLS[keyword])
        elif keyword == "CELL_TYPES":
            cells = self._parts["CELLS"]
            self._parts["CELLS"] = Cells(cells.corners, cells.sizes, self._take(int(words[1]), "int"))
        elif keyword in ("POINT_DATA", "CELL_DATA"):
            self._rows = int(words[1])
            self._arrays = self.dataset.vertex_arrays if keyword == "POINT_DATA" else self.dataset.cell_arrays
        elif keyword == "METADATA":
            blank = re.compile(rb"\n[ \t\r]*(\n|$)").search(self.data, self._at - 1)
            self._at = blank.end() if blank else len(self.data)
        elif keyword == "FIELD":
            self._field(int(words[2]))
        else:
            self._attribute(keyword, words)

    def _attribute(self, keyword: str, words: list[str]) -> None:
        if keyword == "SCALARS":
            width = int(words[3]) if len(words) > 3 else 1
            table = re.compile(rb"\s*LOOKUP_TABLE[ \t]+\S+[ \t\r]*\n").match(self.data, self._at)
            self._at = table.end() if table else self._at
            self._keep(words[1], width, words[2])
        elif keyword == "LOOKUP_TABLE":
            self._take(4 * int(words[2]), "float" if self._text else "unsigned_char")
        elif keyword == "COLOR_SCALARS":
            self._keep(words[1], int(words[2]), "float" if self._text else "unsigned_char")
        elif keyword == "TEXTURE_COORDINATES":
            self._keep(words[1], int(words[2]), words[3])
        elif keyword in _WIDTHS:
            self._keep(words[1], _WIDTHS[keyword], words[2])
        else:
            raise FormatError(f"{self.name}, line {self._number()}: unknown keyword '{words[0][:40]}' in legacy VTK")

    def _keep(self, name: str, width: int, kind: str) -> None:
        values = self._take(width * self._rows, kind)
        self._arrays[unquote(name)] = values.reshape(-1, width) if width > 1 else values

    def _field(self, count: int) -> None:
        for _ in range(count):
            words = self._line()
            while words == ["METADATA"]:  # an array may have that name, with its sizes behind it
                self._section(words)
                words = self._line()
            name, width, rows, kind = words
            values = self._take(int(width) * int(rows), kind)
            self._arrays[unquote(name)] = values.reshape(-1, int(width)) if int(width) > 1 else values

    def _cells(self, count: int, size: int, kind: int) -> Cells:
        if self._version < 5:
            return _counted(self._take(size, "int"), count, kind)
        offsets = self._take(count, self._line()[1])
        connectivity = self._take(size, self._line()[1])
        return from_offsets(self.name, connectivity, offsets[1:], kind)

    def _line(self) -> list[str]:
        """Words of the next line that has any; none at the end of the file."""
        while self._at < len(self.data):
            end = self.data.find(b"\n", self._at)
            end = len(self.data) if end < 0 else end
            words = self.data[self._at : end].decode("utf-8", "replace").split()
            self._at = end + 1
            if words:
                return words
        return []

    def _take(self, count: int, kind: str) -> NDArray[Any]:
        """The next numbers, in native byte order."""
        if kind.lower() not in _TYPES:
            raise FormatError(f"{self.name}, line {self._number()}: arrays of type '{kind}' are not read")
        target = np.dtype(_TYPES[kind.lower()])
        if count < 0:
            raise ValueError(f"a count of {count}")
        if not self._text:
            end = self._at + count * target.itemsize
            if end > len(self.data):
                raise self._truncated()
            values = np.frombuffer(self.data, target.newbyteorder(">"), count, self._at)
            self._at = end
            return values.astype(target)
        first = int(np.searchsorted(self._starts, self._at))
        if first + count > len(self._starts):
            raise self._truncated()
        end = int(self._starts[first + count]) if first + count < len(self._starts) else len(self.data)
        text = self.data[self._at : end] if count else b""
        values = parse_array(text, target)
        self._at = end
        return values

    def _truncated(self) -> FormatError:
        return FormatError(f"{self.name} ends inside the array that starts after line {self._number()}")

    def _number(self) -> int:
        return max(1, self.data.count(b"\n", 0, self._at))


def _counted(flat: Ints, count: int, kind: int) -> Cells:
    """Cells that each start with their number of corners."""
    if count > len(flat):
        raise ValueError(f"{count} cells in {len(flat)} numbers")
    width = len(flat) // count if count else 0
    if width * count == len(flat) and np.all(flat[:: max(width, 1)] == width - 1):
        return Cells(flat.reshape(count, width)[:, 1:].ravel(), np.full(count, width - 1), np.full(count, kind))
    heads = [0]
    # Mixed sizes: each one says where the next stands.
    for _ in range(count):
        heads.append(heads[-1] + 1 + max(0, int(flat[heads[-1]])))
    if heads[-1] != len(flat):
        raise ValueError("the sizes of the cells do not add up")
    is_corner = np.ones(len(flat), dtype=bool)
    is_corner[heads[:-1]] = False
    return Cells(flat[is_corner], np.diff(heads) - 1, np.full(count, kind))
