"""``geomhw geodesic``: geodesic distance by the heat method."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from geomhw.options import HEAT_METHOD, Boundary, GeodesicPanel
from geomhw_cli import options
from geomhw_cli.options import FILE, Choice, OptionGroup, choice, command, flag, option
from geomhw_cli.runtime.distance_batch import compute_distances
from geomhw_cli.runtime.job import Job, robust_line
from geomhw_cli.specs.queries import DistanceQueries
from geomhw_cli.specs.sources import SourceSpecs, shortened, source_line


@command(
    OptionGroup(
        "Input",
        options.SOURCE,
        flag("--all-pairs", "Distances between all vertices: a matrix, -o D.npy."),
        option("--pairs", "FILE", FILE, "Distances from a source to a vertex, one pair per line: -o D.csv or D.npy."),
        option(
            "--sources source_file",
            "FILE",
            FILE,
            "Distances to all vertices from one set of sources per line: -o D.npy.",
        ),
    ),
    OptionGroup(
        "Method",
        option(
            "--time",
            "T",
            str,
            f"Diffusion time: {options.TIME_HELP}. h is the mean edge length; auto is sqrt-h if that is near h2 and "
            "more accurate on MESH, else h2.",
            default="auto",
        ),
        options.ROBUST,
        click.Option(
            ["--refine/--no-refine"],
            default=None,
            help="Correct the distances by unfolding triangle after triangle.  [default: with --robust]",
        ),
        choice(
            "--boundary",
            Boundary,
            "Boundary condition of the heat flow: no flux, zero heat, or the mean of both solutions, which is the most "
            "accurate near the boundary.",
        ),
        options.SOLVER,
        name="method",
    ),
    options.FIELD_FILES,
    OptionGroup(
        "Output",
        click.Option(
            ["--panel", "panels"],
            type=Choice(GeodesicPanel),
            multiple=True,
            default=HEAT_METHOD,
            help="Panel of the picture. May be repeated.",
        ),
        flag("--single", "Single precision, with --all-pairs, --pairs or --sources."),
    ),
    options.REPORT,
)
def geodesic(
    mesh_path: Path,
    sources: SourceSpecs,
    all_pairs: bool,
    pairs: Path | None,
    source_file: Path | None,
    method: dict[str, Any],
    files: dict[str, Any],
    panels: tuple[str, ...],
    single: bool,
    report: dict[str, Any],
) -> None:
    """Compute geodesic distance on MESH by the heat method.

    Distances are from the nearest of the source points. Without -o, writes <stem>.geodesic.vtk and .png to the current
    directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per vertex: heat, divergence, distance (inf on components without a source).
    Arrays per face:   heat_gradient, direction (-grad u / |grad u|).

    The error of the heat method is a few percent, and largest near the source. --refine reduces it to a few tenths of
    a percent.

    With --robust, arrays per vertex are computed on the intrinsic Delaunay triangulation. Arrays per face are computed
    from u on the faces of MESH, and are zero on faces of zero area.

    --all-pairs, --pairs and --sources write distances only, one row per set of sources, in memory that does not grow
    with the number of rows. An interrupted run leaves D.partial.npy; the same command resumes it.

    \b
    Examples:
      geomhw geodesic data/creature.obj --source 0 -o creature.vtp --png creature.png
      geomhw geodesic data/strip.off --source boundary --source face:17:0.2,0.3,0.5 --no-png
      geomhw geodesic data/creature.obj --all-pairs -o D.npy
    """
    others = {"--source": sources.specs, "--png": files["png"]}
    if queries := DistanceQueries.parse(all_pairs, pairs, source_file, single, others):
        dtype = "<f4" if single else "<f8"
        compute_distances(Job("geodesic", mesh_path, files["outputs"], **report), queries, dtype, method)
        return
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.render.pictures import geodesic_picture

    job = Job.plan("geodesic", mesh_path, sources.paths, **files, **report)
    mesh = job.read()
    with job.stage("compute"):
        solver = HeatDistance(mesh, **method)
        result = solver.from_sources(sources.resolve(mesh))
    job.write(result, partial(geodesic_picture, panels=panels))
    answers = result.report
    farthest, t = answers["farthest"], answers["time"]
    lines = [
        source_line(answers["sources"]),
        f"time: t = {t['t']:.6g} ({t['reason']})",
        f"farthest: vertex {farthest['vertex']} at {farthest['distance']:.10g}",
    ]
    if "robust" in answers:
        lines.append(robust_line(answers["robust"]))
    if answers["refined"]:
        lines.append("refined: by unfolding from triangle to triangle")
    if wrong := answers.get("too_short_distances"):
        lines.append(f"warning: {wrong} distances are less than half the straight line: wrong; compute with --robust")
    if unreached := answers["unreachable_vertices"]:
        lines.append(f"warning: {unreached} vertices lie on components without a source; their distance is inf")
    if raised := answers.get("below_zero"):
        lines.append(
            f"warning: {raised['vertices']} vertices came out below zero, the lowest at {raised['lowest']:.4g}; "
            "they have the straight distance through space to the nearest source instead"
        )
    job.finish(mesh, shortened(answers) | {"profile": {"seconds": solver.stages.seconds}}, lines)
