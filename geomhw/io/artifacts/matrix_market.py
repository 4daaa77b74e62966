"""Reader of Matrix Market files [Boisvert, Pozo, Remington: The Matrix Market Exchange Formats, NISTIR 5935, 1996].

Hand-written because scipy.io.mmread (scipy 1.17) ends the process with a segmentation fault on a damaged number.
"""

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
#: Rows and columns are fewer, so that their product is an integer of 64 bits.
LARGEST = 2**31


def read_matrix_market(data: bytes) -> Any:
    """Return a sparse matrix (coo) or, of layout ``array``, an array; ValueError if the file is damaged."""
    head = _HEAD.match(data)
    if head is None:
        raise ValueError("it does not start as such a file does ('%%MatrixMarket matrix coordinate real general')")
    layout, field, symmetry = (word.decode().lower() for word in head.groups()[:3])
    end = data.find(b"\n", head.end()) % (len(data) + 1)  # -1 means the end of the file
    sizes = [int(word) for word in re.findall(rb"\S{1,20}", data[head.end() : end])]
    if len(sizes) != (3 if layout == "coordinate" else 2) or min(sizes) < 0 or max(sizes[:2]) >= LARGEST:
        raise ValueError("its line of sizes is not understood")
    return (_sparse if layout == "coordinate" else _dense)(data[end:], field, symmetry, *sizes)


def _table(body: bytes, rows: int, width: int, kind: type[Any]) -> NDArray[Any]:
    """The numbers of the body, (rows, width)."""
    values = parse_numbers(body, kind)
    if values is None or len(values) != rows * width:
        raise ValueError(f"{rows * width} numbers are promised, but that is not what follows")
    return values.reshape(rows, width)


def _values(columns: NDArray[Any], field: str) -> NDArray[Any]:
    """One value a row."""
    if field == "pattern":
        return np.ones(len(columns))
    return columns[:, 0] + 1j * columns[:, 1] if field == "complex" else columns[:, 0]


def _sparse(body: bytes, field: str, symmetry: str, rows: int, columns: int, stored: int) -> Any:
    from scipy.sparse import coo_array

    width = 2 + {"pattern": 0, "complex": 2}.get(field, 1)
    table = _table(body, stored, width, np.int64 if field in ("integer", "pattern") else np.float64)
    i, j = table[:, 0].astype(np.int64) - 1, table[:, 1].astype(np.int64) - 1
    if (table[:, :2] != np.floor(table[:, :2])).any() or ((i < 0) | (i >= rows) | (j < 0) | (j >= columns)).any():
        raise ValueError("an entry lies outside of the matrix")
    values = _values(table[:, 2:], field)
    if symmetry != "general":  # entries above the diagonal follow from those below
        off = i != j
        mirrored = -values if symmetry == "skew-symmetric" else values.conj() if symmetry == "hermitian" else values
        i, j, values = np.append(i, j[off]), np.append(j, i[off]), np.append(values, mirrored[off])
    return coo_array((values, (i, j)), shape=(rows, columns))


def _dense(body: bytes, field: str, symmetry: str, rows: int, columns: int) -> NDArray[Any]:
    """All entries, column by column."""
    if symmetry != "general" or field == "pattern":
        raise ValueError("of matrices with all their entries, only 'general' ones are read")
    table = _table(body, rows * columns, 2 if field == "complex" else 1, np.int64 if field == "integer" else np.float64)
    return _values(table, field).reshape(rows, columns, order="F")
