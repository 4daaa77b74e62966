"""Slices of binary PLY files of triangles."""

from pathlib import Path
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.sliced_file import LONGEST_HEADER, SlicedFile, unsliceable
from geomhw.errors import FormatError
from geomhw.io.formats.ply_header import ORDERS, Element, read_header


class SlicedPly(SlicedFile):
    """A binary PLY file, whose rows of each element have one length."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with path.open("rb") as stream:
            head = stream.read(LONGEST_HEADER)
        encoding, elements, start = read_header(str(path), head)
        if encoding == "ascii":
            raise unsliceable(path, "it is a text file")
        self._order, self._begins = ORDERS[encoding], dict[str, int]()
        self._rows = {element.name: self._row(element) for element in elements if element.properties}
        for element in elements:
            if element.properties:
                self._begins[element.name] = start
                start += element.size * self._rows[element.name].itemsize
        sizes = {element.name: element.size for element in elements}
        vertex, face = self._rows.get("vertex"), self._rows.get("face")
        if not (vertex and set("xyz") <= set(vertex.names or ())):
            raise FormatError(f"{path} has no vertices with x, y and z")
        if not (face and sizes["face"] and "corners" in (face.names or ())):
            raise FormatError(f"{path} has no faces: no element 'face' with a list 'vertex_indices'")
        self.n_vertices, self.n_faces = sizes["vertex"], sizes["face"]
        if path.stat().st_size < start:
            raise FormatError(f"{path} ends before its last row; {start - path.stat().st_size} bytes are missing")

    def read_vertices(self, begin: int, end: int) -> Floats:
        """Return the coordinates of a range of vertices."""
        rows = self._read("vertex", begin, end)
        return np.stack([rows[axis].astype(float) for axis in "xyz"], axis=1)

    def read_faces(self, begin: int, end: int) -> Ints:
        """Return the vertices of a range of triangles."""
        rows = self._read("face", begin, end)
        if (other := rows["count"] != 3).any():
            bad = int(np.argmax(other))
            raise unsliceable(self.path, f"face {begin + bad} has {rows['count'][bad]} corners")
        return rows["corners"].astype(np.int64)

    def _row(self, element: Element) -> np.dtype[Any]:
        """The layout of a row of an element, with lists of three."""
        fields: list[tuple[object, ...]] = []
        for item in element.properties:
            if item.count is None:
                fields.append((item.name, self._order + item.kind))
            elif element.name == "face" and item.name in ("vertex_indices", "vertex_index"):
                fields += [("count", self._order + item.count), ("corners", self._order + item.kind, (3,))]
            else:
                raise unsliceable(self.path, f"element '{element.name}' has the list '{item.name}'")
        return np.dtype(fields)

    def _read(self, element: str, begin: int, end: int) -> Ints:
        row = self._rows[element]
        return np.fromfile(self.path, row, end - begin, offset=self._begins[element] + begin * row.itemsize)
