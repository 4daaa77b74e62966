"""Tables of distances between labels, as written on the command line: ``--labels FILE:ARRAY --table mean,min``."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import click

from geomhw.errors import FieldError
from geomhw.options import TableStatistic
from geomhw_cli.specs.masks import MeshPart

if TYPE_CHECKING:
    from geomhw.geodesic.label_groups import LabelGroups


@dataclass(frozen=True)
class LabelTable:
    """An array of labels on the vertices or the faces, and the statistics of a table."""

    field: str
    statistics: tuple[TableStatistic, ...] = get_args(TableStatistic)

    @property
    def path(self) -> Path:
        """The file of the labels."""
        from geomhw.io import field_file

        return field_file(self.field)

    @classmethod
    def parse(cls, field: str | None, table: tuple[TableStatistic, ...] | None, all_pairs: bool) -> "LabelTable | None":
        """Read the two options; None without them. Raises UsageError for one without the other."""
        if field is None:
            if table is not None:
                raise click.UsageError("--table needs --labels.")
            return None
        if not all_pairs:
            raise click.UsageError("--labels is for --all-pairs.")
        return cls(field, table) if table else cls(field)

    def report(self) -> dict[str, str]:
        """Return what identifies the table in the record of a resumable run."""
        from geomhw.io import file_digest

        return {"labels": file_digest(self.path), "array": self.field, "table": ",".join(self.statistics)}

    def groups(self, part: MeshPart) -> "LabelGroups":
        """Read the labels of a mesh and group the vertices of a part. Raises FieldError unless they are numbers."""
        from geomhw.geodesic.label_groups import LabelGroups
        from geomhw.io import read_field

        array = read_field(self.field, part.whole)
        labels, of_faces = array.values, array.location == "face"
        if labels.ndim != 1 or array.location == "mesh":
            raise FieldError(f"{self.field} is no array of labels; it needs one number per vertex or face")
        if of_faces and part.faces is not None:
            labels = labels[part.faces]
        return LabelGroups(part.mesh, labels, of_faces, self.statistics)
