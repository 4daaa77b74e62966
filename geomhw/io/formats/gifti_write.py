"""Writer of GIFTI files: the surface, its arrays on vertices, or both, in the three types of the format.

Hand-written because nibabel takes longer to import than the file to write. [GIFTI Surface Data Format, version 1.0]
"""

import binascii
import colorsys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FieldError
from geomhw.io.formats.xml_tree import UNWRITABLE
from geomhw.results import Field, Result, answer_rank, named_columns

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE GIFTI SYSTEM "http://gifti.projects.nitrc.org/gifti.dtd">\n'
_TYPES = {"u1": "UINT8", "i4": "INT32", "f4": "FLOAT32"}
#: Largest integer up to which single precision holds all integers.
_LARGEST = 1 << 24
#: Bytes coded in base64 at a time, a multiple of three.
_CODED = 3 << 16
#: Name by which Workbench knows vertices without a label.
UNASSIGNED = "???"
#: What Workbench writes where a distance is not reached.
NOT_REACHED = -1.0


def write_surface(result: Result, stream: BinaryIO) -> None:
    """Write the surface only."""
    _write(stream, _surface(result))


def write_gii(result: Result, stream: BinaryIO) -> None:
    """Write the surface and the arrays of vertices."""
    _write(stream, [*_surface(result), *_maps(result)])


def write_func(result: Result, stream: BinaryIO) -> None:
    """Write the arrays of vertices, one for each component, with the answer of the method first."""
    maps = _maps(result)
    if not maps:
        raise FieldError("there is no array on vertices to write to a GIFTI file")
    _write(stream, maps)


def write_label(result: Result, stream: BinaryIO) -> None:
    """Write the arrays of vertices that are integers, as labels with a table of their names."""
    fields = [item for item in _on_vertices(result) if _is_label(np.asarray(item.values))]
    if not fields:
        raise FieldError("there is no array of integers on vertices to write as labels")
    used = {int(key) for item in fields for key in np.unique(item.values)}
    names = {0: UNASSIGNED} | {key: f"label_{key}" if key != -1 else UNASSIGNED for key in used}
    for item in fields:
        names |= item.labels or {}
    arrays = [(item.name, "LABEL", np.asarray(item.values).astype("<i4")) for item in fields]
    _write(stream, arrays, dict(sorted(names.items())))


def remarks_on(result: Result, path: Path) -> list[str]:
    """Return sentences on what a GIFTI file does not hold of a result, or holds in another form."""
    kind = ending(path)
    if kind == ".surf.gii":
        return []
    vertices = _on_vertices(result)
    written = [item for item in vertices if kind != ".label.gii" or _is_label(np.asarray(item.values))]
    left = [item for item in result.fields if not any(item is other for other in written)]
    names = ", ".join(f"{item.name} (per {item.location})" for item in left)
    remarks = [f"{path.name} is without {names}, for it holds {_CONTENT[kind]}"] if left else []
    if reached := [item.name for item in written if _lacks_infinity(np.asarray(item.values))]:
        remarks.append(f"{path.name} has -1 where {', '.join(reached)} is infinite, as Workbench does")
    if kind != ".label.gii" and any(np.asarray(item.values).dtype == np.float64 for item in written):
        remarks.append(f"{path.name} is in single precision, as GIFTI is")
    return remarks


_CONTENT = {".gii": "arrays on vertices", ".func.gii": "arrays on vertices", ".label.gii": "integers on vertices"}


def ending(path: Path) -> str:
    """Return what decides on the contents of a GIFTI file: ``.surf.gii``, ``.func.gii``, ``.label.gii`` or ``.gii``."""
    name = path.name.lower()
    if name.endswith((".func.gii", ".shape.gii")):
        return ".func.gii"
    return next((end for end in (".surf.gii", ".label.gii") if name.endswith(end)), ".gii")


_Map = tuple[str, str, NDArray[Any]]


def _surface(result: Result) -> list[_Map]:
    mesh = result.mesh
    with np.errstate(over="ignore", under="ignore"):
        points = mesh.vertices.astype("<f4")
    return [("", "POINTSET", points), ("", "TRIANGLE", mesh.faces.astype("<i4"))]


