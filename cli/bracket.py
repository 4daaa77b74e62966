"""``geomhw bracket``: the Lie bracket of two tangent fields."""

from pathlib import Path
from typing import Any

import click

from geomhw_cli import options
from geomhw_cli.options import OUTPUT, OptionGroup, command, option
from geomhw_cli.output_options import VECTOR_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs import fields


@command(
    OptionGroup(
        "Input",
        options.vector_field(
            "--field field_specs", f"U, then V, given twice: {fields.FLOW_FIELD_HELP}.", multiple=True
        ),
    ),
    VECTOR_FILES,
    OptionGroup(
        "Operator",
        option(
            "--commutator",
            "FILE",
            OUTPUT,
            "Also write D_U D_V - D_V D_U, the bracket as a matrix on functions at vertices: .npz (scipy) or .mtx.",
        ),
    ),
    options.REPORT,
)
def bracket(
    mesh_path: Path,
    field_specs: tuple[str, ...],
    commutator: Path | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Compute the Lie bracket [U, V] of two tangent fields on MESH.

    [U, V] f = U(V f) - V(U f) for functions f. It vanishes where the flows of the fields commute. The error falls with
    the square of the edge length if the fields are samples of smooth ones. Without -o, writes <stem>.bracket.vtk and
    .png to the current directory.

    \b
    Arrays per face: bracket, first, second (the tangential parts of U and V).

    \b
    Example, two rotations of the sphere:
      geomhw bracket data/sphere.off --field rigid:x --field rigid:y -o b.vtp
    """
    from geomhw.flow.field_derivatives import FieldDerivatives
    from geomhw.flow.tangent_fields import energy, tangential
    from geomhw.io import WRITABLE_MATRICES, write_matrix
    from geomhw.render.field_pictures import bracket_picture
    from geomhw.results import Field, Result

    if len(field_specs) != 2:
        raise click.UsageError(f"A bracket has two fields; give --field twice, not {len(field_specs)} times.")
    job = Job.plan("bracket", mesh_path, beside=[(commutator, WRITABLE_MATRICES)], **files, **report)
    mesh = job.read()
    with job.stage("read field"):
        U, V = (tangential(mesh, fields.flow(spec, mesh)) for spec in field_specs)
    with job.stage("compute"):
        derivatives = FieldDerivatives(mesh)
        arrays = {"bracket": derivatives.bracket(U, V), "first": U, "second": V}
        matrix = derivatives.commutator(U, V) if commutator else None
    energies = {name: energy(mesh, values) for name, values in arrays.items()}
    result = Result(mesh, [Field(name, "face", values) for name, values in arrays.items()], {"energies": energies})
    job.write(result, bracket_picture, beside=[(commutator, lambda path: write_matrix(path, matrix))])
    lines = [f"energy: {energies['bracket']:.6g}, of the fields {energies['first']:.6g} and {energies['second']:.6g}"]
    job.finish(mesh, {"fields": list(field_specs), **result.report}, lines)
