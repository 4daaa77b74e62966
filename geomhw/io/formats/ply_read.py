"""Reader of PLY files: text or binary of either byte order, with elements and properties in any order.

Hand-written because meshio reads a damaged coordinate as NaN and drops face arrays, and VTK repeats the last number.
"""

import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints, ranges
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.number_parsing import cast_exactly
from geomhw.io.formats.ply_header import ORDERS, Element, Property, read_header
from geomhw.io.formats.ply_write import QUALITY
from geomhw.io.formats.polygons import Polygons, equal_triangles, strip_triangles
from geomhw.io.formats.text_file import NumberRows, TextFile
from geomhw.results import Result
from geomhw.wording import counted

_STRUCT = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d", "i8": "q", "u8": "Q"}
#: Names of the list of a face's corners.
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Lists:
    """Lists of one property: all entries flat, and the length of each list."""

    flat: NDArray[Any]
    sizes: Ints


_Columns = dict[str, NDArray[Any] | _Lists]


def read_ply(name: str, data: bytes) -> Result:
    """Return the mesh and its arrays; scalars ``v_x v_y v_z`` become one vector array ``v``."""
    remarks: list[str] = []
    order, elements, start = read_header(name, data, remarks)
    if order != "ascii":
        buffer = np.frombuffer(data, np.uint8)[start:]
        found, ignored, end = _elements(name, elements, buffer, ORDERS[order], False)
        if surplus := len(data[start + end :].strip()):
            remarks.append(f"left out {counted(surplus, 'byte')} after the last element")
    else:
        found, ignored = _text_elements(name, elements, data, start, remarks)
    copied = re.search(rf"\n{QUALITY} (\S+)\s".encode(), data[:start])
    if copied and copied[1].decode("ascii", "replace") in found.get("vertex", {}):
        found["vertex"].pop("quality", None)
    return _result(name, found, ignored, remarks)


def _elements(
    name: str, elements: list[Element], buffer: NDArray[np.uint8], order: str, text: bool
) -> tuple[dict[str, _Columns], list[str], int]:
    """The columns of the elements that are read, the names of other elements, and where the last one ends."""
    offset, found, ignored = 0, {}, []
    for element in elements:
        if not element.properties:
            continue  # its rows take no bytes, however many the header counts
        rows = _Rows(name, element, buffer, offset, order, text)
        offset = rows.end
        if element.name in ("vertex", "face", "tristrips"):
            found[element.name] = rows.columns()
        elif element.size:
            ignored.append(element.name)
    return found, ignored, offset


def _text_elements(
    name: str, elements: list[Element], data: bytes, start: int, remarks: list[str]
) -> tuple[dict[str, _Columns], list[str]]:
    """The elements of a text file: one in a line, with what goes beyond it left out, or wherever the lines end."""
    text = TextFile(name, data)
    remarks += text.remarks
    header = len(TextFile(name, data[:start]))
    rows = sum(element.size for element in elements if element.properties)
    lines = np.arange(header, len(text))
    numbers = text.numbers(lines[:rows])
    keep = _declared_numbers(elements, numbers)
    values = numbers.values if keep is None else numbers.values[keep]
    try:
        found, ignored, end = _elements(name, elements, values.view(np.uint8), "<", True)
    except FormatError as error:
        if len(lines) <= rows:
            raise
        try:  # rows may cross lines
            values, keep, rows = text.numbers(lines).values, None, len(lines)
            found, ignored, end = _elements(name, elements, values.view(np.uint8), "<", True)
        except FormatError:
            raise error from None
    if keep is not None:
        surplus = len(numbers.values) - len(keep)
        remarks.append(f"left out {counted(surplus, 'number')} beyond the properties of the header")
    surplus = len(values) - end // 8
    if surplus or len(lines) > rows:
        what = counted(surplus, "number") if surplus else counted(len(lines) - rows, "line")
        remarks.append(f"left out {what} after the last element")
    return found, ignored


def _declared_numbers(elements: list[Element], numbers: NumberRows) -> Ints | None:
    """Positions of the numbers that the header declares, if each element has its line and some have more than that."""
    needed, row, last = np.empty_like(numbers.counts, dtype=np.int64), 0, len(numbers.values) - 1
    for element in elements:
        if not element.properties:
            continue
        here = slice(row, row + element.size)
        begins, counts = numbers.begins[here], numbers.counts[here]
        if len(begins) < element.size or last < 0:
            return None
        at = begins.astype(np.int64)
        for item in element.properties:
            if item.count:
                sizes = numbers.values[np.minimum(at, last)]
                if not ((sizes >= 0) & (sizes <= last)).all():
                    return None
                at = at + sizes.astype(np.int64)
            at = at + 1
        needed[here] = at - begins
        if (needed[here] > counts).any():
            return None
        row += element.size
    if (needed == numbers.counts).all():
        return None
    return ranges(numbers.begins, needed)


