"""``geomhw geodesic``: distance by the heat method."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from geomhw.options import GeodesicPanel
from geomhw_cli import options
from geomhw_cli.runtime.distance_batch import DistanceBatch, batch_options
from geomhw_cli.runtime.job import Job, robust_line
from geomhw_cli.specs.queries import DistanceQueries
from geomhw_cli.specs.sources import SourceSpecs, shortened, source_line


@click.command(no_args_is_help=True, short_help="Distance by the heat method.")
@options.mesh_argument
@options.source_option
@batch_options
@options.time_option
@options.robust_option
@options.refine_option
@options.boundary_option
@options.solver_option
@options.output_option
@options.png_option
@options.no_png_option
@options.width_option
@click.option(
    "--panel",
    "panels",
    type=options.choice(GeodesicPanel),
    multiple=True,
    help="What the picture shows; may be repeated.  [default: heat, divergence, distance]",
)
@options.json_option
@options.quiet_option
def geodesic(
    mesh_path: Path,
    sources: SourceSpecs,
    all_pairs: bool,
    pairs: Path | None,
    source_file: Path | None,
    single: bool,
    time: str,
    robust: bool,
    refine: bool | None,
    boundary: Any,
    solver: Any,
    outputs: tuple[Path, ...],
    png: Path | None,
    no_png: bool,
    width: int,
    panels: tuple[str, ...],
    as_json: bool,
    quiet: bool,
) -> None:
    """Geodesic distance from one or several points of MESH, by the heat method.

    Without -o, writes <stem>.geodesic.vtk and <stem>.geodesic.png into the current directory; with -o, those files
    and a picture only if --png asks for one.

    \b
    Arrays, per vertex: heat, divergence, distance (inf where no source can be reached).
    Arrays, per face:   heat_gradient, direction (-grad u / |grad u|).

    The heat method is some percent off, most of all beside the source; --refine takes that to some tenths.

    With --robust, values at vertices are those of the intrinsic Delaunay triangulation; those on faces are taken from
    u on the faces of MESH, and are zero where these have no area.

    --all-pairs, --pairs and --sources write distances alone, a row a source, in memory that does not grow with their
    number. Interrupted, the same command goes on where it was; until all is there, it lies in D.partial.npy.

    \b
    Examples:
      geomhw geodesic data/creature.obj --source 0 -o creature.vtp --png creature.png
      geomhw geodesic data/strip.off --source boundary --source face:17:0.2,0.3,0.5 --no-png
      geomhw geodesic data/creature.obj --all-pairs -o D.npy
    """
    rest = {"source": sources.specs, "png": png, "single": single}
    if questions := DistanceQueries.parse(all_pairs, pairs, source_file, rest):
        choices = {"time": time, "robust": robust, "refine": refine, "boundary": boundary, "solver": solver}
        DistanceBatch.plan(mesh_path, questions, outputs, single, {**choices, "as_json": as_json, "quiet": quiet}).run()
        return
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.render.pictures import HEAT_METHOD, geodesic_picture

    job = Job.plan(
        "geodesic",
        mesh_path,
        outputs=outputs,
        png=png,
        no_png=no_png,
        as_json=as_json,
        quiet=quiet,
        inputs=sources.paths,
    )
    mesh = job.read()
    with job.stage("compute"):
        method = HeatDistance(mesh, time, robust, refine, boundary, solver)
        result = method.from_sources(sources.on(mesh))
    job.write(result, partial(geodesic_picture, width=width, panels=panels or HEAT_METHOD))
    report = result.report
    farthest, t = report["farthest"], report["time"]
    lines = [
        source_line(report["sources"]),
        f"time: t = {t['t']:.6g} ({t['reason']})",
        f"farthest: vertex {farthest['vertex']} at {farthest['distance']:.10g}",
    ]
    if robust:
        lines.append(robust_line(report["robust"]))
    if report["refined"]:
        lines.append("refined: by unfolding from triangle to triangle")
    if wrong := report.get("too_short_distances"):
        lines.append(f"warning: {wrong} distances are less than half the straight line: wrong; compute with --robust")
    if unreached := report["unreachable_vertices"]:
        lines.append(f"warning: {unreached} vertices lie on components without a source; their distance is inf")
    if raised := report.get("below_zero"):
        lines.append(
            f"warning: {raised['vertices']} vertices came out below zero, the lowest at {raised['lowest']:.4g}; "
            "they have the straight distance through space to the nearest source instead"
        )
    job.finish(mesh, shortened(report) | {"profile": {"seconds": method.stages.seconds}}, lines)
