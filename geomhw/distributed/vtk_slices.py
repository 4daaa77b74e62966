"""Slices of VTK's XML files of triangles, .vtu and .vtp, whose arrays are appended as raw bytes."""

from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, ParseError

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.sliced_file import LONGEST_HEADER, SlicedFile, unsliceable
from geomhw.errors import FormatError
from geomhw.io.formats.vtk_write import TRIANGLE
from geomhw.io.formats.vtk_xml_read import TYPES, parse_head

#: The dataset and the element of its faces, for each extension.
KINDS = {".vtu": ("UnstructuredGrid", "Cells"), ".vtp": ("PolyData", "Polys")}


class SlicedVtk(SlicedFile):
    """A file of one piece, without compression."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with path.open("rb") as stream:
            head = stream.read(LONGEST_HEADER)
        if b"<AppendedData" not in head:
            raise unsliceable(path, "its arrays are not appended as raw bytes")
        try:
            self._open(*parse_head(head))
        except (ParseError, ValueError, KeyError) as error:
            raise FormatError(f"{path} is no VTK file of an appended block: {error}") from error

    def _open(self, root: Element, start: int, encoding: str) -> None:
        """Find the arrays of the faces and vertices."""
        path, (kind, cells) = self.path, KINDS[self.path.suffix.lower()]
        self._start, self._order = start, ">" if root.get("byte_order") == "BigEndian" else "<"
        self._head = np.dtype(self._order + TYPES[root.get("header_type", "UInt32")])
        pieces = root.findall(f"{kind}/Piece")
        if root.get("compressor"):
            raise unsliceable(path, "it is compressed")
        if encoding != "raw":
            raise unsliceable(path, f"its arrays are encoded in {encoding}")
        if len(pieces) != 1:
            raise unsliceable(path, f"it has {len(pieces)} pieces")
        (piece,) = pieces
        count = "NumberOfCells" if cells == "Cells" else "NumberOfPolys"
        self.n_vertices, self.n_faces = int(piece.get("NumberOfPoints", 0)), int(piece.get(count, 0))
        if not (self.n_vertices and self.n_faces):
            raise FormatError(f"{path} has {self.n_vertices} vertices and {self.n_faces} faces; a surface needs both")
        if int(piece.get("NumberOfStrips", 0)):
            raise unsliceable(path, "it has strips of triangles")
        self._points = self._array(piece.find("Points/DataArray"), 3 * self.n_vertices)
        named = {array.get("Name"): array for array in piece.findall(f"{cells}/DataArray")}
        self._corners = self._array(named.get("connectivity"), 3 * self.n_faces)
        self._ends = self._array(named.get("offsets"), self.n_faces)
        self._kinds = self._array(named.get("types"), self.n_faces) if cells == "Cells" else None

    def read_vertices(self, begin: int, end: int) -> Floats:
        """Return the coordinates of a range of vertices."""
        return self._read(self._points, 3 * begin, 3 * end).reshape(-1, 3).astype(float)

    def read_faces(self, begin: int, end: int) -> Ints:
        """Return the vertices of a range of triangles."""
        other = self._read(self._ends, begin, end) != 3 * np.arange(begin + 1, end + 1)
        if self._kinds:
            other |= self._read(self._kinds, begin, end) != TRIANGLE
        for bad in np.flatnonzero(other)[:1]:
            raise unsliceable(self.path, f"cell {begin + bad} is no triangle")
        return self._read(self._corners, 3 * begin, 3 * end).reshape(-1, 3).astype(np.int64)

    def _array(self, element: Element | None, length: int) -> tuple[np.dtype[Any], int]:
        """The type of an appended array of some length, and its offset in the file."""
        if element is None or element.get("type") not in TYPES:
            raise FormatError(f"{self.path} lacks an array of its points or faces")
        name = element.get("Name", "Points")
        if element.get("format") != "appended":
            raise unsliceable(self.path, f"array '{name}' is not appended as raw bytes")
        kind = np.dtype(self._order + TYPES[element.get("type", "")])
        offset = self._start + int(element.get("offset", 0))
        size = np.fromfile(self.path, self._head, 1, offset=offset)
        if offset + self._head.itemsize + length * kind.itemsize > self.path.stat().st_size or not len(size):
            raise FormatError(f"{self.path} ends before the end of array '{name}'")
        if size[0] != length * kind.itemsize:
            raise unsliceable(self.path, f"array '{name}' has {size[0] // kind.itemsize} numbers, not {length}")
        return kind, offset + self._head.itemsize

    def _read(self, array: tuple[np.dtype[Any], int], begin: int, end: int) -> Any:
        kind, offset = array
        return np.fromfile(self.path, kind, end - begin, offset=offset + begin * kind.itemsize)
