"""Rows of numbers as CSV."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing
from geomhw.io.content import content


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
    try:
        text = content(path).decode("utf-8-sig")
        lines = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise FormatError(f"{path.name} cannot be read as a table: {error}") from None
    names, rows = [name.strip() for name in lines[0]] if lines else [], lines[1:]
    if not names:
        raise FormatError(f"{path.name} has no line with the names of columns")
    if twice := [name for i, name in enumerate(names) if name in names[:i]]:
        raise FormatError(f"{path.name} has two columns '{twice[0]}'")
    for number, row in enumerate(rows):
        if len(row) != len(names):
            raise FormatError(f"{path.name}: row {number} has {len(row)} cells where the header has {len(names)}")
    columns = zip(*rows, strict=True) if rows else [()] * len(names)
    return {name: _column([cell.strip() for cell in cells]) for name, cells in zip(names, columns, strict=True)}


def _column(cells: Sequence[str]) -> NDArray[Any]:
    if all(re.fullmatch(r"[+-]?\d{1,18}", cell) for cell in cells):
        return np.array(cells, dtype=np.int64)
    try:
        return np.array([float(cell or "nan") for cell in cells])
    except ValueError:
        return np.array(cells)
