"""Tables of numbers and texts as CSV."""

import csv
import io
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing
from geomhw.io.file_content import read_bytes

_ROWS_AT_ONCE = 256
_INTEGER, _FLOAT, _TEXT = range(3)
_DIGITS = re.compile(r"[+-]?\d{1,18}")


def write_csv(path: str | Path, rows: Sequence[Mapping[str, float]]) -> None:
    """Write a table with a header line atomically; every number reads back to the same value.

    Parameters
    ----------
    path
        File to write.
    rows
        Numbers by column name; the first row gives the names and their order.
    """
    with replacing([path]) as (temporary,), temporary.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(rows[0])
        # numpy's own repr names the type.
        writer.writerows([repr(v.item() if isinstance(v, np.generic) else v) for v in row.values()] for row in rows)


def read_csv(path: str | Path) -> dict[str, NDArray[Any]]:
    """Read a table with column names in its first line.

    Returns
    -------
    Columns by name: int64 if all cells are integers, float64 if all are numbers or empty (NaN), else str objects.

    Raises
    ------
    FormatError
        If the file cannot be read, two columns have the same name, or a row has a cell too many or too few.

    Examples
    --------
    >>> import tempfile
    >>> from geomhw.io import read_csv, write_csv
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_csv(f"{folder}/t.csv", [{"step": 1, "energy": 0.5}, {"step": 2, "energy": 0.25}])
    ...     read_csv(f"{folder}/t.csv")["energy"].tolist()
    [0.5, 0.25]
    """
    path = Path(path)
    data = read_bytes(path)
    try:
        names = [name.strip() for name in next(_rows(data), [])]
        if not names:
            raise FormatError(f"{path.name} has no line with the names of columns")
        if twice := next((name for name, count in Counter(names).items() if count > 1), None):
            raise FormatError(f"{path.name} has two columns '{twice}'")
        kinds = [_INTEGER] * len(names)
        for cells in _columns(path.name, data, len(names)):
            kinds = [max(kind, _kind(column)) for kind, column in zip(kinds, cells, strict=True)]
        parts = [[_array([], kind)] for kind in kinds]
        # A second pass, now that types are known: the texts of all cells at once would take ten times the file.
        for cells in _columns(path.name, data, len(names)):
            for part, column, kind in zip(parts, cells, kinds, strict=True):
                part.append(_array(column, kind))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FormatError(f"{path.name} cannot be read as a table: {error}") from None
    return {name: np.concatenate(part) for name, part in zip(names, parts, strict=True)}


def _rows(data: bytes) -> Iterator[list[str]]:
    """Cells of the lines that are not empty."""
    stream = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline="")
    return (row for row in csv.reader(stream, strict=True) if row)


def _columns(name: str, data: bytes, width: int) -> Iterator[list[list[str]]]:
    """The cells after the header, column by column, ``_ROWS_AT_ONCE`` at a time."""
    rows = islice(_rows(data), 1, None)
    number = 0
    while block := list(islice(rows, _ROWS_AT_ONCE)):
        for row in block:
            if len(row) != width:
                raise FormatError(f"{name}: row {number} has {len(row)} cells where the header has {width}")
            number += 1
        yield [[cell.strip() for cell in cells] for cells in zip(*block, strict=True)]


def _kind(cells: Sequence[str]) -> int:
    if all(map(_DIGITS.fullmatch, cells)):
        return _INTEGER
    try:
        _array(cells, _FLOAT)
    except ValueError:
        return _TEXT
    return _FLOAT


def _array(cells: Sequence[str], kind: int) -> NDArray[Any]:
    if kind == _FLOAT:
        return np.array([float(cell or "nan") for cell in cells], dtype=np.float64)
    # Objects: in an array of type str every cell takes the length of the longest.
    return np.array(cells, dtype=np.int64 if kind == _INTEGER else object)
