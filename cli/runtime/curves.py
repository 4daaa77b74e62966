"""Curves and points on a mesh as files and lines of a report."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw.wording import counted

if TYPE_CHECKING:
    from geomhw.geodesic.surface_path import SurfacePath
    from geomhw.results import Cloud

#: Extensions of files of curves and of points.
CURVE_EXTENSIONS = (".vtp", ".csv")


def write_curves(cloud: "Cloud", paths: Sequence[Path]) -> None:
    """Write polylines to files, as VTP or as a table with a row per point."""
    _write(cloud, paths, "path")


def write_points(cloud: "Cloud", paths: Sequence[Path]) -> None:
    """Write points to files, as VTP or as a table: vertex, place, face, barycentric coordinates, further fields."""
    _write(cloud, paths, "vertex")


def _write(cloud: "Cloud", paths: Sequence[Path], first: str) -> None:
    """Write points to files. first: the field in the first column of tables."""
    from geomhw.io import write_cloud, write_csv

    for path in paths:
        if path.suffix.lower() == ".vtp":
            write_cloud(cloud, path)
            continue
        columns = {first: cloud[first], **dict(zip("xyz", cloud.points.T, strict=True)), "face": cloud["face"]}
        columns |= {f"b{k}": weights for k, weights in enumerate(cloud["barycentric"].T)}
        further = [field for field in cloud.fields if field.location == "vertex" and field.name != "barycentric"]
        columns |= {field.name: field.values for field in further if field.name not in columns}
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        write_csv(path, [dict(zip(columns, row, strict=True)) for row in rows])


def curve_report(path: "SurfacePath") -> dict[str, Any]:
    """Return ends, length and crossings of a curve as plain values."""
    return {
        "start": path.end(0).report()[0],
        "end": path.end(-1).report()[0],
        "length": path.length,
        "crossings": path.crossings,
        "vertices": path.vertices.tolist(),
    }


def curve_line(report: dict[str, Any]) -> str:
    """Return the report of a curve in one line."""
    from geomhw.mesh.surface_points import point_name

    ends = f"{point_name(report['start'])} to {point_name(report['end'])}"
    return f"{ends}, length {report['length']:.10g}, {counted(report['crossings'], 'edge')} crossed"
