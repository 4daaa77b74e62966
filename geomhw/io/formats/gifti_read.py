"""Reader of GIFTI files: surfaces, arrays on their vertices, and tables of labels, all of one file or in several.

Hand-written because nibabel trusts the sizes in a file, takes 0.4 s to import, and expands compressed arrays unlimited.
[GIFTI Surface Data Format, version 1.0]
"""

import binascii
import math
import re
import zlib
from dataclasses import dataclass, field
from typing import Any
from xml.etree.ElementTree import Element, ParseError

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.number_parsing import parse_array
from geomhw.io.formats.polygons import Polygons
from geomhw.io.formats.xml_tree import parse_xml
from geomhw.results import Field, Result

#: Types of the format, and those that programs write beyond it.
_TYPES = {"UINT8": "u1", "INT32": "i4", "FLOAT32": "f4"}
_TYPES |= {"INT8": "i1", "INT16": "i2", "UINT16": "u2", "UINT32": "u4", "INT64": "i8", "UINT64": "u8", "FLOAT64": "f8"}
_ENCODINGS = ("ASCII", "Base64Binary", "GZipBase64Binary")
#: Bytes that an array may have unpacked, for any array and for each packed byte; zlib does not exceed the ratio.
_LEAST_LIMIT, _MOST_RATIO = 1 << 20, 1100
#: A document type without declarations, which files of most programs have.
_DOCUMENT_TYPE = re.compile(rb"<!DOCTYPE\s+GIFTI(?:\s+SYSTEM\s+(?:\"[^\"<>]*\"|'[^'<>]*'))?\s*>")
#: First bytes of a ``.gii.gz``.
GZIP = b"\x1f\x8b"
_DAMAGE = (ParseError, ValueError, KeyError, binascii.Error, zlib.error, MemoryError)


@dataclass
class Gifti:
    """Contents of a GIFTI file: the surface, the arrays of vertices in order with names of labels, and remarks.

    transform: the spaces that the coordinates are in and can be brought to, and the matrix for it; None if it is the
    identity.
    """

    points: Floats | None = None
    triangles: Ints | None = None
    arrays: list[Field] = field(default_factory=list)
    transform: dict[str, Any] | None = None
    remarks: list[str] = field(default_factory=list)


def read_gii(name: str, data: bytes) -> Result:
    """Return the surface of a file with the arrays on its vertices; coordinates stay in the space of the file."""
    content = parse_gifti(name, data)
    if content.points is None or content.triangles is None:
        held = "arrays" if content.arrays else "nothing to draw"
        missing = "triangles" if content.triangles is None else "points"
        raise FormatError(f"{name} holds {held} and no {missing}; give the surface that they belong to")
    notes: dict[str, Any] = {}
    if content.transform:
        notes["coordinate_transform"] = content.transform
        content.remarks.append(
            f"the coordinates are those of {content.transform['from']}; the transform of the file to "
            f"{content.transform['to']} is not applied"
        )
    arrays = {item.name: np.asarray(item.values) for item in content.arrays}
    sizes = np.full(len(content.triangles), 3)
    polygons = Polygons(content.points, content.triangles.ravel(), sizes, arrays, notes=notes, remarks=content.remarks)
    return build_result(name, "GIFTI", polygons)


def parse_gifti(name: str, data: bytes) -> Gifti:
    """Return all that a file holds; FormatError if it is damaged or holds what is not read."""
    try:
        return _content(name, parse_xml(_without_document_type(_unzipped(data))))
    except _DAMAGE as error:
        raise FormatError(f"{name} is not a whole GIFTI file: {' '.join(str(error).split())[:150]}") from error


def _unzipped(data: bytes) -> bytes:
    """The document of a ``.gii.gz`` file, of bounded size."""
    if not data.startswith(GZIP):
        return data
    unpacker = zlib.decompressobj(wbits=31)
    limit = _LEAST_LIMIT + 100 * len(data)
    try:
        plain = unpacker.decompress(data, limit)
    except zlib.error as error:
        raise ValueError(f"the compressed file is damaged ({error})") from None
    if not unpacker.eof:
        raise ValueError("the compressed file ends early" if len(plain) < limit else f"it unpacks to {limit} bytes")
    return plain


def _without_document_type(data: bytes) -> bytes:
    begin = data.find(b"<GIFTI")
    return _DOCUMENT_TYPE.sub(b"", data[:begin], count=1) + data[begin:] if begin > 0 else data


