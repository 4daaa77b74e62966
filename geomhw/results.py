"""What a method hands over: named fields on a mesh, and a report; or named fields on points that have no faces."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location


@dataclass(frozen=True)
class Field:
    """An array on a mesh: one row per vertex, per face, or (``mesh``) values that belong to the whole, such as dt."""

    name: str
    location: Location
    values: Floats | Ints


@dataclass(frozen=True)
class Result:
    """A mesh with the fields that a method computed on it, and a report of plain JSON values."""

    mesh: TriangleMesh
    fields: Sequence[Field] = ()
    report: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rows = {"vertex": self.mesh.n_vertices, "face": self.mesh.n_faces}
        for item in self.fields:
            expected = rows.get(item.location)
            if expected is not None and len(item.values) != expected:
                raise FieldError(
                    f"field '{item.name}' has {len(item.values)} rows where the mesh has "
                    f"{expected} {'vertices' if item.location == 'vertex' else 'faces'}"
                )

    def __getitem__(self, name: str) -> Floats | Ints:
        """Values of the field of that name; KeyError says which there are."""
        return _named(self.fields, name)


@dataclass(frozen=True)
class Cloud:
    """Points, (k, 3), with fields on them, one row a point (``vertex``), or on the whole (``mesh``)."""

    points: Floats
    fields: Sequence[Field] = ()

    def __post_init__(self) -> None:
        for item in self.fields:
            if item.location == "face" or (item.location == "vertex" and len(item.values) != len(self.points)):
                raise FieldError(f"field '{item.name}' has no row for each of the {len(self.points)} points")

    def __getitem__(self, name: str) -> Floats | Ints:
        """Values of the field of that name; KeyError says which there are."""
        return _named(self.fields, name)


def _named(fields: Sequence[Field], name: str) -> Floats | Ints:
    for item in fields:
        if item.name == name:
            return np.asarray(item.values)
    raise KeyError(f"no field '{name}'; there are {', '.join(f.name for f in fields)}")
