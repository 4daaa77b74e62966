"""PLY files of any layout: text or binary of either byte order, elements and properties in any order."""

import re
import struct
from array import array
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.assemble import Polygons, assemble
from geomhw.io.formats.polygons import ragged
from geomhw.io.formats.tokens import Lines
from geomhw.results import Result

_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"}
_TYPES |= {"double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
_TYPES |= {"float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8"}
_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
_STRUCT = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d", "i8": "q", "u8": "Q"}
#: Names of the list of a face's corners.
_CORNERS = ("vertex_indices", "vertex_index")
_ALL = np.empty(0, np.int64)  # stands for all rows, where there is one group


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
    """Mesh and arrays of a PLY file; scalars ``v_x v_y v_z`` make one vector array ``v``."""
    order, elements, body = _header(name, data)
    text = order == "ascii"
    buffer = _numbers_as_bytes(name, data, body) if text else np.frombuffer(data, np.uint8)[body:]
    offset, found, ignored = 0, {}, []
    for element in elements:
        if not element.properties:
            continue  # its rows take no bytes, however many the header counts
        reader = _Reader(name, element, _ORDERS[order], text)
        if element.name in ("vertex", "face"):
            found[element.name], offset = reader.read(buffer, offset)
        elif element.size:
            offset = reader.skip(buffer, offset)
            ignored.append(element.name)
    if offset < len(buffer) and (text or data[body + offset :].strip()):
        raise FormatError(f"{name} goes on after the last element that its header counts")
    return _result(name, found, ignored)


def _result(name: str, found: dict[str, _Columns], ignored: list[str]) -> Result:
    vertex, face = found.get("vertex", {}), found.get("face", {})
    missing = [axis for axis in "xyz" if not isinstance(vertex.get(axis), np.ndarray)]
    if missing:
        raise FormatError(f"{name} has no vertices with x, y and z (missing: {', '.join(missing)})")
    polygons = next((face.get(key) for key in _CORNERS if key in face), None)
    if not isinstance(polygons, _Lists) or not len(polygons.sizes):
        raise FormatError(f"{name} has no faces: no element 'face' with a list 'vertex_indices'")
    return assemble(
        name,
        "PLY",
        Polygons(
            points=np.stack([np.asarray(vertex[axis]) for axis in "xyz"], axis=1),
            corners=polygons.flat if polygons.flat.dtype == np.int32 else polygons.flat.astype(np.int64),
            sizes=polygons.sizes,
            vertex_arrays=_vectors({k: v for k, v in vertex.items() if k not in ("x", "y", "z")}),
            face_arrays=_vectors(face),
            notes={"ignored": ignored} if ignored else {},
        ),
    )


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
        words = line.split()
        place = f"{name}, line {number}"
        match words:
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
                raise FormatError(f"{place}: '{line.strip()[:60]}' is not understood in the header of a PLY file")
    if order not in _ORDERS:
        raise FormatError(f"{name} is in the unknown PLY format '{order}'; known are {', '.join(_ORDERS)}")
    return order, elements, end.end()


def _numbers_as_bytes(name: str, data: bytes, body: int) -> NDArray[np.uint8]:
    """The body of a text file as the bytes of a binary one that has nothing but doubles."""
    lines = Lines(name, data)
    head = len(Lines(name, data[:body]))
    return lines.numbers(np.arange(head, len(lines))).values.view(np.uint8)


class _Reader:
    """Reads one element: rows of equal layout together, so that only lists of mixed lengths need a walk row by row."""

    def __init__(self, name: str, element: _Element, order: str, text: bool) -> None:
        self.name, self.element, self.order, self.text = name, element, order, text

    def read(self, buffer: NDArray[np.uint8], offset: int) -> tuple[_Columns, int]:
        """Columns by property, and where the next element begins."""
        size = self.element.size
        counts = next(self._walk(buffer, offset, min(size, 1)), (offset, ()))[1]
        layout = self._layout(counts)
        end = offset + size * layout.itemsize
        if end <= len(buffer):
            records = buffer[offset:end].view(layout) if end > offset else np.zeros(0, layout)
            if all(np.all(records[f"n{i}"] == n) for i, n in enumerate(counts)):
                self._check_corners(np.array([counts]))
                return self._columns([(_ALL, counts, records)]), end
        return self._mixed(buffer, offset)

    def skip(self, buffer: NDArray[np.uint8], offset: int) -> int:
        """Where the next element begins."""
        if all(item.count is None for item in self.element.properties):
            end = offset + self.element.size * self._layout(()).itemsize
            if end > len(buffer):
                self._truncated((len(buffer) - offset) // self._layout(()).itemsize)
            return end
        begin, counts = deque(self._walk(buffer, offset, self.element.size), maxlen=1)[0]
        return begin + self._layout(counts).itemsize

    def _mixed(self, buffer: NDArray[np.uint8], offset: int) -> tuple[_Columns, int]:
        lists = sum(item.count is not None for item in self.element.properties)
        steps = array("q")  # of each row where it begins and how long its lists are; Python's own numbers are heavy
        for begin, lengths in self._walk(buffer, offset, self.element.size):
            steps.append(begin)
            steps.extend(lengths)
        table = np.frombuffer(steps, np.int64).reshape(-1, 1 + lists)
        self._check_corners(table[:, 1:])
        begins, last = table[:, 0], table[-1]
        kinds, group = np.unique(table[:, 1:], axis=0, return_inverse=True)
        order, ends = np.argsort(group.ravel(), kind="stable"), np.cumsum(np.bincount(group.ravel()))
        groups = []
        for i, counts in enumerate(kinds.tolist()):
            rows = order[ends[i - 1] if i else 0 : ends[i]]
            layout = self._layout(tuple(counts))
            unit = 8 if self.text else 1
            units = buffer.view(np.uint64) if self.text else buffer
            raw = units[begins[rows][:, None] // unit + np.arange(layout.itemsize // unit)]
            groups.append((rows, tuple(counts), raw.view(layout).ravel()))
        return self._columns(groups), int(last[0]) + self._layout(tuple(last[1:].tolist())).itemsize

    def _check_corners(self, counts: Ints) -> None:
        """FormatError where a face has too few; told before its row, of a byte or so, takes many bytes here."""
        lists = [item.name for item in self.element.properties if item.count]
        corners = next((k for k, name in enumerate(lists) if name in _CORNERS), None)
        if self.element.name == "face" and corners is not None and counts.size and counts[:, corners].min() < 3:
            row = int(np.argmax(counts[:, corners] < 3))
            few = counts[row, corners]
            raise FormatError(f"{self.name}, face {row}: face has {few} corners; it needs at least 3")

    def _walk(self, buffer: NDArray[np.uint8], offset: int, size: int) -> Iterator[tuple[int, tuple[int, ...]]]:
        """Where each row begins and how long its lists are; each length says where the next one stands."""
        data = buffer.data
        for row in range(size):
            at, counts = offset, []
            for item in self.element.properties:
                if item.count:
                    length = struct.Struct(self.order + _STRUCT[self._type(item.count)])
                    if at + length.size > len(data):
                        self._truncated(row)
                    (value,) = length.unpack_from(data, at)
                    if not 0 <= value < 2**31 or value != int(value):
                        raise FormatError(f"{self.name}, {self.element.name} {row}: {value:g} is no length of a list")
                    counts.append(int(value))
                    at += length.size + counts[-1] * int(self._type(item.kind)[1])
                else:
                    at += int(self._type(item.kind)[1])
            if at > len(data):
                self._truncated(row)
            yield offset, tuple(counts)
            offset = at

    def _type(self, kind: str) -> str:
        return "f8" if self.text else kind

    def _layout(self, counts: tuple[int, ...]) -> np.dtype[Any]:
        """One row whose lists have these lengths: columns p0, p1, ... and lengths n0, n1, ..."""
        fields: list[Any] = []
        lengths = iter(enumerate(counts))
        for i, item in enumerate(self.element.properties):
            kind = self.order + self._type(item.kind)
            if item.count:
                k, count = next(lengths, (0, 0))
                fields += [(f"n{k}", self.order + self._type(item.count)), (f"p{i}", kind, (count,))]
            else:
                fields.append((f"p{i}", kind))
        return np.dtype(fields)

    def _columns(self, groups: list[tuple[Ints, tuple[int, ...], NDArray[Any]]]) -> _Columns:
        columns: _Columns = {}
        k = 0
        for i, item in enumerate(self.element.properties):
            parts = [(rows, records[f"p{i}"]) for rows, _, records in groups]
            if len(groups) == 1 and item.count is None:
                columns[item.name] = self._declared(item, parts[0][1])
            elif len(groups) == 1:
                length = groups[0][1][k] if groups[0][1] else 0
                sizes = np.full(self.element.size, length, dtype=np.int64)
                columns[item.name] = _Lists(self._declared(item, parts[0][1].ravel()), sizes)
                k += 1
            elif item.count is None:
                column = np.empty(self.element.size, dtype=parts[0][1].dtype)
                for rows, values in parts:
                    column[rows] = values
                columns[item.name] = self._declared(item, column)
            else:
                sizes = np.empty(self.element.size, dtype=np.int64)
                for rows, counts, _ in groups:
                    sizes[rows] = counts[k] if counts else 0
                begins = np.cumsum(sizes) - sizes
                flat = np.empty(int(sizes.sum()), dtype=parts[0][1].dtype)
                for rows, values in parts:
                    flat[ragged(begins[rows], sizes[rows])] = values.ravel()
                columns[item.name] = _Lists(self._declared(item, flat), sizes)
                k += 1
        return columns

    def _declared(self, item: _Property, values: NDArray[Any]) -> NDArray[Any]:
        """Values in native order and, from text, of the type that the header says."""
        kind = np.dtype(item.kind)
        if self.text and kind.kind in "iu":
            limits = np.iinfo(kind)
            if ((values != np.floor(values)) | (values < limits.min) | (values > limits.max)).any():
                raise FormatError(
                    f"{self.name}: property '{item.name}' of {self.element.name} is declared an integer of "
                    f"{kind.itemsize} bytes, but has values that are none"
                )
        with np.errstate(over="ignore"):  # too large for single precision is infinite
            return values.astype(kind, copy=False)

    def _truncated(self, row: int) -> None:
        raise FormatError(f"{self.name} ends after {row} of {self.element.size} rows of element '{self.element.name}'")
