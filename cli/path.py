"""``geomhw path``: shortest paths."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli import options
from geomhw_cli.options import CURVE_FILES, INPUT, OptionGroup, command, flag, option, points_option
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, curve_line, curve_report, write_curves
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.sources import MAX_IN_LINE, SourceSpecs, source_pairs

if TYPE_CHECKING:
    from geomhw.geodesic.surface_path import SurfacePath
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh


@command(
    OptionGroup(
        "Input",
        points_option("--from starts", "Start; of several points, the nearest. May be repeated."),
        points_option("--to ends", "End; each of several points gets a path. May be repeated."),
        points_option("--via stops", "Point that the path goes through, in order. May be repeated."),
        flag("--loop", "Close the path from its last point to its first."),
        option("--pairs", "FILE", INPUT, "Instead: a path for each line, from its first point to its second."),
    ),
    CURVE_FILES,
    options.REPORT,
)
def path(
    mesh_path: Path,
    starts: SourceSpecs,
    ends: SourceSpecs,
    stops: SourceSpecs,
    loop: bool,
    pairs: Path | None,
    files: dict[str, Any],
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
    """
    from geomhw.geodesic.shortest_paths import ShortestPaths
    from geomhw.geodesic.surface_path import polylines
    from geomhw.mesh.surface_points import concatenate
    from geomhw.render.curve_pictures import curve_picture

    given = bool(starts.specs or ends.specs or stops.specs or loop)
    if pairs and given:
        raise click.UsageError("--pairs excludes --from, --to, --via and --loop.")
    if not pairs and not (starts.specs and (ends.specs or (loop and stops.specs))):
        raise click.UsageError("A path needs --from and --to, or --pairs; a loop needs --from and --to or --via.")
    read = source_pairs(pairs) if pairs else []
    job = Job.plan("path", mesh_path, **files, **report, extensions=CURVE_EXTENSIONS)
    mesh = job.read()
    with job.stage("compute"):
        solver = ShortestPaths(mesh)
        if pairs:
            firsts = [_one(mesh, pair.start, pair.origin, job) for pair in read]
            seconds = [_one(mesh, pair.end, pair.origin, job) for pair in read]
            found = solver.between(concatenate(firsts), concatenate(seconds))
        elif loop or stops.specs:
            found = [_through(solver, mesh, starts, stops, ends, loop, job)]
        else:
            found = solver.to_nearest(starts.resolve(mesh, job.remarks), ends.resolve(mesh, job.remarks))
    begins, finishes = (concatenate([path.end(k) for path in found]) for k in (0, -1))
    job.write(
        polylines(found),
        lambda cloud, look: curve_picture(mesh, cloud, begins, finishes, look),
        write_curves,
    )
    reports = [curve_report(path) for path in found]
    lines = [f"path: {curve_line(item)}" for item in reports[:MAX_IN_LINE]]
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
