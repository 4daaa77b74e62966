"""``geomhw voronoi``: geodesic Voronoi cells."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OUTPUT, OptionGroup, command, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, write_points
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.numbers import Number
from geomhw_cli.specs.sources import SourceSpecs, source_files, source_line

if TYPE_CHECKING:
    from geomhw.render.look import Look
    from geomhw.render.panels import Picture
    from geomhw.results import Result

MAX_ROUNDS, MAX_SITES = 1000, 1_000_000


def parse_sites(texts: Sequence[str]) -> SourceSpecs | int:
    """Parse sites: one whole number is a number of sites, everything else is points."""
    if len(texts) == 1 and re.fullmatch(r"\s*\d+\s*", texts[0]):
        count = int(texts[0][:18])
        if not 1 <= count <= MAX_SITES:
            raise click.UsageError(f"--sites: the number of sites is from 1 to {MAX_SITES}, not {texts[0]}.")
        return count
    return SourceSpecs.parse(texts)


@command(
    OptionGroup(
        "Input",
        option(
            "--sites",
            "SPEC|N",
            Spec(source_files),
            "Sites as points, written as in --source of geodesic: 3,40,99, face:17, @FILE and so on, or as curves, one "
            "site each; may be repeated. A single whole number: this number of vertices by farthest-point sampling.",
            multiple=True,
            required=True,
            callback=lambda _context, _option, texts: parse_sites(texts),
        ),
        option(
            "--relax",
            "K",
            Number(0, MAX_ROUNDS, whole=True),
            "Rounds in which each site moves to the mean of its cell (Lloyd).",
            default=0,
        ),
        option("--points points_path", "FILE", OUTPUT, "Sites as points, with their areas: .vtp or .csv."),
    ),
    FIELD_FILES,
    options.REPORT,
)
def voronoi(
    mesh_path: Path,
    sites: SourceSpecs | int,
    relax: int,
    points_path: Path | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Divide MESH into the geodesic Voronoi cells of sites: the nearest site of each vertex, by exact distance.

    Of equally near sites, the lower number counts. Faces between cells are divided where distances, interpolated from
    the corners, are equal; the areas of cells sum to that of the surface. Without -o, writes <stem>.voronoi.vtk and
    .png to the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per vertex: label (number of the site from 0, -1 without any), distance.
    Columns of --points: vertex, x, y, z, face, b0, b1, b2, area.

    \b
    Examples:
      geomhw voronoi data/creature.obj --sites 12 -o cells.vtk --png cells.png
      geomhw voronoi data/torus.off --sites 20 --relax 10 --no-png --points sites.csv
      geomhw voronoi data/sphere.off --sites 0,40 --sites face:17 --no-png --json
    """
    from geomhw.geodesic.farthest_points import farthest_points
    from geomhw.geodesic.voronoi import voronoi_cells
    from geomhw.render.cell_pictures import cells_picture
    from geomhw.results import Field, Result, point_cloud
    from geomhw.transport.relaxed_sites import relaxed_sites

    job = Job.plan("voronoi", mesh_path, beside=[(points_path, CURVE_EXTENSIONS)], **files, **report)
    mesh = job.read()
    with job.stage("compute"):
        points = (
            farthest_points(mesh, sites).points
            if isinstance(sites, int)
            else sites.resolve(mesh, job.remarks, curves=True)
        )
        if len(points.segments) and (relax or points_path):
            raise click.UsageError("--relax and --points are for sites that are points, not curves.")
        cells = voronoi_cells(mesh, relaxed_sites(mesh, points, relax))

    def write_sites(path: Path) -> None:
        write_points(point_cloud(mesh, cells.sites, [Field("area", "vertex", cells.areas)]), [path])

    def picture(result: "Result", look: "Look") -> "Picture":
        if cells.divided is not mesh:
            result = Result(
                cells.divided, [Field("label", "vertex", cells.divided_label)], result.report, result.sources
            )
        return cells_picture(result, cells.pieces, cells.piece_labels, cells.borders, look)

    job.write(cells.result, picture, beside=[(points_path, write_sites)])
    answers = cells.result.report
    areas = cells.areas
    lines = [
        source_line(answers["sites"], "sites"),
        f"areas: {areas.min():.6g} to {areas.max():.6g}, sum {areas.sum():.10g}",
        f"borders: {counted(len(cells.dual_edges), 'pair')} of neighbors, length {cells.border_lengths.sum():.10g}",
    ]
    if empty := answers["vertices"].count(0):
        lines.append(f"warning: {counted(empty, 'site')} nearest to no vertex, so with area 0")
    if far := answers["unreachable_vertices"]:
        lines.append(f"warning: {counted(far, 'vertex', 'vertices')} on components without a site: label -1")
    job.finish(mesh, {**answers, "relax": relax}, lines)
