"""Reader of VTK's XML files ``.vtp`` and ``.vtu``: arrays as text, inline base64 or appended, compressed or not.

Hand-written because VTK reads the index 1.5 as 1, and meshio reads no ``.vtp``.
"""

import binascii
import lzma
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.formats.number_parsing import parse_array
from geomhw.io.formats.vtk_cells import LINE, POLYGON, STRIP, VERTEX, Dataset, cells_from_offsets, joined, surface
from geomhw.io.formats.xml_tree import parse_xml
from geomhw.results import Cloud, Field, Result
from geomhw.wording import counted

#: Bytes that the highest level of LZMA takes to unpack; a file may ask for gigabytes.
_LZMA_MEMORY = 70 << 20
#: Bytes that an array may have unpacked, for any array and for each packed byte; zlib does not exceed the ratio.
_LEAST_LIMIT, _MOST_RATIO = 1 << 20, 1100
_DAMAGE = (ElementTree.ParseError, ValueError, KeyError, IndexError, EOFError, zlib.error, lzma.LZMAError, MemoryError)
#: numpy's names of VTK's types of numbers.
TYPES = {f"{word}{8 * size}": f"{kind}{size}" for word, kind in (("Int", "i"), ("UInt", "u")) for size in (1, 2, 4, 8)}
TYPES |= {"Float32": "f4", "Float64": "f8"}
_LAST = b"</VTKFile>"
_POLYDATA = (("Verts", VERTEX), ("Lines", LINE), ("Polys", POLYGON), ("Strips", STRIP))


class _Size(Exception):
    """The size of an array is not the expected one."""


def _unzip(packed: bytes, size: int) -> bytes:
    return zlib.decompressobj().decompress(packed, size)


def _unpack_lzma(packed: bytes, size: int) -> bytes:
    return lzma.LZMADecompressor(memlimit=_LZMA_MEMORY).decompress(packed, size)


def _unpack_lz4(packed: bytes, size: int) -> bytes:
    from geomhw.io.formats.lz4_block import unpack_lz4

    return unpack_lz4(packed, size)


#: Functions that return at most ``size`` bytes of a packed block.
_UNPACKERS: dict[str | None, Callable[[bytes, int], bytes] | None] = {
    None: None,
    "vtkZLibDataCompressor": _unzip,
    "vtkLZMADataCompressor": _unpack_lzma,
    "vtkLZ4DataCompressor": _unpack_lz4,
}


def read_vtp(name: str, data: bytes) -> Result:
    """Return the polygons of polydata with their arrays."""
    return surface(name, "VTP", _read(name, data, "PolyData"))


def read_vtu(name: str, data: bytes) -> Result:
    """Return the triangles, quads and polygons of an unstructured grid with their arrays."""
    return surface(name, "VTU", _read(name, data, "UnstructuredGrid"))


def read_vtp_cloud(name: str, data: bytes) -> Cloud:
    """Return the points of polydata with their arrays of any width, in the order of its polylines if it has any.

    Other cells are ignored.
    """
    dataset = _read(name, data, "PolyData")
    points = np.zeros((0, 3)) if dataset.points is None else dataset.points
    if points.shape[1:] != (3,):
        raise FormatError(f"{name}: points have three coordinates; the array has the shape {points.shape}")
    for key, values in dataset.vertex_arrays.items():
        if len(values) != len(points):
            raise FormatError(f"{name}: array '{key}' has {len(values)} values for {counted(len(points), 'point')}")
    lines = [cells for cells in dataset.cells if len(cells.types) and (cells.types == LINE).all()]
    order, ends = np.arange(len(points)), None
    if lines:
        order = np.concatenate([cells.corners for cells in lines])
        if order.min(initial=0) < 0 or order.max(initial=0) >= len(points):
            raise FormatError(f"{name}: a line names a point that does not exist; there are {len(points)}")
        ends = np.append(0, np.cumsum(np.concatenate([cells.sizes for cells in lines])))
    on_points = [Field(key, "vertex", values[order]) for key, values in dataset.vertex_arrays.items()]
    fields = [*on_points, *(Field(key, "mesh", values) for key, values in dataset.mesh_arrays.items())]
    return Cloud(points[order], fields, ends)


