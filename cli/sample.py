"""``geomhw sample``: points spread over a surface."""

from pathlib import Path
from typing import Any

import click

from geomhw.options import SampleMethod
from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, choice, command, option
from geomhw_cli.output_options import POINT_FILES
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, write_points
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.numbers import POSITIVE, Number
from geomhw_cli.specs.sources import shortened

MAX_SAMPLES = 10_000_000


@command(
    OptionGroup(
        "Input",
        option("--count", "N", Number(1, MAX_SAMPLES, whole=True), "Number of points."),
        option(
            "--spacing",
            "R",
            POSITIVE,
            "Least distance between two points; as many points as fit. With --count, at most that number.",
        ),
        choice(
            "--method",
            SampleMethod,
            "farthest: vertices, each the farthest from all before it. poisson: random points within faces.",
        ),
        option(
            "--seed",
            "S",
            Number(0, 2**63 - 1, whole=True),
            "Seed of random points; with farthest, of a random first vertex.  [default: 0; farthest: max-y]",
        ),
    ),
    POINT_FILES,
    options.REPORT,
)
def sample(
    mesh_path: Path,
    count: int | None,
    spacing: float | None,
    method: SampleMethod,
    seed: int | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Spread points over MESH: farthest-point sampling, or Poisson discs, by exact distance.

    Farthest points cover the surface: with --spacing, no vertex is as far from all points. Without -o, writes
    <stem>.sample.vtp and .png to the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per point: vertex (-1 within faces), face, barycentric (3), gap (distance to the points before, -1 without).
    Columns of .csv:  vertex, x, y, z, face, b0, b1, b2, gap.

    \b
    Examples:
      geomhw sample data/creature.obj --count 100 -o points.vtp --png points.png
      geomhw sample data/sphere.off --spacing 0.3 --method poisson --seed 1 --no-png -o points.csv
    """
    import numpy as np

    from geomhw.geodesic.farthest_points import farthest_points
    from geomhw.geodesic.poisson_disks import poisson_disks
    from geomhw.render.cell_pictures import samples_picture
    from geomhw.results import Field, point_cloud

    if count is None and spacing is None:
        raise click.UsageError("A sample needs --count or --spacing.")
    job = Job.plan("sample", mesh_path, **files, **report, extensions=CURVE_EXTENSIONS)
    mesh = job.read()
    with job.stage("compute"):
        if method == "poisson":
            found = poisson_disks(mesh, spacing, count, seed or 0)
        else:
            used = np.unique(mesh.faces)
            first = None if seed is None else int(np.random.default_rng(seed).choice(used))
            found = farthest_points(mesh, count, spacing or 0.0, first)
    gaps = np.where(np.isfinite(found.gaps), found.gaps, -1.0)
    cloud = point_cloud(mesh, found.points, [Field("gap", "vertex", gaps)])
    job.write(cloud, lambda _cloud, look: samples_picture(mesh, found.points, look), write_points, mesh)
    least = found.spacing if np.isfinite(found.spacing) else None
    radius = found.radius if np.isfinite(found.radius) else None
    lines = [f"points: {len(found.points)}, {method}"]
    if least is not None:
        lines.append(f"spacing: {least:.10g}, the least distance of two points")
    if radius is not None:
        lines.append(f"radius: {radius:.10g}, the largest distance of a vertex from the points")
    else:
        lines.append("warning: a component has no point")
    if count and len(found.points) < count:
        lines.append(f"note: {counted(len(found.points), 'point')} fit with this spacing, fewer than {count}")
    answers = shortened({"sources": found.points.report()})
    answers = {"method": method, "count": len(found.points), "points": answers["sources"]}
    job.finish(mesh, {**answers, "seed": seed, "spacing": least, "radius": radius}, lines)
