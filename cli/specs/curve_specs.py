"""Curves on a mesh as written on the command line: a file of polylines, ``boundary``, ``edges:angle>40``, a border."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from geomhw.errors import FieldError
from geomhw_cli.specs.numbers import excerpt

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.geodesic.surface_path import SurfacePath
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

CURVE_HELP = (
    "a file of polylines on or near the surface: .vtp, .obj with l elements, .csv with the columns x, y, z and for "
    "several curves path, .border of Connectome Workbench; boundary (all boundary loops), edges:angle>40 (edges at "
    "which faces meet at this angle in degrees), or border:FILE:ARRAY (edges between faces, or round vertices, of "
    "different labels)"
)
_EDGES = re.compile(r"edges:(?:angle[>=])?(\d+\.?\d*|\.\d+)")


@dataclass(frozen=True)
class CurvesOnMesh:
    """Curves of one spec.

    paths: polylines. sides: sides of faces, 3f + k opposite corner k of face f, in the direction of the face. directed:
    whether that direction means something. distance: of the given points from the surface, at most.
    """

    paths: "Sequence[SurfacePath]"
    sides: "Ints"
    directed: bool = True
    distance: float = 0.0

    @property
    def curves(self) -> "list[tuple[Ints, Floats]]":
        """Faces and weights of the polylines, as of `insert_curves`."""
        return [(path.faces, path.weights) for path in self.paths]

    def points(self, mesh: "TriangleMesh") -> "SurfacePoints":
        """Their points and segments, curve by curve."""
        from geomhw.mesh import curve_points, edge_points
        from geomhw.mesh.surface_points import concatenate

        parts = [curve_points(mesh, *curve) for curve in self.curves]
        return concatenate([*parts, *([edge_points(mesh, self.sides)] if len(self.sides) else [])])

    def edges(self, mesh: "TriangleMesh") -> "Ints":
        """The edges of the sides."""
        return mesh.edge_table.of_faces.ravel()[self.sides]


@dataclass(frozen=True)
class CurveSpec:
    """A curve as a source."""

    text: str
    parts: Mapping[str, str | None] = field(default_factory=dict)

    def resolve(self, mesh: "TriangleMesh", remarks: list[str] | None = None) -> "SurfacePoints":
        """Find the points and segments of the curve. remarks: as in `curves_on`."""
        return curves_on(mesh, self.text, [] if remarks is None else remarks).points(mesh)


def is_curve(text: str) -> bool:
    """Whether a source is a curve."""
    return text.startswith(("curve:", "edges:", "border:"))


def curve_files(text: str) -> list[Path]:
    """The file that a curve is read from."""
    from geomhw.io import field_file

    text = text.strip().removeprefix("curve:")
    if text == "boundary" or text.startswith("edges:"):
        return []
    if text.startswith("border:"):
        return [field_file(text.removeprefix("border:"))]
    return [Path(text)]


def curves_on(mesh: "TriangleMesh", text: str, remarks: list[str]) -> CurvesOnMesh:
    """Find the curves of a spec on a mesh. remarks: takes a line on the distance of a file's points."""
    import numpy as np

    text, none = text.strip().removeprefix("curve:"), np.empty(0, dtype=np.int64)
    if text == "boundary":
        sides = np.flatnonzero(mesh.edge_table.face_counts[mesh.edge_table.of_faces.ravel()] == 1)
        if not len(sides):
            raise FieldError("the mesh has no boundary; name another curve")
        return CurvesOnMesh([], sides)
    if text.startswith("edges:"):
        return CurvesOnMesh([], _feature_sides(mesh, text), directed=False)
    if text.startswith("border:"):
        return CurvesOnMesh([], _border_sides(mesh, text.removeprefix("border:")))
    return _from_file(mesh, Path(text), remarks, none)


