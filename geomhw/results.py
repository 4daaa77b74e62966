"""Results: fields on a mesh with a report, and fields on a cloud of points."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location

#: Fields that answer the question of a command; viewers show them first.
_ANSWERS = ("distance", "color", "transported", "direction", "velocity")


@dataclass(frozen=True, repr=False)
class Field:
    """A named array on a mesh.

    Attributes
    ----------
    name : str
    location : {"vertex", "face", "mesh"}
        What a row belongs to: a vertex, a face, or the whole mesh, such as a time.
    values : array
        (n,) or (n, d) per vertex, (m,) or (m, d) per face, any shape for the whole mesh.
    labels : dict, optional
        Names of values, if the values are labels.

    Examples
    --------
    >>> Field("height", "vertex", np.zeros(4))
    height: per vertex, shape (4,)
    """

    name: str
    location: Location
    values: Floats | Ints
    labels: Mapping[int, str] | None = None

    def __repr__(self) -> str:
        return f"{self.name}: per {self.location}, shape {np.shape(self.values)}"


@dataclass(frozen=True, repr=False)
class Result:
    """A mesh with the fields that a method computed on it, and a report.

    Attributes
    ----------
    mesh : TriangleMesh
    fields : sequence of Field
    report : dict
        Parameters, answers and accuracy as plain JSON values.
    sources : SurfacePoints, optional
        The sources that the method started from.
    source_vectors : (k, 3) array, optional
        One vector per source.

    Raises
    ------
    FieldError
        If a field does not have one row per vertex or face.

    Examples
    --------
    >>> mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> result = Result(mesh, [Field("distance", "vertex", np.array([0.0, 1.0, 1.0]))], {"mean_distance": 2 / 3})
    >>> result
    Result on TriangleMesh(3 vertices, 1 face)
      distance: per vertex, shape (3,)
      mean_distance = 0.666667
    >>> result["distance"]
    array([0., 1., 1.])
    """

    mesh: TriangleMesh
    fields: Sequence[Field] = ()
    report: dict[str, Any] = field(default_factory=dict)
    sources: SurfacePoints | None = None
    source_vectors: Floats | None = None

    def __post_init__(self) -> None:
        rows = {"vertex": self.mesh.n_vertices, "face": self.mesh.n_faces}
        for item in self.fields:
            expected = rows.get(item.location)
            if expected is not None and len(item.values) != expected:
                raise FieldError(
                    f"field '{item.name}' has {len(item.values)} rows where the mesh has "
                    f"{expected} {'vertices' if item.location == 'vertex' else 'faces'}"
                )

    def __repr__(self) -> str:
        return "\n  ".join([f"Result on {self.mesh}", *map(repr, self.fields), *_answers(self.report)])

    def __getitem__(self, name: str) -> Floats | Ints:
        """Return the values of the field with that name; raise KeyError with the existing names."""
        return _named(self.fields, name)

    def to_pyvista(self) -> Any:
        """Convert to a pyvista PolyData.

        Returns
        -------
        pyvista.PolyData
            Copies of the vertices and faces in the same order, with fields as ``point_data`` (per vertex),
            ``cell_data`` (per face) and ``field_data`` (whole mesh).

        Examples
        --------
        >>> mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> surface = Result(mesh, [Field("area", "face", mesh.face_areas)]).to_pyvista()
        >>> surface.n_points, surface.cell_data["area"].tolist()
        (3, [0.5])
        """
        import pyvista

        surface = pyvista.PolyData.from_regular_faces(self.mesh.vertices.copy(), self.mesh.faces.copy())
        places = {"vertex": surface.point_data, "face": surface.cell_data, "mesh": surface.field_data}
        for item in self.fields:
            places[item.location][item.name] = np.atleast_1d(np.array(item.values))
        return surface

    def to_meshio(self) -> Any:
        """Convert to a meshio Mesh.

        Returns
        -------
        meshio.Mesh
            Copies of the vertices and one block of triangles, with fields as ``point_data`` (per vertex),
            ``cell_data`` (per face) and ``field_data`` (whole mesh).

        Examples
        --------
        >>> mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> Result(mesh, [Field("area", "face", mesh.face_areas)]).to_meshio().cell_data
        {'area': [array([0.5])]}
        """
        import meshio

        data: dict[Location, dict[str, Any]] = {"vertex": {}, "face": {}, "mesh": {}}
        for item in self.fields:
            values = np.array(item.values)
            data[item.location][item.name] = [values] if item.location == "face" else values
        cells = [("triangle", self.mesh.faces.copy())]
        return meshio.Mesh(self.mesh.vertices.copy(), cells, data["vertex"], data["face"], data["mesh"])

    def to_trimesh(self) -> Any:
        """Convert to a trimesh.Trimesh with the same order of vertices and faces, none of them merged.

        Fields are its ``vertex_attributes``, ``face_attributes`` and, for the whole mesh, ``metadata``.
        """
        import trimesh

        surface = trimesh.Trimesh(self.mesh.vertices.copy(), self.mesh.faces.copy(), process=False)
        places = {"vertex": surface.vertex_attributes, "face": surface.face_attributes, "mesh": surface.metadata}
        for item in self.fields:
            places[item.location][item.name] = np.array(item.values)
        return surface

    def to_pandas(self, location: Location = "vertex") -> Any:
        """Convert the fields of one location to a pandas.DataFrame, a row for each vertex or face.

        Vectors ``v`` become the columns ``v_x v_y v_z``, other arrays of several components ``v_0 v_1 ...``.
        """
        import pandas

        columns: dict[str, Any] = {}
        for item in self.fields:
            if item.location == location:
                columns |= named_columns(item)
        return pandas.DataFrame(columns)

    def plot(self, name: str | None = None, **settings: Any) -> Any:
        """Show a field on the surface with pyvista, in a window or a notebook.

        Parameters
        ----------
        name
            The field; by default the one that answers the question of the method, else the first scalar.
        settings
            Of ``pyvista.PolyData.plot``, such as ``cmap="viridis"`` or ``off_screen=True``.
        """
        scalars = sorted((f for f in self.fields if np.ndim(f.values) == 1), key=lambda f: answer_rank(f.name))
        chosen = name or next((field.name for field in scalars if field.location != "mesh"), None)
        return self.to_pyvista().plot(scalars=chosen, **settings)


@dataclass(frozen=True, repr=False)
class Cloud:
    """Points without faces, on their own or joined to polylines, and fields on them.

    Attributes
    ----------
    points : (k, 3) array
    fields : sequence of Field
        Location ``vertex``: one row per point; ``face``: one row per polyline; ``mesh``: values of the whole.
    lines : (p + 1,) integer array, optional
        Polyline i joins the points from ``lines[i]`` to ``lines[i + 1] - 1``.

    Raises
    ------
    FieldError
        If a field does not have one row per point or polyline.

    Examples
    --------
    >>> Cloud(np.zeros((2, 3)), [Field("age", "vertex", np.zeros(2))])
    Cloud of 2 points
      age: per vertex, shape (2,)
    """

    points: Floats
    fields: Sequence[Field] = ()
    lines: Ints | None = None

    def __post_init__(self) -> None:
        rows = {"vertex": len(self.points), "face": 0 if self.lines is None else len(self.lines) - 1}
        for item in self.fields:
            if item.location in rows and len(item.values) != rows[item.location]:
                what = "points" if item.location == "vertex" else "polylines"
                raise FieldError(f"field '{item.name}' has no row for each of the {rows[item.location]} {what}")

    def __repr__(self) -> str:
        return "\n  ".join([f"Cloud of {len(self.points)} points", *map(repr, self.fields)])

    def __getitem__(self, name: str) -> Floats | Ints:
        """Return the values of the field with that name; raise KeyError with the existing names."""
        return _named(self.fields, name)

    @property
    def segments(self) -> Floats:
        """Both ends of each segment of the polylines, (s, 2, 3); none without polylines."""
        if self.lines is None:
            return np.empty((0, 2, 3))
        starts = np.setdiff1d(np.arange(len(self.points) - 1), self.lines[1:] - 1)
        return np.stack([self.points[starts], self.points[starts + 1]], axis=1)


def point_cloud(mesh: TriangleMesh, points: SurfacePoints, fields: Sequence[Field] = ()) -> Cloud:
    """Return points on a mesh as a cloud.

    Returns
    -------
    Cloud with ``vertex`` (-1 within faces), ``face`` and ``barycentric`` of each point, and further fields. The face of
    a vertex is its first one.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> point_cloud(grid(1, 1), vertex_points(grid(1, 1), [2]))["barycentric"].tolist()
    [[0.0, 0.0, 1.0]]
    """
    vertex = np.where(points.faces < 0, points.corners[:, 0], -1)
    faces, weights = points.faces.copy(), points.weights.copy()
    at = np.flatnonzero(vertex >= 0)
    order = np.argsort(mesh.faces, axis=None, kind="stable")
    first = order[np.searchsorted(mesh.faces.ravel(), vertex[at], sorter=order)]
    faces[at], weights[at] = first // 3, np.eye(3)[first % 3]
    named = [Field("vertex", "vertex", vertex.astype(np.int32)), Field("face", "vertex", faces.astype(np.int32))]
    return Cloud(points.positions(mesh), [*named, Field("barycentric", "vertex", weights), *fields])


def named_columns(item: Field) -> dict[str, Any]:
    """Return the components of a field by name: ``v_x v_y v_z`` for three, ``v_0 v_1 ...`` for another number."""
    values = np.asarray(item.values)
    if values.ndim == 1:
        return {item.name: values}
    rows = values.reshape(len(values), -1)
    ends = "xyz" if rows.shape[1] == 3 else range(rows.shape[1])
    return {f"{item.name}_{end}": column for end, column in zip(ends, rows.T, strict=True)}


def answer_rank(name: str) -> int:
    """Return the rank of a field among those of a result: 0 for the one that viewers show first."""
    return _ANSWERS.index(name) if name in _ANSWERS else len(_ANSWERS)


def _named(fields: Sequence[Field], name: str) -> Floats | Ints:
    """Return the values of the field with that name."""
    for item in fields:
        if item.name == name:
            return np.asarray(item.values)
    raise KeyError(f"no field '{name}'; there are {', '.join(f.name for f in fields)}")


def _answers(report: dict[str, Any], prefix: str = "") -> Iterator[str]:
    """Yield a line for each number in a report and in its nested objects."""
    for name, value in report.items():
        if isinstance(value, dict):
            yield from _answers(value, f"{prefix}{name}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield f"{prefix}{name} = {value if isinstance(value, int) else format(value, '.6g')}"
