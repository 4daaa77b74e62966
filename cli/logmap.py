"""``geomhw logmap``: polar coordinates around a point."""

from math import degrees, inf
from pathlib import Path
from typing import Any

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.numbers import LARGEST, SMALLEST, Number
from geomhw_cli.specs.sources import SourceSpecs, source_line


@command(
    OptionGroup(
        "Input",
        options.SOURCE,
        option(
            "--radius",
            "R",
            Number(SMALLEST, LARGEST),
            "Largest distance. Beyond it, radius is inf, angle and log are NaN.  [default: all of the surface]",
        ),
    ),
    FIELD_FILES,
    options.REPORT,
)
def logmap(
    mesh_path: Path, sources: SourceSpecs, radius: float | None, files: dict[str, Any], report: dict[str, Any]
) -> None:
    """Compute polar coordinates on MESH around a point: the logarithmic map.

    The radius is the exact distance, the angle the direction in which the shortest path starts, counterclockwise from
    the first edge of the vertex's first face, or of the face that contains the source. Angles around an inner vertex
    are scaled to sum to 360 degrees. Without -o, writes <stem>.logmap.vtk and .png to the current directory. With -o,
    writes those files, and a picture only with --png.

    \b
    Arrays per vertex: log (radius times the cosine and the sine of the angle), angle (radians), radius.

    \b
    Examples:
      geomhw logmap data/creature.obj --source 0 -o polar.vtp --png checkerboard.png
      geomhw logmap data/sphere.off --source face:17 --radius 1 --no-png
    """
    from geomhw.render.curve_pictures import log_picture
    from geomhw.transport.log_map import LogarithmicMap

    job = Job.plan("logmap", mesh_path, **files, **report)
    mesh = job.read()
    with job.stage("compute"):
        points = sources.resolve(mesh, job.remarks)
        result = LogarithmicMap(mesh).from_source(points, inf if radius is None else radius)
    job.write(result, log_picture)
    answers = result.report
    lines = [
        source_line(answers["sources"]),
        f"angle: {degrees(answers['total_angle']):.10g} degrees around the source",
        f"radius: up to {answers['largest_radius']:.10g}, at {counted(answers['vertices'], 'vertex', 'vertices')}",
    ]
    if radius is not None:
        answers = {**answers, "radius": radius}
        if answers["beyond"] == 0:
            lines.append(f"note: no vertex of the surface is beyond the radius {radius:g}")
    if answers["undefined_angles"]:
        where = counted(answers["undefined_angles"], "vertex", "vertices")
        lines.append(f"warning: {where} reached along edges of length zero have no angle: NaN")
    if answers["unreachable_vertices"]:
        where = f"{counted(answers['unreachable_vertices'], 'vertex', 'vertices')} on components without the source"
        lines.append(f"warning: {where}: radius inf")
    job.finish(mesh, answers, lines)
