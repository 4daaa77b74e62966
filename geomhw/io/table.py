"""Rows of numbers as CSV."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from geomhw.io.atomic import replacing


def write_csv(path: str | Path, rows: Sequence[Mapping[str, float]]) -> None:
    """A table with a header line, numbers with all their digits; whole or not at all."""
    with replacing([path]) as (temporary,), temporary.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(rows[0])
        writer.writerows([_digits(value) for value in row.values()] for row in rows)


def _digits(value: float) -> str:
    """The shortest text that reads back as the same number, numpy's scalars too."""
    return repr(value.item() if isinstance(value, np.generic) else value)