def _read(name: str, data: bytes, kind: str) -> Dataset:
    remarks: list[str] = []
    end = data.rfind(_LAST) + len(_LAST)
    if surplus := len(data[end:].strip()) if end >= len(_LAST) else 0:
        remarks.append(f"left out {counted(surplus, 'byte')} after the end of the XML document")
        data = data[:end]
    try:
        root, appended, encoding = _parse(data.lstrip())
        if root.get("type") != kind:
            raise FormatError(f"{name} holds VTK {root.get('type', 'data of no type')}, not {kind}")
        arrays = _Arrays(name, root, appended, encoding)
        grid = root.find(kind)
        grid = root if grid is None else grid
        pieces = [piece for piece in grid.iter("Piece") if piece.get("NumberOfPoints", "0") != "0"]
        if not pieces:
            raise FormatError(f"{name} holds no piece with points")
        dataset = joined(name, [_dataset(piece, arrays, kind) for piece in pieces])
        dataset.mesh_arrays = arrays.by_name(grid.find("FieldData"))
        dataset.remarks = [*remarks, *dataset.remarks]
        return dataset
    except _DAMAGE as error:
        reason = " ".join(str(error).split())[:120]
        raise FormatError(f"{name} is not a whole VTK XML file: {reason}") from error


def _parse(data: bytes) -> tuple[Element, bytes, str]:
    """The tree, and the appended block, which may be raw bytes that no XML parser takes, with its encoding."""
    if b"<AppendedData" not in data:
        return parse_xml(data), b"", ""
    root, begin, encoding = parse_head(data)
    return root, data[begin : data.rfind(b"</AppendedData")], encoding


def parse_head(data: bytes) -> tuple[Element, int, str]:
    """Return the tree before the appended block, the offset at which that starts, and its encoding.

    data: a file with an appended block, at least up to its start.
    """
    begin = data.index(b"<AppendedData")
    tag_end = data.index(b">", begin)
    encoding = re.search(rb'encoding\s*=\s*"(\w+)"', data[begin:tag_end])
    start = data.index(b"_", tag_end) + 1
    return parse_xml(data[:begin] + _LAST), start, encoding[1].decode() if encoding else "base64"


def _dataset(piece: Element, arrays: "_Arrays", kind: str) -> Dataset:
    coordinates = piece.find("Points/DataArray")
    n = int(piece.get("NumberOfPoints", "0"))
    points = None if coordinates is None else arrays.decode(coordinates, n)
    if points is not None and len(points) != n:
        raise FormatError(f"{arrays.name}: a piece has {counted(n, 'point')}, but coordinates of {len(points)}")
    cells = []
    for tag, cell_type in _POLYDATA if kind == "PolyData" else (("Cells", None),):
        parts = arrays.by_name(piece.find(tag))
        if len(parts.get("offsets", ())):
            types = parts["types"] if cell_type is None else cell_type
            cells.append(cells_from_offsets(arrays.name, parts["connectivity"], parts["offsets"], types))
    return Dataset(
        points=points,
        cells=cells,
        vertex_arrays=arrays.by_name(piece.find("PointData"), n),
        cell_arrays=arrays.by_name(piece.find("CellData"), sum(len(part.sizes) for part in cells)),
    )


