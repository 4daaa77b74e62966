"""Headers of PLY files: the encoding, and the elements with their properties."""

import re
from dataclasses import dataclass, field

from geomhw.errors import FormatError

_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"}
_TYPES |= {"double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
_TYPES |= {"float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8"}
#: Byte order of each encoding.
ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Property:
    """A number, or a list of numbers, of each row of an element."""

    name: str
    kind: str
    count: str | None = None  # type of the length in front of a list


@dataclass(frozen=True)
class Element:
    """Rows of equal properties, such as the vertices."""

    name: str
    size: int
    properties: list[Property] = field(default_factory=list)


def read_header(name: str, data: bytes, remarks: list[str] | None = None) -> tuple[str, list[Element], int]:
    """Return the encoding, the elements, and where the body begins; add remarks on lines that are left out."""
    if not re.match(rb"(?i:ply)\s*[\r\n]", data):
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
                elements.append(Element(key, int(count)))
            case ["property", "list", count, kind, key] if elements and {count, kind} <= _TYPES.keys():
                elements[-1].properties.append(Property(key, _TYPES[kind], _TYPES[count]))
            case ["property", kind, key] if elements and kind in _TYPES:
                elements[-1].properties.append(Property(key, _TYPES[kind]))
            case [] | ["ply" | "PLY"] | ["comment" | "obj_info", *_]:
                pass
            case [key, *_]:
                shown = f"'{line.strip()[:60]}'"
                if elements or key in ("element", "property", "format"):
                    raise FormatError(f"{name}, line {number}: {shown} is not understood in the header of a PLY file")
                if remarks is not None:
                    remarks.append(f"left out line {number} of the header, {shown}")
    if order not in ORDERS:
        raise FormatError(f"{name} is in the unknown PLY format '{order}'; known are {', '.join(ORDERS)}")
    return order, elements, end.end()
