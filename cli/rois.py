"""``geomhw rois``: geodesic disks round vertices as regions of interest."""

from pathlib import Path
from typing import Any

from geomhw.options import OverlapName
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, choice, command, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.fields import array_files
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.numbers import POSITIVE

#: Disks at most; each is an array of the output.
MOST = 10_000


@command(
    OptionGroup(
        "Method",
        options.points_option("--center centers", "Center of a disk, a vertex. May be repeated."),
        option("--radius", "R", POSITIVE, "Geodesic distance from the center, in mesh units."),
        option("--gaussian sigma", "S", POSITIVE, "Weights exp(-d²/2S²) that sum to 1 over each disk."),
        choice(
            "--overlap",
            OverlapName,
            "allow: disks overlap. closest: a vertex is in the disk of the nearest center only. exclude: a vertex "
            "within R of several centers is in no disk.",
        ),
        option(
            "--signed",
            "FILE:ARRAY",
            Spec(array_files),
            "Instead: the distance to the region of vertices where this array is not zero, negative within it.",
        ),
    ),
    FIELD_FILES,
    options.REPORT,
)
def rois(
    mesh_path: Path,
    centers: Any,
    radius: float | None,
    sigma: float | None,
    overlap: OverlapName,
    signed: str | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Make regions of interest on MESH: the vertices within a geodesic distance of each center.

    Distances are exact. Without -o, writes <stem>.rois.vtk and .png to the current directory.

    \b
    Arrays per vertex: roi_V for each center V: 1 inside and 0 outside, or with --gaussian the weight; or
                       signed_distance.

    \b
    Examples:
      geomhw rois data/creature.obj --center 12 --center 700 --radius 0.3 -o rois.vtp
      geomhw rois data/creature.obj --center 12,700 --radius 1 --gaussian 0.4 --overlap closest -o rois.func.gii
    """
    import click
    import numpy as np

    from geomhw.errors import ArgumentError, FieldError
    from geomhw.io import read_field
    from geomhw.render import scalar_picture
    from geomhw.results import Field, Result
    from geomhw.scalars import geodesic_disks, signed_distance

    job = Job.plan("rois", mesh_path, **files, **report)
    mesh = job.read()
    if signed:
        if centers.specs or radius:
            raise click.UsageError("--signed takes no --center and no --radius.")
        with job.stage("compute"):
            field = read_field(signed, mesh)
            if field.location != "vertex" or np.ndim(field.values) != 1:
                raise FieldError(f"{signed} is no region; it needs one number per vertex")
            values = signed_distance(mesh, np.asarray(field.values) != 0)
        job.write(Result(mesh, [Field("signed_distance", "vertex", values)]), scalar_picture)
        finite = values[np.isfinite(values)]
        answers: dict[str, Any] = {"signed": signed, "least": float(finite.min()), "largest": float(finite.max())}
        job.finish(mesh, answers, [f"distance: {finite.min():.6g} inside to {finite.max():.6g} outside"])
        return
    if not centers.specs or radius is None:
        raise click.UsageError("Give a --center and a --radius, or --signed.")
    vertices = list(dict.fromkeys(centers.vertices(mesh)))
    if len(vertices) > MOST:
        raise ArgumentError(f"{len(vertices)} disks are too many arrays for a file; give {MOST} at most")
    with job.stage("compute"):
        disks = geodesic_disks(mesh, vertices, radius, sigma, overlap)
    arrays = [Field(f"roi_{v}", "vertex", disk) for v, disk in zip(vertices, disks.T, strict=True)]
    job.write(Result(mesh, arrays), scalar_picture)
    sizes = (disks > 0).sum(axis=0)
    areas = mesh.vertex_areas @ (disks > 0)
    rows = [
        {"center": v, "vertices": int(size), "area": float(area)}
        for v, size, area in zip(vertices, sizes, areas, strict=True)
    ]
    answers = {"radius": radius, "gaussian": sigma, "overlap": overlap, "rois": rows}
    lines = [f"rois: {len(rows)}, {sizes.min()} to {sizes.max()} vertices, area {areas.min():.6g} to {areas.max():.6g}"]
    job.finish(mesh, answers, lines)