@dataclass(frozen=True)
class _Encoded:
    """Encoded bytes, taken from the front; base64 text is decoded as it is taken."""

    data: memoryview
    base64: bool

    def take(self, count: int) -> tuple[bytes, "_Encoded"]:
        """Some bytes, and the rest after the encoded block that ends with them."""
        width = -(-count // 3) * 4 if self.base64 else count
        coded = self.data[:width]
        if len(coded) < width:
            raise ValueError("an array ends early")
        plain = binascii.a2b_base64(coded) if self.base64 else bytes(coded)
        return plain[:count], _Encoded(self.data[width:], self.base64)

    def ends_after(self, count: int) -> bool:
        """Whether the first bytes are a base64 block of their own, closed by its padding."""
        return self.base64 and bytes(self.data[-(-count // 3) * 4 - 1 :][:1]) == b"="


class _Arrays:
    """Decodes the DataArray elements of one file."""

    def __init__(self, name: str, root: Element, appended: bytes, encoding: str) -> None:
        self.name = name
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.head = np.dtype(self.order + TYPES[root.get("header_type", "UInt32")])
        compressor = root.get("compressor")
        if compressor not in _UNPACKERS and any(e.get("format") != "ascii" for e in root.iter("DataArray")):
            raise FormatError(f"{name} is compressed with {compressor}, which is not read; use zlib, LZ4, LZMA or none")
        self.unpacker = _UNPACKERS.get(compressor)
        self.appended, self.encoding = memoryview(appended), encoding

    def by_name(self, parent: Element | None, rows: int | None = None) -> dict[str, NDArray[Any]]:
        """The numeric arrays under an element, of a number of rows where it is known."""
        found = [] if parent is None else [child for child in parent.iter("DataArray") if child.get("type") in TYPES]
        return {child.get("Name", f"array {i}"): self.decode(child, rows) for i, child in enumerate(found)}

    def decode(self, element: Element, rows: int | None = None) -> NDArray[Any]:
        """One array, (rows,) or (rows, components)."""
        label = "an array without a name" if element.get("Name") is None else f"array '{element.get('Name')}'"
        kind = np.dtype(self.order + TYPES[element.get("type", "")])
        width = int(element.get("NumberOfComponents") or 1)
        form, text = element.get("format", "ascii"), (element.text or "").strip().encode()
        if form == "ascii":
            try:
                values = parse_array(text, kind.newbyteorder("="))
            except ValueError as error:
                raise ValueError(f"{label}: {error}") from None
        else:
            coded = _Encoded(memoryview(text), True)
            if form == "appended":
                coded = _Encoded(self.appended[int(element.get("offset", "0")) :], self.encoding == "base64")
            size = None if rows is None else rows * width * kind.itemsize
            try:
                plain = self._unpack(coded, size) if self.unpacker else self._plain(coded)
            except _Size as error:
                found = int(str(error)) / max(width * kind.itemsize, 1)
                raise FormatError(f"{self.name}: {label} has {found:.8g} rows where the file has {rows}") from None
            values = np.frombuffer(plain, dtype=kind)
        return values.reshape(-1, width) if width > 1 else values

    def _plain(self, coded: _Encoded) -> bytes:
        """The length, then the bytes; in base64 the two are one block, or each is its own."""
        size = self.head.itemsize
        head, rest = coded.take(size)
        (count,) = np.frombuffer(head, dtype=self.head).tolist()
        if not coded.base64 or coded.ends_after(size):
            return rest.take(count)[0]
        return coded.take(size + count)[0][size:]

    def _unpack(self, coded: _Encoded, expected: int | None) -> bytes:
        """Number of blocks, their size, that of the last, and the packed size of each; then the blocks.

        expected: size of the array, if it is known.
        """
        size = self.head.itemsize
        (count,) = np.frombuffer(coded.take(size)[0], dtype=self.head).tolist()
        head, rest = coded.take(size * (3 + count))
        _, full, last, *lengths = np.frombuffer(head, dtype=self.head).tolist()
        total = full * max(count - 1, 0) + (last or full) * (count > 0)
        if expected is not None and total != expected:
            raise _Size(total)
        if total > _LEAST_LIMIT + _MOST_RATIO * sum(lengths):
            raise ValueError(f"an array of {sum(lengths)} bytes unpacks to {total} bytes")
        body, _ = rest.take(sum(lengths))
        ends = accumulate([0, *lengths])
        sizes = ([full] * (count - 1) + [last or full])[:count]
        return b"".join(self._block(body[a:b], size) for (a, b), size in zip(pairwise(ends), sizes, strict=True))

    def _block(self, packed: bytes, size: int) -> bytes:
        """One block, unpacked no further than its declared size."""
        assert self.unpacker is not None
        plain = self.unpacker(packed, size + 1)
        if len(plain) != size:
            raise ValueError(f"a compressed block does not hold the {size} bytes that its header says")
        return plain
