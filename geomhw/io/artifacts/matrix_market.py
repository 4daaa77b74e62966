"""Matrix Market files [Boisvert, Pozo, Remington: The Matrix Market Exchange Formats, NISTIR 5935, 1996]."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.io.formats.number_parsing import parse_numbers

_HEAD = re.compile(
    rb"%%MatrixMarket[ \t]+matrix[ \t]+(coordinate|array)[ \t]+(real|double|integer|complex|pattern)[ \t]+"
    rb"(general|symmetric|skew-symmetric|hermitian)[ \t\r]*\n((?:[ \t]*(?:%[^\n]*)?\n)*)",
    re.IGNORECASE,
)
#: Rows and columns are fewer, so that their product is a number of 64 bits.
_MOST = 2**31


def read_market(data: bytes) -> Any:
    """A sparse matrix (coo), or an array; ValueError where the file is not whole."""
    head = _HEAD.match(data)
    if head is None:
        raise ValueError("it does not start as such a file does ('%%MatrixMarket matrix coordinate real general')")
    layout, field, symmetry = (word.decode().lower() for word in head.groups()[:3])
    end = data.find(b"\n", head.end())
    sizes = [int(word) for word in re.findall(rb"\S{1,20}", data[head.end() : end if end >= 0 else None])]
    if len(sizes) != (3 if layout == "coordinate" else 2) or min(sizes) < 0 or max(sizes[:2]) >= _MOST:
        raise ValueError("its line of sizes is not understood")
    body = data[end:] if end >= 0 else b""
    if layout == "coordinate":
        return _sparse(body, field, symmetry, *sizes)
    return _dense(body, field, symmetry, *sizes)


def _numbers(body: bytes, count: int, kind: type[Any]) -> NDArray[Any]:
    values = parse_numbers(body, kind)
    if values is None or len(values) != count:
        raise ValueError(f"{count} numbers are promised, but that is not what follows")
    return values


def _values(columns: NDArray[Any], field: str) -> NDArray[Any]:
    """One value a row."""
    if field == "pattern":
        return np.ones(len(columns))
    return columns[:, 0] + 1j * columns[:, 1] if field == "complex" else columns[:, 0]


def _sparse(body: bytes, field: str, symmetry: str, rows: int, columns: int, stored: int) -> Any:
    from scipy.sparse import coo_array

    width = 2 + {"pattern": 0, "complex": 2}.get(field, 1)
    kind = np.int64 if field in ("integer", "pattern") else np.float64
    table = _numbers(body, stored * width, kind).reshape(stored, width)
    i, j = table[:, 0].astype(np.int64) - 1, table[:, 1].astype(np.int64) - 1
    if (table[:, :2] != np.floor(table[:, :2])).any() or ((i < 0) | (i >= rows) | (j < 0) | (j >= columns)).any():
        raise ValueError("an entry lies outside of the matrix")
    values = _values(table[:, 2:], field)
    if symmetry != "general":
        off = i != j
        mirrored = _mirrored(values[off], symmetry)
        i, j, values = np.append(i, j[off]), np.append(j, i[off]), np.append(values, mirrored)
    return coo_array((values, (i, j)), shape=(rows, columns))


def _mirrored(values: NDArray[Any], symmetry: str) -> NDArray[Any]:
    """The entry at (j, i) for that at (i, j)."""
    if symmetry == "hermitian":
        return values.conj()
    return -values if symmetry == "skew-symmetric" else values


def _dense(body: bytes, field: str, symmetry: str, rows: int, columns: int) -> NDArray[Any]:
    """All entries column by column."""
    if symmetry != "general" or field == "pattern":
        raise ValueError("of matrices with all their entries, only 'general' ones are read")
    parts = 2 if field == "complex" else 1
    kind = np.int64 if field == "integer" else np.float64
    table = _numbers(body, rows * columns * parts, kind).reshape(-1, parts)
    return _values(table, field).reshape(rows, columns, order="F")
