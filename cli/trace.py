"""``geomhw trace``: straightest geodesics."""

from pathlib import Path
from typing import Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option, points_option
from geomhw_cli.output_options import CURVE_FILES
from geomhw_cli.runtime.curves import (
    CURVE_EXTENSIONS,
    curve_line,
    curve_report,
    require_curve_shard,
    write_curve_shard,
    write_curves,
)
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.numbers import LARGEST, SMALLEST, Number
from geomhw_cli.specs.shards import WHOLE, ShardPart, shard_option
from geomhw_cli.specs.sources import MAX_IN_LINE, SourceSpecs

MAX_DEGREES, MAX_LINES = 1e12, 100_000


@command(
    OptionGroup(
        "Input",
        points_option("--from starts", "Start. May be repeated; each point gets the same lines."),
        option(
            "--angle",
            "DEG",
            Number(-MAX_DEGREES, MAX_DEGREES),
            "Direction, counterclockwise from the first edge of the vertex's first face, or of the face that contains "
            "the start. Angles around an inner vertex are scaled to sum to 360 degrees.  [default: 0]",
        ),
        option(
            "--vector",
            "X Y Z",
            Number(-LARGEST, LARGEST),
            "Instead: direction as a vector; its tangential part is used.",
            nargs=3,
        ),
        option("--length", "L", Number(SMALLEST, LARGEST), "Length of the line.", required=True),
        option(
            "--fan",
            "N",
            Number(1, MAX_LINES, whole=True),
            "Number of lines, at even angles from --angle on. Those off the surface are left out.",
        ),
    ),
    CURVE_FILES,
    OptionGroup(CURVE_FILES.title, shard_option("lines of --fan", "such as -o lines.K.shard")),
    options.REPORT,
)
def trace(
    mesh_path: Path,
    starts: SourceSpecs,
    angle: float | None,
    vector: tuple[float, float, float] | None,
    length: float,
    fan: int | None,
    files: dict[str, Any],
    shard: ShardPart | None,
    report: dict[str, Any],
) -> None:
    """Trace straightest geodesics on MESH: the exponential map.

    A line is straight across edges. Through a vertex it goes with equal angles on both sides. It ends at its length, at
    the boundary, or at an edge of more than two faces, and the report says where. Without -o, writes <stem>.trace.vtp
    and .png to the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per point: path, face, barycentric (3), arc_length. Field data: length (per path).
    Columns of .csv:  path, x, y, z, face, b0, b1, b2, arc_length.

    \b
    Examples:
      geomhw trace data/creature.obj --from 0 --angle 30 --length 2 -o line.vtp --png line.png
      geomhw trace data/torus.off --from face:17 --vector 0 0 1 --length 5 --no-png -o line.csv
      geomhw trace data/sphere.off --from 0 --length 1.5 --fan 36 -o star.vtp
    """
    from geomhw.errors import ArgumentError
    from geomhw.geodesic.straightest import StraightestGeodesics
    from geomhw.geodesic.surface_path import polylines
    from geomhw.render.curve_pictures import curve_picture

    if vector and (angle is not None or fan):
        raise click.UsageError("--vector excludes --angle and --fan.")
    if shard:
        require_curve_shard("--fan", fan is not None, files)
    job = Job.plan("trace", mesh_path, **files, **report, extensions=[".shard"] if shard else CURVE_EXTENSIONS)
    mesh = job.read()
    lines, found = [], []
    with job.stage("compute"):
        solver, sources = StraightestGeodesics(mesh), starts.resolve(mesh, job.remarks)
        first, last = (shard or WHOLE).range(len(sources) * (fan or 1))
        for number, source in enumerate(sources.split()):
            if vector:
                found.append(solver.trace(source, vector, length))
                continue
            if not fan:
                found.append(solver.trace_angle(source, angle or 0.0, length))
                continue
            begin, past = (min(max(bound - number * fan, 0), fan) for bound in (first, last))
            found += solver.fan(source, [(angle or 0.0) + 360 * k / fan for k in range(begin, past)], length)
        if not (found or shard):
            raise ArgumentError("no direction stays on the surface; give another --angle or a larger --fan")
    if shard:
        run = {"question": "trace --fan", "sources": sources.report(), "angle": angle, "length": length, "fan": fan}
        write_curve_shard(job, mesh, shard, run, dict(enumerate(found, start=first)))
        return
    job.write(polylines(found), lambda cloud, look: curve_picture(mesh, cloud, sources, look=look), write_curves, mesh)
    reports = [{**curve_report(path), "stop": path.stop or None} for path in found]
    lines = [f"line: {curve_line(item)}" for item in reports[:MAX_IN_LINE]]
    if len(found) > MAX_IN_LINE:
        lines.append(f"lines: {len(found)}")
    if fan and (left := fan * len(sources) - len(found)):
        lines.append(f"note: {counted(left, 'direction')} off the surface left out")
    for reason in ("boundary", "non-manifold edge"):
        if count := sum(path.stop == reason for path in found):
            end = "ends" if count == 1 else "end"
            lines.append(f"note: {counted(count, 'line')} {end} before the length, at a {reason}")
    job.finish(mesh, {"sources": sources.report(), "length": length, "lines": reports}, lines)
