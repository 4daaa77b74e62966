"""Reader of PLY files: text or binary of either byte order, with elements and properties in any order.

Hand-written because meshio reads a damaged coordinate as NaN and drops face arrays, and VTK repeats the last number.
"""

import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.number_parsing import cast_exactly
from geomhw.io.formats.ply_write import QUALITY
from geomhw.io.formats.polygons import Polygons, ranges
from geomhw.io.formats.text_file import TextFile
from geomhw.results import Result

_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"}
_TYPES |= {"double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
_TYPES |= {"float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8"}
_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
_STRUCT = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d", "i8": "q", "u8": "Q"}
#: Names of the list of a face's corners.
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    count: str | None = None  # type of the length in front of a list


@dataclass(frozen=True)
class _Element:
    name: str
    size: int
    properties: list[_Property] = field(default_factory=list)


@dataclass(frozen=True)
class _Lists:
    """Lists of one property: all entries flat, and the length of each list."""

    flat: NDArray[Any]
    sizes: Ints


_Columns = dict[str, NDArray[Any] | _Lists]


def read_ply(name: str, data: bytes) -> Result:
    """Return the mesh and its arrays; scalars ``v_x v_y v_z`` become one vector array ``v``."""
    order, elements, start = _header(name, data)
    text = order == "ascii"
    buffer = _numbers_as_bytes(name, data, start) if text else np.frombuffer(data, np.uint8)[start:]
    offset, found, ignored = 0, {}, []
    for element in elements:
        if not element.properties:
            continue  # its rows take no bytes, however many the header counts
        rows = _Rows(name, element, buffer, offset, _ORDERS[order], text)
        offset = rows.end
        if element.name in ("vertex", "face"):
            found[element.name] = rows.columns()
        elif element.size:
            ignored.append(element.name)
    if offset < len(buffer) and (text or data[start + offset :].strip()):
        raise FormatError(f"{name} goes on after the last element that its header counts")
    copied = re.search(rf"\n{QUALITY} (\S+)\s".encode(), data[:start])
    if copied and copied[1].decode("ascii", "replace") in found.get("vertex", {}):
        found["vertex"].pop("quality", None)
    return _result(name, found, ignored)


def _result(name: str, found: dict[str, _Columns], ignored: list[str]) -> Result:
    vertex, face = found.get("vertex", {}), found.get("face", {})
    missing = [axis for axis in "xyz" if not isinstance(vertex.get(axis), np.ndarray)]
    if missing:
        raise FormatError(f"{name} has no vertices with x, y and z (missing: {', '.join(missing)})")
    polygons = next((face[key] for key in _CORNERS if key in face), None)
    if not isinstance(polygons, _Lists) or not len(polygons.sizes):
        raise FormatError(f"{name} has no faces: no element 'face' with a list 'vertex_indices'")
    content = Polygons(
        points=np.stack([np.asarray(vertex[axis]) for axis in "xyz"], axis=1),
        corners=polygons.flat if polygons.flat.dtype == np.int32 else polygons.flat.astype(np.int64),
        sizes=polygons.sizes,
        vertex_arrays=_vectors({k: v for k, v in vertex.items() if k not in ("x", "y", "z")}),
        face_arrays=_vectors(face),
        notes={"ignored": ignored} if ignored else {},
    )
    return build_result(name, "PLY", content)


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


def _header(name: str, data: bytes) -> tuple[str, list[_Element], int]:
    """Encoding, elements, and where the body begins."""
    if not re.match(rb"ply\s*[\r\n]", data):
        raise FormatError(f"{name}, line 1: a PLY file starts with 'ply'")
    end = re.search(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r|$)", data)
    if end is None:
        raise FormatError(f"{name} ends inside its header: there is no 'end_header'")
    order, elements = "", []
    for number, line in enumerate(data[: end.start()].decode("utf-8", "replace").splitlines(), start=1):
        match line.split():
            case ["format", kind, *_]:
                order = kind
            case ["element", key, count] if re.fullmatch(r"[0-9]{1,18}", count):
                elements.append(_Element(key, int(count)))
            case ["property", "list", count, kind, key] if elements and {count, kind} <= _TYPES.keys():
                elements[-1].properties.append(_Property(key, _TYPES[kind], _TYPES[count]))
            case ["property", kind, key] if elements and kind in _TYPES:
                elements[-1].properties.append(_Property(key, _TYPES[kind]))
            case [] | ["ply"] | ["comment" | "obj_info", *_]:
                pass
            case _:
                shown = line.strip()[:60]
                raise FormatError(f"{name}, line {number}: '{shown}' is not understood in the header of a PLY file")
    if order not in _ORDERS:
        raise FormatError(f"{name} is in the unknown PLY format '{order}'; known are {', '.join(_ORDERS)}")
    return order, elements, end.end()


def _numbers_as_bytes(name: str, data: bytes, start: int) -> NDArray[np.uint8]:
    """The body of a text file as that of a binary file in which all numbers are doubles."""
    text = TextFile(name, data)
    header = len(TextFile(name, data[:start]))
    return text.numbers(np.arange(header, len(text))).values.view(np.uint8)


class _Rows:
    """The rows of one element: where each begins, how long its lists are, and where the next element begins.

    Rows of equal layout are described by the first of them and the bytes from one to the next, ``stride``; lists of
    mixed lengths need a walk row by row.
    """

    def __init__(
        self, name: str, element: _Element, buffer: NDArray[np.uint8], offset: int, order: str, text: bool
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
        for item, _, sizes in self._properties():  # before rows of a byte become many bytes
            if self.element.name == "face" and item.count and item.name in _CORNERS and sizes.min(initial=3) < 3:
                row = int(np.argmax(sizes < 3))
                raise FormatError(f"{self.name}, face {row}: face has {sizes[row]} corners; it needs at least 3")
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

    def _properties(self) -> Iterator[tuple[_Property, Ints, Ints]]:
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

    def _declared(self, item: _Property, values: NDArray[Any]) -> NDArray[Any]:
        """Values in the type of the header and in native byte order."""
        try:
            return cast_exactly(values, np.dtype(item.kind)) if self.text else values.astype(item.kind, copy=False)
        except ValueError as error:
            raise FormatError(f"{self.name}: property '{item.name}' of {self.element.name}: {error}") from None

    def _truncated(self, row: int) -> FormatError:
        return FormatError(f"{self.name} ends after {row} of {self.element.size} rows of element '{self.element.name}'")