def _content(name: str, root: Element) -> Gifti:
    if root.tag != "GIFTI":
        raise ValueError(f"its root element is {root.tag[:40]}")
    content = Gifti()
    elements = root.findall("DataArray")
    if (declared := root.get("NumberOfDataArrays", "")) not in ("", str(len(elements))):
        content.remarks.append(f"the file holds {len(elements)} arrays where its header says {declared[:20]}")
    labels = _labels(root)
    for number, element in enumerate(elements):
        intent = element.get("Intent", "").removeprefix("NIFTI_INTENT_")
        values = _decode(name, number, element)
        if intent == "POINTSET" and content.points is None:
            content.points = _rows_of_three(values, number)
            content.transform = _transform(element)
        elif intent == "TRIANGLE" and content.triangles is None:
            content.triangles = _rows_of_three(values, number)
            if values.dtype.kind == "f":
                raise ValueError(f"array {number} of triangles is of {values.dtype}")
        elif intent in ("POINTSET", "TRIANGLE"):
            raise FormatError(f"{name} holds two surfaces; give a file for each")
        elif intent == "NODE_INDEX":
            raise FormatError(f"{name} holds values at listed vertices only, which is not read; write it in full")
        else:
            values = values.reshape(len(values), -1)
            values = values[:, 0] if values.shape[1] == 1 else values
            key = _metadata(element).get("Name") or f"array_{number}"
            key = f"{key}_{number}" if any(key == other.name for other in content.arrays) else key
            content.arrays.append(Field(key, "vertex", values, labels if intent == "LABEL" and labels else None))
    return content


def _rows_of_three(values: NDArray[Any], number: int) -> NDArray[Any]:
    if values.ndim != 2 or values.shape[1] != 3:
        raise ValueError(f"array {number} has the shape {values.shape}, not rows of three")
    return values


def _metadata(element: Element) -> dict[str, str]:
    pairs = ((entry.findtext("Name"), entry.findtext("Value")) for entry in element.findall("MetaData/MD"))
    return {key.strip(): (value or "").strip() for key, value in pairs if key}


def _labels(root: Element) -> dict[int, str]:
    """Names of labels by key; some programs write Index for Key."""
    labels = root.findall("LabelTable/Label")
    return {int(label.get("Key", label.get("Index", "0"))): (label.text or "").strip() for label in labels}


def _transform(element: Element) -> dict[str, Any] | None:
    """The first transform of the coordinates that changes them."""
    for system in element.findall("CoordinateSystemTransformMatrix"):
        numbers = (system.findtext("MatrixData") or "").split()
        matrix = np.array([float(number) for number in numbers])
        if len(matrix) != 16:
            raise ValueError(f"a transform of coordinates has {len(matrix)} numbers, not 16")
        spaces = [(system.findtext(tag) or "").strip() for tag in ("DataSpace", "TransformedSpace")]
        start, end = (space.removeprefix("NIFTI_XFORM_").lower() or "unknown" for space in spaces)
        if np.isfinite(matrix).all() and not np.array_equal(matrix.reshape(4, 4), np.eye(4)):
            return {"from": f"{start} space", "to": f"{end} space", "matrix": matrix.reshape(4, 4).tolist()}
    return None


def _decode(name: str, number: int, element: Element) -> NDArray[Any]:
    """One array, in the shape that it declares."""
    word = element.get("DataType", "").removeprefix("NIFTI_TYPE_")
    if word not in _TYPES:
        raise ValueError(f"array {number} is of type {word[:40] or 'unknown'}")
    order = {"LittleEndian": "<", "BigEndian": ">"}[element.get("Endian", "LittleEndian")]
    kind = np.dtype(order + _TYPES[word])
    shape = [int(element.get(f"Dim{k}", "")) for k in range(int(element.get("Dimensionality", "1")[:3]))]
    if not 1 <= len(shape) <= 6 or min(shape) < 0 or 0 in shape[1:]:
        raise ValueError(f"array {number} has the shape {shape}")
    encoding = element.get("Encoding", "")
    if encoding not in _ENCODINGS:
        raise FormatError(
            f"{name}: array {number} is in the encoding {encoding[:40]}; known are {', '.join(_ENCODINGS)}"
        )
    text = (element.findtext("Data") or "").encode()
    if encoding == "ASCII":
        values = parse_array(text, kind.newbyteorder("="))
        found = values.nbytes
    else:
        packed = _from_base64(text)
        size = math.prod(shape) * kind.itemsize
        if size > _LEAST_LIMIT + _MOST_RATIO * len(packed):
            raise ValueError(f"array {number} of {len(packed)} bytes says that it unpacks to {size}")
        plain = packed if encoding == "Base64Binary" else _inflated(packed, size)
        found = len(plain)
        values = np.frombuffer(plain[: found - found % kind.itemsize], dtype=kind)
    if found != math.prod(shape) * kind.itemsize:
        raise ValueError(f"array {number} has {found / kind.itemsize:.8g} numbers where it says {math.prod(shape)}")
    order_of_rows = "F" if element.get("ArrayIndexingOrder") == "ColumnMajorOrder" else "C"
    return values.reshape(shape, order=order_of_rows)  # type: ignore[call-overload]


def _from_base64(text: bytes) -> bytes:
    text = b"".join(text.split())
    if not re.fullmatch(rb"[A-Za-z0-9+/]*={0,2}", text):
        raise ValueError("base64 text holds a character that base64 does not have")
    return binascii.a2b_base64(text)


def _inflated(packed: bytes, size: int) -> bytes:
    """Unpacked bytes, at most one more than the expected number."""
    unpacker = zlib.decompressobj(wbits=47)  # of zlib, or of gzip
    return unpacker.decompress(packed, size + 1)
