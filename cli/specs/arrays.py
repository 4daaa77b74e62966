"""An array on the vertices of a mesh: ``MESH:ARRAY``, or MESH and ``--array FILE:ARRAY``."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import FieldError
from geomhw_cli.options import MESH, option
from geomhw_cli.specs.fields import array_files
from geomhw_cli.specs.files import Spec, add_input

if TYPE_CHECKING:
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Field
    from geomhw_cli.runtime.job import Job


@dataclass(frozen=True)
class MeshArray:
    """A mesh file, and the name of an array in it, "" for the only one."""

    path: Path
    key: str

    def read(self, job: "Job", other: str | None) -> "tuple[TriangleMesh, Field]":
        """Read the mesh of a job, and the array in its file or in another one, which is per vertex.

        Raises FieldError for an array per face, or if the mesh file holds none or several and no name is given.
        """
        from geomhw.io import read_field

        mesh = job.read()
        with job.stage("read array"):
            field = read_field(other, mesh) if other else self._field(job)
        if field.location != "vertex":
            raise FieldError(f"the array '{field.name}' is per face; it needs one value per vertex")
        return mesh, field

    def _field(self, job: "Job") -> "Field":
        """The array in the file of the mesh, with finite values."""
        import numpy as np

        fields = [field for field in job.fields if field.location != "mesh"]
        named = [field for field in fields if field.name == self.key]
        if self.key.isdecimal() and not named:
            named = fields[int(self.key) : int(self.key) + 1]
        if not self.key and len(fields) == 1:
            named = fields
        if not named:
            names = ", ".join(field.name for field in fields) or "none"
            problem = f"has no array '{self.key}'" if self.key else "holds no single array; give its name after a colon"
            raise FieldError(f"{self.path} {problem}; there are {names}; --array names one in another file")
        field = min(named, key=lambda one: one.location != "vertex")
        if not np.isfinite(field.values).all():
            bad = int(np.argmin(np.isfinite(field.values).reshape(len(field.values), -1).all(axis=1)))
            raise FieldError(f"{self.path}:{self.key}: row {bad} is not a finite number")
        return field


class _MeshArrayType(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    name = "mesh"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> MeshArray:
        """Return file and array; the file is an input from now on."""
        from geomhw.io import field_parts

        if isinstance(value, MeshArray):
            return value
        if ":" not in str(value):
            return MeshArray(MESH.type.convert(value, param, ctx), "")
        path, key = field_parts(str(value))
        add_input(path)
        return MeshArray(path, key)


MESH_ARRAY = click.Argument(["mesh_array"], metavar="MESH[:ARRAY]", type=_MeshArrayType())
ARRAY = option(
    "--array",
    "FILE:ARRAY",
    Spec(array_files),
    "The array, in another file: of GIFTI or FreeSurfer (by name or number), .npy, .npz, .csv, or a mesh.  [default: "
    "the one in MESH]",
)
