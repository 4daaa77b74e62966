"""``geomhw path``: shortest paths."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import INPUT, OptionGroup, command, flag, option, points_option
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
from geomhw_cli.specs.curves import read_curves
from geomhw_cli.specs.queries import pairs_digest
from geomhw_cli.specs.shards import WHOLE, ShardPart, shard_option
from geomhw_cli.specs.sources import MAX_IN_LINE, MAX_REPORTED, SourceSpecs, source_pairs

if TYPE_CHECKING:
    from geomhw.geodesic.surface_path import SurfacePath
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: Ends of a curve are one point if they are nearer, as a share of its extent.
SAME = 1e-9


@command(
    OptionGroup(
        "Input",
        points_option("--from starts", "Start; of several points, the nearest. May be repeated."),
        points_option("--to ends", "End; each of several points gets a path. May be repeated."),
        points_option("--via stops", "Point that the path goes through, in order. May be repeated."),
        flag("--loop", "Close the path from its last point to its first."),
        option("--pairs", "FILE", INPUT, "Instead: a path for each line, from its first point to its second."),
        option(
            "--straighten",
            "FILE",
            INPUT,
            "Instead: shorten the curves of this file, .csv or .vtp as written by -o, or a line of points for each, to "
            "geodesics without passing over holes or handles. A curve that ends where it starts is a loop.",
        ),
    ),
    CURVE_FILES,
    OptionGroup(CURVE_FILES.title, shard_option("pairs of --pairs", "such as -o paths.K.shard")),
    options.REPORT,
)
def path(
    mesh_path: Path,
    starts: SourceSpecs,
    ends: SourceSpecs,
    stops: SourceSpecs,
    loop: bool,
    pairs: Path | None,
    straighten: Path | None,
    files: dict[str, Any],
    shard: ShardPart | None,
    report: dict[str, Any],
) -> None:
    """Find shortest paths on MESH between vertices or points within faces.

    The length of a path is the exact distance on the triangles. A path is straight across edges. It turns only at
    vertices of a total angle of at least 360 degrees, and on boundaries. Without -o, writes <stem>.path.vtp and .png to
    the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per point: path, face, barycentric (3), arc_length. Field data: length (per path).
    Columns of .csv:  path, x, y, z, face, b0, b1, b2, arc_length.

    \b
    Examples:
      geomhw path data/creature.obj --from 0 --to max-y -o path.vtp --png path.png
      geomhw path data/creature.obj --from 0 --via 100 --to face:17 --no-png -o path.csv
      geomhw path data/torus.off --from 0 --via 40 --via 80 --loop -o loop.vtp
      geomhw path data/torus.off --straighten loop.vtp -o geodesic.vtp
    """
    from geomhw.geodesic.shortest_paths import ShortestPaths
    from geomhw.geodesic.surface_path import polylines
    from geomhw.mesh.surface_points import concatenate
    from geomhw.render.curve_pictures import curve_picture

    points_given = bool(starts.specs or ends.specs or stops.specs)
    if pairs and (points_given or loop or straighten):
        raise click.UsageError("--pairs excludes --from, --to, --via, --loop and --straighten.")
    if straighten and points_given:
        raise click.UsageError("--straighten excludes --from, --to and --via.")
    if not (pairs or straighten) and not (starts.specs and (ends.specs or (loop and stops.specs))):
        raise click.UsageError("A path needs --from and --to, or --pairs; a loop needs --from and --to or --via.")
    read = source_pairs(pairs) if pairs else []
    if shard:
        require_curve_shard("--pairs", pairs is not None, files)
    part = shard or WHOLE
    job = Job.plan("path", mesh_path, **files, **report, extensions=[".shard"] if shard else CURVE_EXTENSIONS)
    mesh = job.read()
    with job.stage("compute"):
        few = len(read) <= MAX_REPORTED and (not ends.specs or len(ends.resolve(mesh)) <= MAX_REPORTED)
        solver = ShortestPaths(mesh, ties=few)
        curves = read_curves(straighten, mesh) if straighten else []
        loops = [loop or _is_closed(mesh, points) for points in curves]
        if straighten:
            found = [_straightened(mesh, *curve) for curve in zip(curves, loops, strict=True)]
        elif pairs:
            firsts = [_one(mesh, pair.start, pair.origin, job) for pair in read]
            seconds = [_one(mesh, pair.end, pair.origin, job) for pair in read]
            numbered = solver.by_pair(concatenate(firsts), concatenate(seconds), slice(part.number - 1, None, part.of))
            numbers = sorted(numbered)
            found = [numbered[i] for i in numbers]
        elif loop or stops.specs:
            found = [_through(solver, mesh, starts, stops, ends, loop, job)]
        else:
            found = solver.to_nearest(starts.resolve(mesh, job.remarks), ends.resolve(mesh, job.remarks))
    if shard:
        run = {"question": "path --pairs", "pairs": pairs_digest(read)}
        write_curve_shard(job, mesh, shard, run, dict(zip(numbers, found, strict=True)))
        return
    begins, finishes = (concatenate([path.end(k) for path in found]) for k in (0, -1))
    job.write(
        polylines(found),
        lambda cloud, look: curve_picture(mesh, cloud, begins, finishes, look),
        write_curves,
        mesh,
    )
    reports = [
        {
            **curve_report(path),
            "tied": path.tied if few and not curves else None,
            **({"loop": closed, "contractible": closed and len(path.faces) == 1} if curves else {}),
        }
        for path, closed in zip(found, loops or [loop] * len(found), strict=True)
    ]
    lines = [f"path: {curve_line(item)}" for item in reports[:MAX_IN_LINE]]
    if tied := sum(path.tied for path in found):
        end = "the end of a part of it" if loop or stops.specs else "the other end"
        lines.append(f"note: {counted(tied, 'path')} of several that are equally short; {end} is on the cut locus")
    if shrunk := sum(closed and len(path.faces) == 1 for closed, path in zip(loops, found, strict=False)):
        lines.append(f"note: {counted(shrunk, 'loop')} shrunk to a point: it bounds a disk")
    if len(found) > MAX_IN_LINE:
        lines.append(f"paths: {len(found)}, of length {sum(path.length for path in found):.10g} together")
    job.finish(mesh, {"paths": reports}, lines)


def _one(mesh: "TriangleMesh", specs: SourceSpecs, where: str, job: Job) -> "SurfacePoints":
    """The only point of some specs."""
    from geomhw.errors import FieldError

    points = specs.resolve(mesh, job.remarks)
    if len(points) != 1:
        raise FieldError(f"{where}a path goes from one point to one point, not {len(points)}")
    return points


def _through(
    solver: Any, mesh: "TriangleMesh", starts: SourceSpecs, stops: SourceSpecs, ends: SourceSpecs, loop: bool, job: Job
) -> "SurfacePath":
    """The path from one point through others in order."""
    from geomhw.mesh.surface_points import concatenate

    parts = [specs.resolve(mesh, job.remarks) for specs in (starts, stops, ends) if specs.specs]
    if len(parts[0]) > 1 or (ends.specs and len(parts[-1]) > 1):
        raise click.UsageError("With --via or --loop, --from and --to are one point each.")
    return solver.through(concatenate(parts), closed=loop)


def _is_closed(mesh: "TriangleMesh", points: "SurfacePoints") -> bool:
    """Whether a curve through points ends where it starts."""
    from numpy import ptp

    first, *_, last = points.positions(mesh)
    return len(points) > 2 and bool(abs(first - last).max() <= SAME * ptp(points.positions(mesh), axis=0).max())


def _straightened(mesh: "TriangleMesh", points: "SurfacePoints", closed: bool) -> "SurfacePath":
    """The geodesic to which a curve through points shortens."""
    import numpy as np

    from geomhw.geodesic.straightening import curve_through, straighten

    if closed and _is_closed(mesh, points):
        points = points[np.arange(len(points) - 1)]
    return straighten(curve_through(mesh, points, closed), closed)
