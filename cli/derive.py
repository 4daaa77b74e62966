"""``geomhw derive``: covariant derivative, divergence, curl, strain and Hodge Laplacian of a tangent field."""

from pathlib import Path
from typing import Any

from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command
from geomhw_cli.output_options import VECTOR_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs import fields


@command(
    OptionGroup(
        "Input",
        options.vector_field("--field", f"Vector field V: {fields.FLOW_FIELD_HELP}.", required=True),
        options.vector_field("--along", "Field U of the direction, written as --field.  [default: V]", default=None),
    ),
    VECTOR_FILES,
    options.REPORT,
)
def derive(mesh_path: Path, field: str, along: str | None, files: dict[str, Any], report: dict[str, Any]) -> None:
    """Compute the derivatives of a tangent field on MESH.

    The error falls with the square of the edge length if the field is a sample of a smooth one. Without -o, writes
    <stem>.derive.vtk and .png to the current directory.

    \b
    Arrays per face:   field (the tangential part of V), covariant_derivative (of V along U),
                       strain (symmetric part of the derivative, 9 components xx xy xz yx ...),
                       hodge_laplacian (-grad div V - n x grad curl V).
    Arrays per vertex: divergence, curl (positive counterclockwise).

    \b
    Example, of a rotation along itself:
      geomhw derive data/sphere.off --field rigid:z -o d.vtp
    """
    from geomhw.flow.field_derivatives import derivatives_of
    from geomhw.render.field_pictures import derivative_picture

    job = Job.plan("derive", mesh_path, **files, **report)
    mesh = job.read_oriented()
    with job.stage("read field"):
        V = fields.flow(field, mesh)
        U = fields.flow(along, mesh) if along else V
    with job.stage("compute"):
        result = derivatives_of(mesh, V, U)
    job.write(result, derivative_picture)
    sizes = result.report["root_mean_square"]
    lines = ["sizes: " + ", ".join(f"{name.replace('_', ' ')} {size:.4g}" for name, size in sizes.items())]
    job.finish(mesh, {"field": field, "along": along or field, **result.report}, lines)
