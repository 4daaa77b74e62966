"""Curves of a file: tables and polylines of points, or lines of points written as sources."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw.errors import FormatError
from geomhw_cli.specs.sources import source_lines

if TYPE_CHECKING:
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

_PLACE, _WEIGHTS = ("x", "y", "z"), ("face", "b0", "b1", "b2")


def read_curves(path: Path, mesh: "TriangleMesh") -> list["SurfacePoints"]:
    """Read the points of each curve of a file.

    Tables, .csv, and polylines, .vtp, are as the program writes them; the columns face, b0, b1 and b2, or x, y and z
    are enough. A .border is of Workbench. Other files have a curve per line, written as sources. Raises FormatError for
    a file without points.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        from geomhw.io import read_csv

        return _from_columns(path, mesh, read_csv(path))
    if suffix == ".vtp":
        from geomhw.io import read_cloud

        cloud = read_cloud(path)
        columns = dict(zip(_PLACE, cloud.points.T, strict=True)) | {f.name: f.values for f in cloud.fields}
        if "barycentric" in columns:
            columns |= dict(zip(_WEIGHTS[1:], columns["barycentric"].T, strict=True))
        return _from_columns(path, mesh, columns)
    if suffix == ".border":
        from geomhw.io import read_polylines
        from geomhw.mesh import nearest_points

        cloud = read_polylines(path, mesh.vertices)
        return [
            nearest_points(mesh, cloud.points[a:b])
            for a, b in pairwise([] if cloud.lines is None else cloud.lines.tolist())
        ]
    return [specs.resolve(mesh) for specs in source_lines(path)]


def _from_columns(path: Path, mesh: "TriangleMesh", columns: Mapping[str, Any]) -> list["SurfacePoints"]:
    """Return the points of each curve of a table."""
    import numpy as np

    from geomhw.mesh import nearest_points
    from geomhw.mesh.named_points import face_points

    if not (set(_WEIGHTS) <= set(columns) or set(_PLACE) <= set(columns)) or not len(next(iter(columns.values()))):
        raise FormatError(f"{path} has no points: it needs the columns {', '.join(_WEIGHTS)}, or {', '.join(_PLACE)}")
    if set(_WEIGHTS) <= set(columns):
        faces, *weights = (columns[name] for name in _WEIGHTS)
        points = face_points(mesh, faces.astype(np.int64), np.stack(weights, axis=1))
    else:
        points = nearest_points(mesh, np.stack([columns[name] for name in _PLACE], axis=1))
    curve = columns.get("path", np.zeros(len(points)))
    return [points[np.flatnonzero(curve == name)] for name in np.unique(curve)]