def _result(name: str, found: dict[str, _Columns], ignored: list[str], remarks: list[str]) -> Result:
    vertex, face = found.get("vertex", {}), found.get("face", {})
    missing = [axis for axis in "xyz" if not isinstance(vertex.get(axis), np.ndarray)]
    if missing == ["z"]:
        vertex["z"] = np.zeros_like(vertex["x"])
        remarks.append("the vertices have two coordinates; z is 0")
    elif missing:
        raise FormatError(f"{name} has no vertices with x, y and z (missing: {', '.join(missing)})")
    polygons = next((face[key] for key in _CORNERS if key in face), None)
    strips = next((found["tristrips"][key] for key in _CORNERS if key in found.get("tristrips", {})), None)
    if isinstance(strips, _Lists) and len(strips.flat):
        polygons, face = _with_strips(polygons, face, _triangles(strips), remarks)
    if not isinstance(polygons, _Lists) or not len(polygons.sizes):
        raise FormatError(f"{name} has no faces: no element 'face' with a list 'vertex_indices'")
    with np.errstate(invalid="ignore"):  # a signaling NaN
        points = np.stack([np.asarray(vertex[axis]) for axis in "xyz"], axis=1)
    content = Polygons(
        points=points,
        corners=polygons.flat if polygons.flat.dtype == np.int32 else polygons.flat.astype(np.int64),
        sizes=polygons.sizes,
        vertex_arrays=_vectors({k: v for k, v in vertex.items() if k not in ("x", "y", "z")}),
        face_arrays=_vectors(face),
        notes={"ignored": ignored} if ignored else {},
        remarks=remarks,
    )
    return build_result(name, "PLY", content)


def _with_strips(
    faces: NDArray[Any] | _Lists | None, arrays: _Columns, strips: _Lists, remarks: list[str]
) -> tuple[_Lists, _Columns]:
    """The faces and the triangles of strips, which have no arrays; the faces alone if the strips repeat them."""
    if not isinstance(faces, _Lists) or not len(faces.sizes):
        return strips, {}
    if (faces.sizes == 3).all() and equal_triangles(faces.flat, strips.flat):
        remarks.append("left out the triangle strips, which repeat the faces")
        return faces, arrays
    if dropped := [key for key in arrays if key not in _CORNERS]:
        remarks.append(f"left out the arrays of faces, which triangle strips lack: {', '.join(dropped)}")
    flat = np.concatenate([faces.flat.astype(np.int64), strips.flat])
    return _Lists(flat, np.concatenate([faces.sizes, strips.sizes])), {}