def _from_file(mesh: "TriangleMesh", path: Path, remarks: list[str], none: "Ints") -> CurvesOnMesh:
    """Trace the polylines of a file."""
    import numpy as np

    from geomhw.curves.traced import trace_points, trace_polylines
    from geomhw.io import read_polylines
    from geomhw.mesh.named_points import face_points

    cloud = read_polylines(path, mesh.vertices)
    assert cloud.lines is not None
    columns = {field.name: field.values for field in cloud.fields}
    count = len(cloud.lines) - 1
    parts = [slice(int(a), int(b)) for a, b in pairwise(cloud.lines)]
    names = [path.name if count == 1 else f"curve {k} of {path.name}" for k in range(count)]
    if "face" in columns and "barycentric" in columns and _match(mesh, cloud.points, columns):
        points = face_points(mesh, np.asarray(columns["face"]).astype(np.int64), np.asarray(columns["barycentric"]))
        rows = np.arange(len(points))
        traced = [trace_points(mesh, points[rows[at]], name) for at, name in zip(parts, names, strict=True)]
    else:
        traced = trace_polylines(mesh, [cloud.points[at] for at in parts], names)
    distance = max(item.distance for item in traced)
    if distance > 1e-6 * float(np.ptp(mesh.vertices[mesh.faces].reshape(-1, 3), axis=0).max()):
        remarks.append(f"note: points of {path.name} are up to {distance:.4g} from the surface, to which they move")
    return CurvesOnMesh([item.path for item in traced], none, distance=distance)


def _match(mesh: "TriangleMesh", points: "Floats", columns: "dict[str, Floats | Ints]") -> bool:
    """Whether faces and barycentric coordinates of a file are those of its points on this mesh."""
    import numpy as np

    face, weights = np.asarray(columns["face"]), np.asarray(columns["barycentric"], dtype=float)
    if not np.isin(face, np.arange(mesh.n_faces)).all() or weights.shape != (len(face), 3) or (weights < 0).any():
        return False
    positions = np.einsum("kc,kcx->kx", weights, mesh.vertices[mesh.faces[face.astype(np.int64)]])
    return bool(np.abs(positions - points).max(initial=0.0) <= 1e-9 * np.abs(mesh.vertices).max())


def _feature_sides(mesh: "TriangleMesh", text: str) -> "Ints":
    """One side of each edge at which the normals of two faces differ by more than an angle."""
    import click
    import numpy as np

    from geomhw.mesh.topology import inner_pairs

    found = _EDGES.fullmatch(text)
    if not found or not float(found[1]) < 180:
        raise click.UsageError(f"'{excerpt(text)}' names no edges; give edges:angle>DEGREES, such as edges:angle>40.")
    one, other, same = inner_pairs(mesh.edge_table)
    normals = mesh.face_normals
    dots = np.einsum("ex,ex->e", normals[one // 3], normals[other // 3]) * np.where(same, -1, 1)
    sharp = dots < np.cos(np.radians(float(found[1])))
    if not sharp.any():
        raise FieldError(f"no two faces meet at an angle of more than {found[1]} degrees")
    return one[sharp]


def _border_sides(mesh: "TriangleMesh", spec: str) -> "Ints":
    """Sides between faces of different labels, of the face with the higher one, which is on their left.

    Of labels at vertices, a face has that of most of its corners.
    """
    import numpy as np

    from geomhw.io import read_field
    from geomhw.mesh.topology import inner_pairs

    array = read_field(spec, mesh)
    labels = np.asarray(array.values)
    if labels.ndim != 1:
        raise FieldError(f"{spec} is no array of labels; it needs one number per vertex or face")
    if array.location == "vertex":
        a, b, c = labels[mesh.faces].T
        labels = np.where((a == b) | (a == c), a, np.where(b == c, b, np.minimum(np.minimum(a, b), c)))
    one, other, _ = inner_pairs(mesh.edge_table)
    first, second = labels[one // 3], labels[other // 3]
    if (first == second).all():
        raise FieldError(f"{spec} has one label, so no border")
    return np.asarray(np.where(first > second, one, other)[first != second])
