"""``geomhw isolines``: isolines of an array as polylines."""

import json
from collections.abc import Sequence
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import CURVE_FILES
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, write_curves
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.numbers import POSITIVE, Number
from geomhw_cli.specs.sources import MAX_IN_LINE, MAX_REPORTED, SourceSpecs, source_files

if TYPE_CHECKING:
    from geomhw.arrays import Floats
    from geomhw.curves.isolines import Isolines
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Cloud

#: Number of levels by default, and at most.
LEVELS, MAX_LEVELS = 10, 10_000


def array_file(spec: str) -> list[Path]:
    """The file of FILE:ARRAY, or the file itself."""
    from geomhw.io import field_file

    return [field_file(spec)]


ARRAY = click.Argument(["array"], metavar="FILE:ARRAY", type=Spec(array_file))


@command(
    OptionGroup(
        "Input",
        option("--level levels", "VALUE", Number(-inf, inf), "Value of an isoline. May be repeated.", multiple=True),
        option("--every", "D", POSITIVE, "Isolines at all multiples of D."),
        option(
            "--count",
            "N",
            Number(1, MAX_LEVELS, whole=True),
            f"N evenly spaced isolines between the least and the largest value.  [default: {LEVELS}]",
        ),
        option(
            "--between",
            "A B",
            Spec(source_files),
            "Instead of an array: the share of the way from the points A to B, written as in --source of geodesic, "
            "d(A) / (d(A) + d(B)) of exact distances.",
            nargs=2,
        ),
        option(
            "--array values",
            "SPEC",
            Spec(array_file),
            "The array, if it is not in the file of the mesh: a .npy, FILE:ARRAY of a table or another mesh.",
        ),
    ),
    CURVE_FILES,
    options.REPORT,
    arguments=(ARRAY,),
)
def isolines(
    array: str,
    levels: tuple[float, ...],
    every: float | None,
    count: int | None,
    between: tuple[str, str] | None,
    values: str | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Trace isolines of a vertex array of a mesh, or between two sets of points.

    An isoline is a polyline through faces, closed or from boundary to boundary. It passes through vertices and along
    edges of equal value once. Higher values are on its left. Without -o, writes <stem>.isolines.vtp and .png to the
    current directory. With -o, writes those files, and a picture only with --png. FILE is a mesh, without an array with
    --array and --between.

    \b
    Arrays per point: path, face, barycentric (3), arc_length.
    Arrays per line:  level, length, closed, enclosed_area (the smaller side), area_below, area_above (the sides of
                      lower and of higher values; NaN where the line does not divide its component).
    Columns of .csv:  path, x, y, z, face, b0, b1, b2, arc_length, level, closed. A .json file has a list of lines.

    \b
    Examples:
      geomhw geodesic data/creature.obj --source 0 --no-png -o d.vtp
      geomhw isolines d.vtp:distance --every 0.25 -o rings.vtp --png rings.png
      geomhw isolines d.vtp:distance --level 0.5 --level 1 --no-png -o rings.csv
      geomhw isolines data/strip.off --between min-x max-x --count 4 -o rows.json
    """
    import numpy as np

    from geomhw.curves.isolines import isolines as lines_at
    from geomhw.render.curve_pictures import isoline_picture

    if bool(levels) + (every is not None) + (count is not None) > 1:
        raise click.UsageError("--level, --every and --count exclude each other.")
    if between and values:
        raise click.UsageError("--between and --array exclude each other.")
    (path,) = array_file(array)
    name = array[len(str(path)) + 1 :]
    if name and (between or values):
        raise click.UsageError(f"With --{'between' if between else 'array'}, give the mesh without an array: {path}.")
    job = Job.plan("isolines", path, **files, **report, extensions=(*CURVE_EXTENSIONS, ".json"))
    mesh = job.read()
    with job.stage("compute"):
        if between:
            name, function = "share of the way", _shares(mesh, between, job)
        else:
            name, function = _values(mesh, values or array, job)
        wanted = _levels(function, levels, every, count or LEVELS, name)
        found = lines_at(mesh, function, wanted)
    if not len(found):
        from geomhw.errors import ArgumentError, FieldError

        low, high = _range(function)
        error = ArgumentError if levels else FieldError
        raise error(f"{name} is from {low:.10g} to {high:.10g}, and has no isoline at {_listed(wanted)}")
    job.write(
        found.cloud(),
        lambda cloud, look: isoline_picture(mesh, function, cloud, name, look),
        lambda cloud, paths: _write(found, cloud, paths),
        mesh,
    )
    answers = found.report()
    by_level = [_level_report(float(level), found) for level in (wanted if levels else np.unique(found.levels))]
    lines = [_line(item) for item in by_level[:MAX_IN_LINE]]
    if len(by_level) > MAX_IN_LINE:
        lines.append(f"isolines: {len(found)} at {len(by_level)} levels, of length {found.lengths.sum():.10g} together")
    if missing := [item["level"] for item in by_level if not item["lines"]]:
        lines.append(f"note: no isoline at {_listed(missing)}")
    job.finish(mesh, {"levels": by_level, "count": len(found), "isolines": answers[:MAX_REPORTED]}, lines)


def _values(mesh: "TriangleMesh", spec: str, job: Job) -> "tuple[str, Floats]":
    """Name and values of the array, one number per vertex."""
    import numpy as np

    from geomhw.errors import FieldError
    from geomhw.io import read_field

    array = read_field(spec, mesh, finite=False)
    values = np.asarray(array.values, dtype=float)
    if array.location != "vertex":
        raise FieldError(f"'{array.name}' is an array on faces; isolines need one number per vertex")
    if values.ndim == 2 and values.shape[1] == 1:
        values = values[:, 0]
    if values.ndim > 1:
        raise FieldError(f"'{array.name}' has {values.shape[1]} numbers per vertex; isolines need one")
    _note_left_out(mesh, values, job)
    return array.name, values


def _note_left_out(mesh: "TriangleMesh", values: "Floats", job: Job) -> None:
    """Remark on vertices without a finite value; FieldError if no face has three finite ones."""
    import numpy as np

    from geomhw.errors import FieldError

    lost = ~np.isfinite(values)
    lost[mesh.unreferenced_vertices] = False
    if lost[mesh.faces].any(axis=1).all():
        raise FieldError("no face has finite values at its three corners, so there are no isolines")
    if lost.any():
        number = counted(int(lost.sum()), "vertex", "vertices")
        job.remarks.append(f"note: {number} with infinite or undefined values, whose faces are left out")


def _shares(mesh: "TriangleMesh", between: tuple[str, str], job: Job) -> "Floats":
    """The share of the way between two sets of points."""
    from geomhw.curves.isolines import levels_between

    one, other = (SourceSpecs.parse([text]).resolve(mesh, job.remarks, curves=True) for text in between)
    shares = levels_between(mesh, one, other)
    _note_left_out(mesh, shares, job)
    return shares


def _range(values: "Floats") -> tuple[float, float]:
    """The least and the largest finite value."""
    from numpy import isfinite

    finite = values[isfinite(values)]
    return float(finite.min()), float(finite.max())


def _levels(values: "Floats", levels: Sequence[float], every: float | None, count: int, name: str) -> "Floats":
    """The levels of isolines, ascending."""
    import numpy as np

    from geomhw.errors import ArgumentError, FieldError

    if levels:
        if not np.isfinite(levels).all():
            raise ArgumentError("--level is a finite number")
        return np.unique(levels)
    low, high = _range(values)
    if every is not None:
        if high / every - low / every > MAX_LEVELS:
            raise ArgumentError(f"isolines every {every:g} are more than {MAX_LEVELS} from {low:g} to {high:g}")
        wanted = every * np.arange(np.ceil(low / every), np.floor(high / every) + 1)
        if not len(wanted):
            raise ArgumentError(f"{name} is from {low:.10g} to {high:.10g}, where there is no multiple of {every:g}")
        return np.asarray(wanted)
    if low == high:
        raise FieldError(f"{name} is {low:.10g} at all vertices, so it has no isolines")
    share = np.arange(1, count + 1) / (count + 1)
    return np.unique(low * (1 - share) + high * share)


def _level_report(level: float, found: "Isolines") -> dict[str, Any]:
    """Number and length of the lines of a level."""
    at = found.levels == level
    return {
        "level": level,
        "lines": int(at.sum()),
        "closed": int((at & found.closed).sum()),
        "length": float(found.lengths[at].sum()),
    }


def _line(item: dict[str, Any]) -> str:
    """The report of a level in one line."""
    opened = item["lines"] - item["closed"]
    return f"level: {item['level']:.10g}, {item['closed']} closed and {opened} open, length {item['length']:.10g}"


def _listed(levels: "Sequence[float] | Floats") -> str:
    """The first levels as text."""
    names = [f"{level:.10g}" for level in levels[:MAX_IN_LINE]]
    return ", ".join(names) + (", ..." if len(levels) > MAX_IN_LINE else "")


def _write(found: "Isolines", cloud: "Cloud", paths: Sequence[Path]) -> None:
    """Write polylines as VTP, as a table with a row per point, or as JSON."""
    from dataclasses import replace

    from geomhw.results import Field

    line = cloud["path"]
    columns = [Field("level", "vertex", found.levels[line]), Field("closed", "vertex", found.closed[line].astype(int))]
    table = replace(cloud, fields=[*(field for field in cloud.fields if field.location == "vertex"), *columns])
    for path in paths:
        if path.suffix.lower() == ".json":
            _write_json(found, path)
        else:
            write_curves(table if path.suffix.lower() == ".csv" else cloud, [path])


def _write_json(found: "Isolines", path: Path) -> None:
    """Write a list of lines: the entries of the report, with the points, their faces and barycentric coordinates."""
    from geomhw.io import replacing

    places = [slice(*pair) for pair in pairwise(found.starts.tolist())]
    lines = [
        {
            **answer,
            "points": found.positions[at].tolist(),
            "faces": found.faces[at].tolist(),
            "barycentric": found.weights[at].tolist(),
        }
        for answer, at in zip(found.report(), places, strict=True)
    ]
    with replacing([path]) as (temporary,):
        temporary.write_text(json.dumps(lines, allow_nan=False) + "\n", encoding="utf-8")
