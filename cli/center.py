"""``geomhw center``: Karcher mean and geometric median."""

from collections.abc import Sequence
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, flag, option
from geomhw_cli.output_options import POINT_FILES
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, write_points
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.curves import read_curves
from geomhw_cli.specs.files import Spec, add_input
from geomhw_cli.specs.sources import SourceSpecs, source_files, source_line

if TYPE_CHECKING:
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: Paths to the center in a picture, at most.
MOST_PATHS = 200


def parse_points(texts: Sequence[str]) -> list[SourceSpecs | Path]:
    """Parse points: tables and clouds by their extension, other files as lists of sources, other texts as sources."""
    parts = list[SourceSpecs | Path]()
    for text in texts:
        path = Path(text.strip())
        if path.suffix.lower() in CURVE_EXTENSIONS and "=" not in text:
            add_input(path)
            parts.append(path)
        else:
            parts.append(SourceSpecs.parse([f"@{path}" if isfile(path) else text]))
    return parts


@command(
    OptionGroup(
        "Input",
        option(
            "--points parts",
            "FILE|SPEC",
            Spec(source_files),
            "Points: a file as written by -o of sample, or with columns x, y, z, .csv or .vtp; a text file of points; "
            "or points written as in --source of geodesic: 12,40, face:17, near:X,Y,Z and so on. May be repeated.",
            multiple=True,
            required=True,
            callback=lambda _context, _option, texts: parse_points(texts),
        ),
        flag("--median", "Minimize the sum of distances, not of their squares."),
    ),
    POINT_FILES,
    options.REPORT,
)
def center(
    mesh_path: Path,
    parts: Sequence[SourceSpecs | Path],
    median: bool,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Find the center of points on MESH: the Karcher mean, of least sum of squared exact distances.

    If several centers are equally good, all that are found are reported and written. Without -o, writes
    <stem>.center.vtp and .png to the current directory. With -o, writes those files, and a picture, with the shortest
    paths to the center, only with --png.

    \b
    Arrays per point: vertex (-1 within faces), face, barycentric (3).
    Columns of .csv:  vertex, x, y, z, face, b0, b1, b2.

    \b
    Examples:
      geomhw center data/creature.obj --points 0,100,700 -o center.vtp --png center.png
      geomhw center data/torus.off --points 0,3,face:17 --median --no-png --json
    """
    from geomhw.geodesic.shortest_paths import ShortestPaths
    from geomhw.geodesic.surface_path import polylines
    from geomhw.mesh.surface_points import concatenate
    from geomhw.render.curve_pictures import curve_picture
    from geomhw.results import point_cloud
    from geomhw.transport.surface_means import geometric_median, karcher_mean

    job = Job.plan("center", mesh_path, **files, **report, extensions=CURVE_EXTENSIONS)
    mesh = job.read()
    with job.stage("compute"):
        points = concatenate([_resolved(part, mesh, job) for part in parts])
        found = (geometric_median if median else karcher_mean)(mesh, points)
        centers = concatenate([found.point, *([found.others] if found.others else [])])

    def picture(_cloud: Any, look: Any) -> Any:
        paths = ShortestPaths(mesh).to_nearest(found.point, points)[:MOST_PATHS]
        return curve_picture(mesh, polylines(paths), points, centers, look)

    job.write(point_cloud(mesh, centers), picture, write_points, mesh)
    name, what = ("median", "distances") if median else ("mean", "squared distances")
    lines = [
        source_line(found.point.report(), name),
        f"sum: {found.value:.10g}, of {what} from {counted(len(points), 'point')}",
    ]
    if found.others:
        lines.append(f"note: the {name} is not unique: {counted(len(found.others), 'other')} with the same sum found")
    answers = {
        "center": found.point.report()[0],
        "position": found.point.positions(mesh)[0].tolist(),
        "sum": found.value,
        "distances": found.distances.tolist(),
        "last_step": found.last_step,
        "steps": found.steps,
        "others": found.others.report() if found.others else [],
    }
    job.finish(mesh, {"median": median, "points": points.report(), **answers}, lines)


def _resolved(part: SourceSpecs | Path, mesh: "TriangleMesh", job: Job) -> "SurfacePoints":
    """The points of a file or of specs."""
    from geomhw.mesh.surface_points import concatenate

    return concatenate(read_curves(part, mesh)) if isinstance(part, Path) else part.resolve(mesh, job.remarks)
