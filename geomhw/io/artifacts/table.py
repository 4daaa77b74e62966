"""Rows of numbers as CSV."""

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
from geomhw.io.file_bytes import content

_ROWS_AT_ONCE = 256
_WHOLE, _NUMBER, _TEXT = range(3)
_INTEGER = re.compile(r"[+-]?\d{1,18}")


def write_csv(path: str | Path, rows: Sequence[Mapping[str, float]]) -> None:
    """A table with a header line, numbers with all their digits; whole or not at all."""
    with replacing([path]) as (temporary,), temporary.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(rows[0])
        writer.writerows([_digits(value) for value in row.values()] for row in rows)


def _digits(value: float) -> str:
    """The shortest text that reads back as the same number, numpy's scalars too."""
    return repr(value.item() if isinstance(value, np.generic) else value)


def read_csv(path: str | Path) -> dict[str, NDArray[Any]]:
    """Columns by the names in the first line: whole numbers, numbers (an empty cell is NaN), or else texts."""
    path = Path(path)
    data = content(path)
    try:
        names = [name.strip() for name in next(_rows(data), [])]
        if not names:
            raise FormatError(f"{path.name} has no line with the names of columns")
        if twice := next((name for name, count in Counter(names).items() if count > 1), None):
            raise FormatError(f"{path.name} has two columns '{twice}'")
        kinds = [_WHOLE] * len(names)
        for block in _blocks(path.name, data, len(names)):
            kinds = [max(kind, _kind(cells)) for kind, cells in zip(kinds, block, strict=True)]
        parts = [[_array([], kind)] for kind in kinds]
        # Read again now that kinds are known: texts of all cells at once would take ten times the file and more.
        for block in _blocks(path.name, data, len(names)):
            for column, cells, kind in zip(parts, block, kinds, strict=True):
                column.append(_array(cells, kind))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FormatError(f"{path.name} cannot be read as a table: {error}") from None
    return {name: np.concatenate(column) for name, column in zip(names, parts, strict=True)}


def _rows(data: bytes) -> Iterator[list[str]]:
    """Lines that are not empty, cell by cell."""
    stream = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline="")
    return (row for row in csv.reader(stream, strict=True) if row)


def _blocks(name: str, data: bytes, width: int) -> Iterator[list[list[str]]]:
    """The cells after the header, column by column, some rows at a time."""
    rows = _rows(data)
    next(rows)
    number = 0
    while block := list(islice(rows, _ROWS_AT_ONCE)):
        for row in block:
            if len(row) != width:
                raise FormatError(f"{name}: row {number} has {len(row)} cells where the header has {width}")
            number += 1
        yield [[cell.strip() for cell in cells] for cells in zip(*block, strict=True)]


def _kind(cells: Sequence[str]) -> int:
    if all(map(_INTEGER.fullmatch, cells)):
        return _WHOLE
    try:
        _array(cells, _NUMBER)
    except ValueError:
        return _TEXT
    return _NUMBER


def _array(cells: Sequence[str], kind: int) -> NDArray[Any]:
    if kind == _NUMBER:
        return np.array([float(cell or "nan") for cell in cells], dtype=np.float64)
    # Objects, for an array of text gives every cell the length of the longest.
    return np.array(cells, dtype=np.int64 if kind == _WHOLE else object)
