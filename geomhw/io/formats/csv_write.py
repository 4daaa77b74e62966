"""Writer of tables: a row for each vertex, or for each face where no array is on vertices, with place and arrays."""

import csv
import io
from typing import BinaryIO

import numpy as np

from geomhw.options import Location
from geomhw.results import Result, named_columns


def row_location(result: Result) -> Location:
    """Return what a row of the table stands for."""
    return "vertex" if any(item.location == "vertex" for item in result.fields) or not result.fields else "face"


def write_table(result: Result, stream: BinaryIO) -> None:
    """Write the number and place of each row, and its arrays: vectors as ``v_x v_y v_z``, others as ``v_0 v_1 ...``.

    Every number reads back to the same value; infinite ones are ``inf``.
    """
    location = row_location(result)
    places = result.mesh.vertices if location == "vertex" else result.mesh.face_centers
    columns = {location: np.arange(len(places)), **dict(zip("xyz", places.T, strict=True))}
    for item in result.fields:
        if item.location != location:
            continue
        for name, column in named_columns(item).items():
            columns[name if name not in columns else f"{name}_{len(columns)}"] = column
    text = io.TextIOWrapper(stream, encoding="utf-8", newline="", write_through=True)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*([repr(v) for v in column.tolist()] for column in columns.values()), strict=True))
    text.detach()
