"""Curves and points on a mesh as files and lines of a report."""

from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import FormatError
from geomhw.wording import counted
from geomhw_cli.runtime.job import Job
from geomhw_cli.runtime.picture_kinds import KINDS
from geomhw_cli.specs.shards import ShardPart

if TYPE_CHECKING:
    from geomhw.geodesic.surface_path import SurfacePath
    from geomhw.io.artifacts.shards import Shard
    from geomhw.mesh.triangle_mesh import TriangleMesh
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


def require_curve_shard(option: str, is_given: bool, files: Mapping[str, Any]) -> None:
    """Raise UsageError unless a part of the curves of an option goes to one file, without pictures."""
    if not is_given:
        raise click.UsageError(f"--shard is for {option}.")
    if drawn := next((kind for kind in (*KINDS, "html") if files[kind]), ""):
        raise click.UsageError(f"--{drawn} and --shard exclude each other.")
    if len(files["outputs"]) != 1:
        raise click.UsageError(f"A part of {option} goes to one file; give -o D.K.shard.")


def write_curve_shard(
    job: Job, mesh: "TriangleMesh", shard: ShardPart, run: Mapping[str, Any], paths: "Mapping[int, SurfacePath]"
) -> None:
    """Write curves to a shard, and report it. run: what identifies the whole run. paths: by their number in it."""
    from geomhw import __version__
    from geomhw.io.artifacts.shards import write_shard

    numbers = sorted(paths)
    found = [paths[number] for number in numbers]
    run = {"version": __version__, "mesh": mesh.digest, **run}
    with job.stage("write"):
        data = _arrays(found, numbers) if found else b""
        write_shard(job.outputs[0], run, shard.number, shard.of, "curves", {}, lambda: [data])
    job.written.append(str(job.outputs[0]))
    report = {**shard.report(), "curves": len(found), "length": sum(path.length for path in found)}
    job.finish(mesh, report, [*shard.lines(), f"curves: {len(found)}"])


def _arrays(paths: "Sequence[SurfacePath]", numbers: Sequence[int]) -> bytes:
    """The arrays of curves as the data of a shard."""
    import numpy as np

    from geomhw.geodesic.surface_path import polylines

    stream, cloud = BytesIO(), polylines(paths)
    arrays: dict[str, Any] = {field.name: field.values for field in cloud.fields}
    arrays |= {"points": cloud.points, "lines": cloud.lines, "numbers": numbers}
    np.savez(stream, **arrays)
    return stream.getvalue()


def join_curves(shards: "Sequence[Shard]", path: Path) -> dict[str, Any]:
    """Write the curves of all shards in the order of their numbers; return what the report says of them."""
    import numpy as np

    from geomhw.results import Cloud, Field

    parts = [np.load(BytesIO(data)) for shard in shards if (data := b"".join(shard.chunks()))]
    if not parts:
        raise FormatError("the shards hold no curve")
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
    return {"curves": len(sizes), "length": float(whole["length"][order].sum())}


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