def _on_vertices(result: Result) -> list[Field]:
    fields = [item for item in result.fields if item.location == "vertex"]
    return sorted(fields, key=lambda item: answer_rank(item.name))


def _maps(result: Result) -> list[_Map]:
    """Every component of the arrays of vertices; vectors ``v`` become ``v_x v_y v_z``, others ``v_0 v_1 ...``."""
    maps = []
    for item in _on_vertices(result):
        maps += [(name, "SHAPE", _storable(column)) for name, column in named_columns(item).items()]
    return maps


def _storable(column: NDArray[Any]) -> NDArray[Any]:
    """A column in single precision, or as integers if it holds larger ones."""
    if column.dtype.kind in "iu" and _LARGEST < np.abs(column).max(initial=0) < 1 << 31:
        return column.astype("<i4")
    if _lacks_infinity(column):
        column = np.where(np.isposinf(column), NOT_REACHED, column)
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return column.astype("<f4")


def _lacks_infinity(values: NDArray[Any]) -> bool:
    """Whether infinite values are written as -1: those of an array without negative ones, such as a distance."""
    return bool(values.dtype.kind == "f" and np.isposinf(values).any() and not (values < 0).any())


def _is_label(values: NDArray[Any]) -> bool:
    limits = np.iinfo(np.int32)
    within = values.ndim == 1 and values.dtype.kind in "iub" and len(values)
    return bool(within and limits.min <= values.min() <= values.max() <= limits.max)


def _write(stream: BinaryIO, maps: Iterable[_Map], labels: dict[int, str] | None = None) -> None:
    maps = list(maps)
    head = f'{_HEAD}<GIFTI Version="1.0" NumberOfDataArrays="{len(maps)}">\n<MetaData/>\n'
    table = "".join(f"<Label {_color(key, name)}>{_text(name)}</Label>\n" for key, name in (labels or {}).items())
    stream.write(f"{head}<LabelTable>\n{table}</LabelTable>\n".encode())
    for item in maps:
        stream.writelines(_data_array(*item))
    stream.write(b"</GIFTI>\n")


def _color(key: int, name: str) -> str:
    """The attributes of a label; hues follow each other by the golden ratio, and what has no label is transparent."""
    red, green, blue = colorsys.hsv_to_rgb(key * 0.618034 % 1, 0.65, 0.95)
    alpha = int(name != UNASSIGNED)
    return f'Key="{key}" Red="{red:.6f}" Green="{green:.6f}" Blue="{blue:.6f}" Alpha="{alpha}"'


def _data_array(name: str, intent: str, values: NDArray[Any]) -> Iterator[bytes]:
    shape = " ".join(f'Dim{k}="{size}"' for k, size in enumerate(values.shape))
    kind = _TYPES[values.dtype.str[1:]]
    yield (
        f'<DataArray Intent="NIFTI_INTENT_{intent}" DataType="NIFTI_TYPE_{kind}" ArrayIndexingOrder="RowMajorOrder" '
        f'Dimensionality="{values.ndim}" {shape} Encoding="Base64Binary" Endian="LittleEndian" ExternalFileName="" '
        'ExternalFileOffset="">\n'
    ).encode()
    named = f"<MD><Name>Name</Name><Value>{_text(name)}</Value></MD>" if name else ""
    yield f"<MetaData>{named}</MetaData>\n".encode()
    if intent == "POINTSET":
        space, unit = "NIFTI_XFORM_UNKNOWN", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"
        spaces = f"<DataSpace>{space}</DataSpace><TransformedSpace>{space}</TransformedSpace>"
        matrix = f"{spaces}<MatrixData>{unit}</MatrixData>"
        yield f"<CoordinateSystemTransformMatrix>{matrix}</CoordinateSystemTransformMatrix>\n".encode()
    raw = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    yield b"<Data>"
    for begin in range(0, raw.nbytes, _CODED):
        yield binascii.b2a_base64(raw[begin : begin + _CODED].data, newline=False)
    yield b"</Data>\n</DataArray>\n"


def _text(name: str) -> str:
    """A name as the text of an element, without characters that XML cannot hold."""
    return UNWRITABLE.sub("_", name).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
