"""Reader of legacy VTK files of polydata, unstructured grids and structured grids, text and binary, versions 1 to 5.

Hand-written because VTK reads the index 1.5 as 1 and keeps indices out of range, and meshio reads no polydata.
"""

import math
import re
from itertools import islice
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.number_parsing import parse_array
from geomhw.io.formats.text_file import token_starts
from geomhw.io.formats.vtk_cells import LINE, POLYGON, STRIP, VERTEX, Cells, Dataset, cells_from_offsets, surface
from geomhw.io.formats.vtk_structured import grid_points, grid_quads
from geomhw.results import Result

_TYPES = {"char": "i1", "signed_char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2"}
_TYPES |= {"int": "i4", "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "float": "f4", "double": "f8"}
_TYPES |= {"bit": "u1", "vtkidtype": "i4", "vtktypeint64": "i8", "vtktypeuint64": "u8"}
#: In the order in which cell arrays count the cells of polydata.
_CELLS = {"VERTICES": VERTEX, "LINES": LINE, "POLYGONS": POLYGON, "TRIANGLE_STRIPS": STRIP, "CELLS": 0}
_WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}
#: Arrays of these types are left out.
_TEXTS = ("string", "utf8_string", "variant")
_STRUCTURED = ("STRUCTURED_GRID", "STRUCTURED_POINTS", "RECTILINEAR_GRID")


_HEAD = re.compile(
    rb"(?:\xef\xbb\xbf)?\s*# vtk DataFile Version (\d{1,9})\.\d+[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s", re.IGNORECASE
)
_TABLE = re.compile(rb"\s*LOOKUP_TABLE[ \t]+\S+[ \t\r]*\n?", re.IGNORECASE)


def read_vtk(name: str, data: bytes) -> Result:
    """Return the triangles, quads and polygons with their arrays."""
    return surface(name, "VTK", _LegacyFile(name, data).dataset)