def _triangles(strips: _Lists) -> _Lists:
    """The triangles of strips; -1 ends a strip within a list."""
    flat = strips.flat.astype(np.int64)
    starts = np.zeros(len(flat), dtype=bool)
    starts[(np.cumsum(strips.sizes) - strips.sizes)[strips.sizes > 0]] = True
    starts[1:] |= flat[:-1] == -1
    is_corner = flat != -1
    sizes = np.bincount((np.cumsum(starts) - 1)[is_corner])
    corners, _ = strip_triangles(flat[is_corner], sizes)
    return _Lists(corners, np.full(len(corners) // 3, 3))


def _vectors(columns: _Columns) -> dict[str, NDArray[Any]]:
    """The scalar columns, with each triple of a common name made one (n, 3) array in the place of its first."""
    scalars = {key: column for key, column in columns.items() if isinstance(column, np.ndarray)}
    stems = {key[:-2] for key in scalars if len(key) > 2 and all(f"{key[:-2]}_{axis}" in scalars for axis in "xyz")}
    arrays: dict[str, NDArray[Any]] = {}
    for key, column in scalars.items():
        if key[:-2] in stems and key[-2:] in ("_x", "_y", "_z"):
            arrays.setdefault(key[:-2], np.stack([scalars[f"{key[:-2]}_{axis}"] for axis in "xyz"], axis=1))
        else:
            arrays[key] = column
    return arrays


class _Rows:
    """The rows of one element: where each begins, how long its lists are, and where the next element begins.

    Rows of equal layout are described by the first of them and the bytes from one to the next, ``stride``; lists of
    mixed lengths need a walk row by row.
    """

    def __init__(
        self, name: str, element: Element, buffer: NDArray[np.uint8], offset: int, order: str, text: bool
    ) -> None:
        self.name, self.element, self.buffer, self.order, self.text = name, element, buffer, order, text
        self.begins, self.lengths, end = self._walk(offset, min(element.size, 1))
        self.stride = end - offset
        self.end = offset + element.size * self.stride
        if self.end > len(buffer) or not self._are_alike():
            self.begins, self.lengths, self.end = self._walk(offset, element.size)
            self.stride = 0

    def columns(self) -> _Columns:
        """Read all properties by name."""
        columns: _Columns = {}
        for item, at, sizes in self._properties():
            values = self._declared(item, self._values(item.kind, at, sizes))
            columns[item.name] = _Lists(values, np.broadcast_to(sizes, self.element.size)) if item.count else values
        return columns

    def _are_alike(self) -> bool:
        """Whether the lists of all rows are as long as those of the first."""
        for item, at, sizes in self._properties():
            if item.count:
                at = at - self._stored(item.count).itemsize
                if (self._values(item.count, at, np.ones_like(at)) != sizes).any():
                    return False
        return True

    def _properties(self) -> Iterator[tuple[Property, Ints, Ints]]:
        """Each property with the offsets and numbers of its values in the rows."""
        at, lengths = self.begins, iter(self.lengths.T)
        for item in self.element.properties:
            sizes = np.ones_like(at)
            if item.count:
                at, sizes = at + self._stored(item.count).itemsize, next(lengths)
            yield item, at, sizes
            at = at + sizes * self._stored(item.kind).itemsize

    def _values(self, declared: str, at: Ints, sizes: Ints) -> NDArray[Any]:
        """The values at some offsets, flat; ``sizes[i]`` values follow each other at ``at[i]``."""
        kind = self._stored(declared)
        if self.stride:
            shape = self.element.size, int(sizes[0])
            return np.ndarray(shape, kind, self.buffer, int(at[0]), (self.stride, kind.itemsize)).reshape(-1)
        everywhere = np.ndarray(max(len(self.buffer) - kind.itemsize + 1, 0), kind, self.buffer, strides=(1,))
        return everywhere[ranges(at, sizes, kind.itemsize)]

    def _walk(self, offset: int, size: int) -> tuple[Ints, Ints, int]:
        """Offsets of some rows, lengths of their lists, and the offset after them; each length says where to go on."""
        properties = self.element.properties
        lengths = [item.count and Struct(self.order + _STRUCT[self._type(item.count)]) for item in properties]
        widths = [self._stored(item.kind).itemsize for item in properties]
        steps = array("q")  # of each row, its offset and the lengths of its lists
        for row in range(size):
            steps.append(offset)
            for length, width in zip(lengths, widths, strict=True):
                count = 1
                if length:
                    if offset + length.size > len(self.buffer):
                        raise self._truncated(row)
                    (value,) = length.unpack_from(self.buffer.data, offset)
                    if not 0 <= value < 2**31 or value != int(value):
                        raise FormatError(f"{self.name}, {self.element.name} {row}: {value:g} is no length of a list")
                    count = int(value)
                    steps.append(count)
                    offset += length.size
                offset += count * width
            if offset > len(self.buffer):
                raise self._truncated(row)
        table = np.frombuffer(steps, np.int64).reshape(size, 1 + sum(map(bool, lengths)))
        return table[:, 0], table[:, 1:], offset

    def _type(self, declared: str) -> str:
        return "f8" if self.text else declared

    def _stored(self, declared: str) -> np.dtype[Any]:
        return np.dtype(self.order + self._type(declared))

    def _declared(self, item: Property, values: NDArray[Any]) -> NDArray[Any]:
        """Values in the type of the header and in native byte order."""
        try:
            return cast_exactly(values, np.dtype(item.kind)) if self.text else values.astype(item.kind, copy=False)
        except ValueError as error:
            raise FormatError(f"{self.name}: property '{item.name}' of {self.element.name}: {error}") from None

    def _truncated(self, row: int) -> FormatError:
        return FormatError(f"{self.name} ends after {row} of {self.element.size} rows of element '{self.element.name}'")
