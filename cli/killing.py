"""``geomhw killing``: tangent fields nearest to isometries."""

from pathlib import Path
from typing import Any

import click

from geomhw.options import Connection, FieldBasis, FieldBoundary
from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import Choice, OptionGroup, choice, command, is_given, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.fields import array_files
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.numbers import Number
from geomhw_cli.specs.vertex_maps import MAP_HELP, metric, vertex_map

#: Fields at most; time and memory grow with the square of their number.
MAX_FIELDS = 1000
#: Energies in a line of the report.
SHOWN = 8


@command(
    OptionGroup(
        "Method",
        option("-k --fields", "N", Number(1, MAX_FIELDS, whole=True), "Number of fields, by energy.", default=6),
        choice("--boundary", FieldBoundary, "tangent: fields do not cross the boundary. free: they may."),
        click.Option(
            ["--connection"],
            type=Choice(Connection),
            help="normals: by fitted vertex normals. intrinsic: by angles and edge lengths alone, exact on flat "
            "metrics.  [default: intrinsic where all angle defects vanish, else normals]",
        ),
        choice(
            "--basis",
            FieldBasis,
            "vertices: any vectors at the vertices. coexact: combinations of divergence-free eigenfields, the turned "
            "gradients of eigenfunctions and the harmonic fields.",
        ),
        option("--eigenfields", "N", Number(1, 5000, whole=True), "Size of the coexact basis.", default=60),
        option(
            "--metric metric_spec",
            "FILE:ARRAY",
            Spec(array_files),
            "Coordinates per vertex, in space of any dimension, that define the edge lengths instead, such as those of "
            "a flat torus in four dimensions.",
        ),
    ),
    OptionGroup(
        "Symmetry",
        option("--symmetric", "FILE", Spec(array_files), f"Only fields that this vertex map preserves: {MAP_HELP}."),
        option("--antisymmetric", "FILE", Spec(array_files), "Only fields that this vertex map reverses."),
    ),
    FIELD_FILES,
    options.REPORT,
)
def killing(
    mesh_path: Path,
    fields: int,
    boundary: FieldBoundary,
    connection: Connection | None,
    basis: FieldBasis,
    eigenfields: int,
    metric_spec: str | None,
    symmetric: str | None,
    antisymmetric: str | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Compute the tangent fields on MESH that are nearest to isometries: approximate Killing fields.

    Energies are the integral of the squared strain over that of the squared length of the field. They are tiny for
    fields whose flow preserves all distances, such as rotations of a surface of revolution. The report says how many
    fields are below the largest gap. Fields have the square integral 1 and a fixed sign. Without -o, writes
    <stem>.killing.vtk and .png to the current directory.

    \b
    Arrays per face: killing_0, killing_1, ... (three components).

    \b
    Examples:
      geomhw killing data/sphere.off -k 6 --json
      geomhw killing data/torus.off -o k.vtp --png k.png
      geomhw killing data/genus2.off --basis coexact --no-png -o flows.vtp
    """
    from geomhw.render.field_pictures import killing_picture
    from geomhw.spectral.killing_fields import killing_fields

    if symmetric and antisymmetric:
        raise click.UsageError("--symmetric and --antisymmetric exclude each other.")
    symmetry_spec = symmetric or antisymmetric
    if metric_spec and (symmetry_spec or basis == "coexact" or connection == "normals"):
        raise click.UsageError(
            "--metric excludes --symmetric, --antisymmetric, --basis coexact and --connection normals."
        )
    if (symmetry_spec or basis == "coexact") and connection == "intrinsic":
        raise click.UsageError("--connection intrinsic excludes --symmetric, --antisymmetric and --basis coexact.")
    if basis == "coexact" and boundary == "free":
        raise click.UsageError("--basis coexact is for --boundary tangent.")
    if is_given("eigenfields") and basis != "coexact":
        raise click.UsageError("--eigenfields is for --basis coexact.")
    job = Job.plan("killing", mesh_path, **files, **report)
    mesh = job.read_oriented()
    with job.stage("compute"):
        same, opposite = (vertex_map(spec, mesh) if spec else None for spec in (symmetric, antisymmetric))
        surface = metric(metric_spec, mesh) if metric_spec else None
        result = killing_fields(mesh, fields, boundary, connection, basis, eigenfields, same, opposite, surface)
    job.write(result, killing_picture)
    answers = result.report
    energies, gap = answers["energies"], answers["gap"]
    shown = ", ".join(f"{value:.6g}" for value in energies[:SHOWN])
    lines = [f"energies: {shown}{' ...' if len(energies) > SHOWN else ''}"]
    if gap["fields"]:
        found = counted(gap["fields"], "Killing field")
        lines.append(f"gap: {found}; the next energy is {gap['ratio']:.3g} times as large")
    else:
        lines.append(f"gap: no Killing field; the largest ratio of neighboring energies is {gap['ratio']:.3g}")
    settings = {"metric": metric_spec, "symmetric": symmetric, "antisymmetric": antisymmetric}
    job.finish(mesh, {**answers, **{name: spec for name, spec in settings.items() if spec}}, lines)