class _LegacyFile:
    """Reads a file from front to end into ``dataset``."""

    def __init__(self, name: str, data: bytes) -> None:
        self.name, self.data = name, data
        self.dataset = Dataset()
        self._arrays, self._rows = self.dataset.mesh_arrays, 0
        self._cells: dict[str, Cells] = {}
        self._grid, self._size = "", np.zeros(3, np.int64)  # kind and dimensions of a structured grid
        self._axes: dict[str, NDArray[Any]] = {}
        match = _HEAD.match(data)
        if match is None:
            raise FormatError(f"{name} does not start as a legacy VTK file does ('# vtk DataFile Version 3.0')")
        self._version, self._text = int(match[1]), match[2].upper() == b"ASCII"
        self._at = self._line_start = match.end()
        self._starts = token_starts(np.frombuffer(data, np.uint8)) if self._text else np.empty(0, np.int64)
        try:
            while words := self._words():
                if self.dataset.points is not None and self._cells and not words[0][:1].isalpha():
                    line = self.data.count(b"\n", 0, self._line_start) + 1
                    self.dataset.remarks.append(f"left out what follows the data from {name}, line {line}")
                    break
                self._read_section(words)
        except (ValueError, IndexError, KeyError) as error:
            raise FormatError(f"{name}, line {self._line()}: not understood as legacy VTK ({error})") from error
        if self._grid:
            if self.dataset.points is None and self._size.all():
                self.dataset.points = grid_points(self._axes, self._size)
            self._cells = {"CELLS": grid_quads(f"{name}, a {self._grid},", self._size, self.dataset.points)}
        self.dataset.cells = [self._cells[keyword] for keyword in _CELLS if keyword in self._cells]

    def _read_section(self, words: list[str]) -> None:
        bytes_or_floats = "float" if self._text else "unsigned_char"
        match [words[0].upper(), *words[1:]]:
            case ["DATASET", kind, *_]:
                if kind.upper() in _STRUCTURED:
                    self._grid = kind
                elif kind.upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                    raise FormatError(f"{self.name} holds a {kind}, not polydata or a grid")
            case ["DIMENSIONS", x, y, z, *_] if self._grid:
                self._skip_words(4)
                self._size = np.array([int(x), int(y), int(z)])
                if min(self._size) < 1 or math.prod(self._size.tolist()) > len(self.data):
                    size = f"{x} {y} {z}"[:60]
                    raise FormatError(f"{self.name} has the dimensions {size} in {len(self.data)} bytes; it is damaged")
            case ["ORIGIN" | "SPACING" | "ASPECT_RATIO" as keyword, x, y, z, *_] if self._grid:
                self._skip_words(4)
                self._axes[keyword.replace("ASPECT_RATIO", "SPACING")] = np.array([float(x), float(y), float(z)])
            case ["X_COORDINATES" | "Y_COORDINATES" | "Z_COORDINATES" as keyword, count, kind, *_] if self._grid:
                self._skip_words(3)
                self._axes[keyword] = self._take(int(count), kind)
            case ["POINTS", count, kind, *_]:
                self._skip_words(3)
                self.dataset.points = self._take(3 * int(count), kind).reshape(-1, 3)
            case [keyword, count, size, *_] if keyword in _CELLS:
                self._skip_words(3)
                self._cells[keyword] = self._read_cells(int(count), int(size), _CELLS[keyword])
            case ["CELL_TYPES", count, *_]:
                self._skip_words(2)
                cells = self._cells["CELLS"]
                if int(count) != len(cells.sizes):
                    raise FormatError(f"{self.name} has {int(count)} cell types for {len(cells.sizes)} cells")
                self._cells["CELLS"] = Cells(cells.corners, cells.sizes, self._take(int(count), "int"))
            case ["POINT_DATA" | "CELL_DATA" as keyword, count, *_]:
                self._rows = int(count)
                self._arrays = self.dataset.vertex_arrays if keyword == "POINT_DATA" else self.dataset.cell_arrays
            case ["METADATA", *_]:
                blank = re.compile(rb"\n[ \t\r]*(\n|$)").search(self.data, self._at - 1)
                self._at = blank.end() if blank else len(self.data)
            case ["FIELD", _, count, *_]:
                self._skip_words(3)
                self._read_field(int(count))
            case ["SCALARS", name, kind, *width]:
                self._skip_words(4)
                table = _TABLE.match(self.data, self._at)
                self._at = table.end() if table else self._at
                self._read_array(name, int(width[0]) if width else 1, self._rows, kind)
            case ["LOOKUP_TABLE", _, count, *_]:
                self._skip_words(3)
                self._take(4 * int(count), bytes_or_floats)
            case ["COLOR_SCALARS", name, width, *_]:
                self._skip_words(3)
                self._read_array(name, int(width), self._rows, bytes_or_floats)
            case ["TEXTURE_COORDINATES", name, width, kind, *_]:
                self._skip_words(4)
                self._read_array(name, int(width), self._rows, kind)
            case [keyword, name, kind, *_] if keyword in _WIDTHS:
                self._skip_words(3)
                self._read_array(name, _WIDTHS[keyword], self._rows, kind)
            case _:
                shown = " ".join(words)[:40]
                raise FormatError(
                    f"{self.name}, line {self._line()}: '{shown}' is not understood as a section of legacy VTK"
                )

    def _read_array(self, name: str, width: int, rows: int, kind: str) -> None:
        if kind.lower() in _TEXTS:
            self._skip_texts(width * rows)
            self.dataset.remarks.append(f"left out array '{unquote(name)}', which holds texts")
            return
        values = self._take(width * rows, kind)
        self._arrays[unquote(name)] = values.reshape(-1, width) if width > 1 else values

    def _read_field(self, count: int) -> None:
        for _ in range(count):
            words = self._words()
            while [word.upper() for word in words] == [
                "METADATA"
            ]:  # an array may have that name, followed by its sizes
                self._read_section(words)
                words = self._words()
            name, width, rows, kind = words[:4]
            self._skip_words(4)
            self._read_array(name, int(width), int(rows), kind)

    def _read_cells(self, count: int, size: int, kind: int) -> Cells:
        if self._version < 5:
            return _cells_with_counts(self._take(size, "int"), count, kind)
        offsets, connectivity = (self._take(length, self._kind()) for length in (count, size))
        return cells_from_offsets(self.name, connectivity, offsets[1:], kind)

    def _kind(self) -> str:
        """The type in the line of a keyword and a type."""
        kind = self._words()[1]
        self._skip_words(2)
        return kind

    def _skip_words(self, count: int) -> None:
        """Go on after some words of the last line, where numbers may follow them in a text file."""
        line = self.data[self._line_start : self._at]
        if self._text and len(tokens := list(islice(re.finditer(rb"\S+", line), count + 1))) > count:
            self._at = self._line_start + tokens[count].start()

    def _skip_texts(self, count: int) -> None:
        """Go on after some texts: lines, or bytes that follow their number."""
        first_line = self._line()
        for k in range(count):
            if self._at > len(self.data) or (self._at == len(self.data) and not (self._text and k == count - 1)):
                raise FormatError(f"{self.name} ends inside the array that starts after line {first_line}")
            if self._text:
                end = self.data.find(b"\n", self._at)
                self._at = end + 1 if end >= 0 else len(self.data)
            else:  # the first two bits are the number of bytes of the length
                size = 8 >> (self.data[self._at] >> 6)
                length = int.from_bytes(self.data[self._at : self._at + size], "big") & ((1 << (8 * size - 2)) - 1)
                self._at += size + length
        if self._at > len(self.data):
            raise FormatError(f"{self.name} ends inside the array that starts after line {first_line}")

    def _words(self) -> list[str]:
        """Words of the next line that has any; none at the end of the file."""
        while self._at < len(self.data):
            end = self.data.find(b"\n", self._at) % (len(self.data) + 1)  # -1 means the end of the file
            words = self.data[self._at : end].decode("utf-8", "replace").split()
            self._line_start = self._at
            self._at = end + 1
            if words:
                return words
        return []

    def _take(self, count: int, kind: str) -> NDArray[Any]:
        """The next numbers, in native byte order."""
        if kind.lower() == "bit" and not self._text:
            packed = self._take(-(-count // 8), "unsigned_char")
            return np.unpackbits(packed)[:count]
        if kind.lower() not in _TYPES:
            raise FormatError(f"{self.name}, line {self._line()}: arrays of type '{kind}' are not read")
        target = np.dtype(_TYPES[kind.lower()])
        if count < 0:
            raise ValueError(f"a count of {count}")
        first = int(np.searchsorted(self._starts, self._at))
        there = len(self._starts) - first if self._text else (len(self.data) - self._at) // target.itemsize
        if count > there:
            raise FormatError(f"{self.name} ends inside the array that starts after line {self._line()}")
        if self._text:
            end = int(self._starts[first + count]) if count < there else len(self.data)
            values = parse_array(self.data[self._at : end] if count else b"", target)
        else:
            end = self._at + count * target.itemsize
            values = np.frombuffer(self.data, target.newbyteorder(">"), count, self._at).astype(target)
        self._at = end
        return values

    def _line(self) -> int:
        return max(1, self.data.count(b"\n", 0, self._at))


def _cells_with_counts(flat: Ints, count: int, kind: int) -> Cells:
    """Cells that each start with their number of corners."""
    if count > len(flat):
        raise ValueError(f"{count} cells in {len(flat)} numbers")
    types = np.full(count, kind)
    width = len(flat) // count if count else 0
    if width * count == len(flat) and np.all(flat[:: max(width, 1)] == width - 1):
        return Cells(flat.reshape(count, width)[:, 1:].ravel(), np.full(count, width - 1), types)
    heads = [0]
    for _ in range(count):  # mixed sizes: each says where the next cell starts
        heads.append(heads[-1] + 1 + max(0, int(flat[heads[-1]])))
    if heads[-1] != len(flat):
        raise ValueError("the sizes of the cells do not add up")
    is_corner = np.ones(len(flat), dtype=bool)
    is_corner[heads[:-1]] = False
    return Cells(flat[is_corner], np.diff(heads) - 1, types)
