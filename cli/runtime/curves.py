"""Curves and points on a mesh as files and lines of a report."""

from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw.wording import counted

if TYPE_CHECKING:
    from geomhw.geodesic.surface_path import SurfacePath
    from geomhw.io.artifacts.shards import Shard
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


def curve_data(cloud: "Cloud", numbers: Sequence[int]) -> Iterator[bytes]:
    """Curves as the data of a shard. numbers: of the curves among those of the whole run."""
    import numpy as np

    stream = BytesIO()
    arrays: dict[str, Any] = {field.name: field.values for field in cloud.fields}
    arrays |= {"points": cloud.points, "lines": cloud.lines, "numbers": numbers}
    np.savez(stream, **arrays)
    yield stream.getvalue()


def join_curves(shards: "Sequence[Shard]", path: Path) -> dict[str, Any]:
    """Write the curves of all shards in the order of their numbers; return what the report says of them."""
    import numpy as np

    from geomhw.results import Cloud, Field

    parts = [np.load(BytesIO(data)) for shard in shards if (data := b"".join(shard.chunks()))]
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0] if name not in ("lines", "path")}
    sizes = np.concatenate([np.diff(part["lines"]) for part in parts])
    order = np.argsort(whole.pop("numbers"), kind="stable")
    begins = (np.cumsum(sizes) - sizes)[order]
    sizes = sizes[order]
    lines = np.append(0, np.cumsum(sizes))
    points = np.arange(lines[-1]) + np.repeat(begins - lines[:-1], sizes)
    fields = [Field("path", "vertex", np.repeat(np.arange(len(sizes), dtype=np.int32), sizes))]
    fields += [Field(name, "vertex", whole[name][points]) for name in ("face", "barycentric", "arc_length")]
    fields.append(Field("length", "mesh", whole["length"][order]))
    write_curves(Cloud(whole["points"][points], fields, lines), [path])
    return {"paths": len(sizes), "length": float(whole["length"][order].sum())}


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
