"""Parts of a mesh as written on the command line: ``FILE:ARRAY`` or ``@FILE`` of a mask, within which paths stay."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from geomhw.errors import FieldError
from geomhw_cli.specs.sources import SourceSpecs

if TYPE_CHECKING:
    from geomhw.arrays import Ints
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Result


@dataclass(frozen=True)
class MaskSpec:
    """A mask: an array that is not zero on the vertices or faces of the part, or a file of its vertices."""

    text: str

    @property
    def path(self) -> Path:
        """The file of the mask."""
        from geomhw.io import field_file

        return Path(self.text[1:]) if self.text.startswith("@") else field_file(self.text)

    @classmethod
    def parse(cls, text: str | None) -> "MaskSpec | None":
        """Return the mask of an option; None without it."""
        return None if text is None else cls(text)

    def faces(self, mesh: "TriangleMesh") -> "Ints":
        """Find the faces of the mask, ascending; of a mask of vertices, those with all three corners in it."""
        import numpy as np

        from geomhw.io import read_field

        if self.text.startswith("@"):
            included = np.isin(mesh.faces, SourceSpecs.parse([self.text]).vertices(mesh)).all(axis=1)
        else:
            field = read_field(self.text, mesh)
            inside = np.any(field.values.reshape(len(field.values), -1) != 0, axis=1)
            included = inside[mesh.faces].all(axis=1) if field.location == "vertex" else inside
        if not included.any():
            raise FieldError(f"the mask {self.text} contains no face; a face needs its three vertices in it")
        return np.flatnonzero(included)


@dataclass(frozen=True)
class MeshPart:
    """A mesh, and the mesh of some of its faces, by ascending index, with all its vertices. faces: None for all."""

    whole: "TriangleMesh"
    mesh: "TriangleMesh"
    faces: "Ints | None" = None

    @classmethod
    def of(cls, mesh: "TriangleMesh", mask: MaskSpec | None) -> "MeshPart":
        """Cut the part in a mask out of a mesh; all of it without a mask."""
        if mask is None:
            return cls(mesh, mesh)
        from geomhw.mesh.triangle_mesh import TriangleMesh

        faces = mask.faces(mesh)
        return cls(mesh, TriangleMesh(mesh.vertices, mesh.faces[faces]), faces)

    def sources(self, specs: SourceSpecs, remarks: list[str] | None = None) -> "SurfacePoints":
        """Find points of the whole mesh in the part; by default its vertex of largest y. See `SourceSpecs.resolve`."""
        return self.points(specs.resolve(self.whole, remarks, curves=True)) if specs.specs else specs.resolve(self.mesh)

    def points(self, points: "SurfacePoints") -> "SurfacePoints":
        """Return points of the whole mesh as points of the part. Raises FieldError for a point outside of it."""
        if self.faces is None:
            return points
        import numpy as np

        place = np.searchsorted(self.faces, points.faces)
        place[place == len(self.faces)] = 0
        at_vertex = points.faces < 0
        outside = np.where(
            at_vertex, np.isin(points.corners[:, 0], self.mesh.unreferenced_vertices), self.faces[place] != points.faces
        )
        if outside.any():
            raise FieldError(f"source {points.name(int(outside.argmax()))} is outside of the mask")
        segments = points.segments.copy()
        inner = np.searchsorted(self.faces, segments[:, 2])
        inner[inner == len(self.faces)] = 0
        if (lost := self.faces[inner] != segments[:, 2]).any():
            raise FieldError(f"a curve passes face {segments[lost.argmax(), 2]}, which is outside of the mask")
        segments[:, 2] = inner
        return replace(points, faces=np.where(at_vertex, -1, place), segments=segments)

    def vertices(self, vertices: "Sequence[int] | Ints") -> "Ints":
        """Those of some vertices of the whole mesh that have faces in the part, ascending."""
        import numpy as np

        return np.setdiff1d(np.asarray(vertices, dtype=np.int64), self.mesh.unreferenced_vertices)

    def expand(self, result: "Result") -> "Result":
        """Return a result on the part as one on the whole mesh, with zeros on the other faces."""
        if self.faces is None:
            return result
        import numpy as np

        from geomhw.results import Field, Result

        fields = []
        for field in result.fields:
            values = np.asarray(field.values)
            if field.location == "face":
                values = np.zeros((self.whole.n_faces, *values.shape[1:]))
                values[self.faces] = field.values
            fields.append(Field(field.name, field.location, values))
        points = result.sources
        if points is not None:
            segments = points.segments.copy()
            segments[:, 2] = self.faces[segments[:, 2]]
            faces = np.where(points.faces < 0, -1, self.faces[points.faces])
            points = replace(points, faces=faces, segments=segments)
        report = {**result.report, "sources": points.report()} if points else result.report
        return Result(self.whole, fields, report, points)
