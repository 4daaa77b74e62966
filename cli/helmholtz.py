"""``geomhw helmholtz``: a field as curl-free + divergence-free + harmonic."""

from functools import partial
from pathlib import Path

import click

from geomhw_cli import options
from geomhw_cli.runtime.job import Job


@click.command(no_args_is_help=True, short_help="A field as curl-free + coexact + harmonic.")
@options.mesh_argument
@click.option(
    "--field",
    "field_spec",
    metavar="FILE:ARRAY",
    required=True,
    help="Vector field per face or per vertex: an array of a mesh file, a .npy file, or columns of a CSV.",
)
@options.output_option
@options.png_option
@options.no_png_option
@options.width_option
@options.json_option
@options.quiet_option
def helmholtz(
    mesh_path: Path,
    field_spec: str,
    outputs: tuple[Path, ...],
    png: Path | None,
    no_png: bool,
    width: int,
    as_json: bool,
    quiet: bool,
) -> None:
    """Helmholtz-Hodge decomposition of a vector field on MESH.

    The tangential part of the field becomes a gradient (curl-free), a turned gradient (coexact) and a harmonic part;
    the last two are divergence-free. Without -o, writes <stem>.helmholtz.vtk and .png into the current directory.

    \b
    Arrays, per face:   field, curl_free, divergence_free, coexact, harmonic.
    Arrays, per vertex: potential, stream_function.

    \b
    Example, of the directions away from a point:
      geomhw geodesic data/torus.off -o torus.vtp
      geomhw helmholtz data/torus.off --field torus.vtp:direction -o parts.vtp
    """
    from geomhw.flow.helmholtz import HelmholtzDecomposition
    from geomhw.flow.tangent_fields import face_vectors
    from geomhw.io import field_file, read_field
    from geomhw.render.pictures import helmholtz_picture

    job = Job.plan(
        "helmholtz",
        mesh_path,
        outputs=outputs,
        png=png,
        no_png=no_png,
        as_json=as_json,
        quiet=quiet,
        inputs=[field_file(field_spec)],
    )
    mesh = job.read()
    with job.stage("read field"):
        field = read_field(field_spec, mesh)
    with job.stage("compute"):
        result = HelmholtzDecomposition(mesh)(face_vectors(mesh, field))
    job.write(result, partial(helmholtz_picture, width=width))
    shares = result.report["energy_shares"]
    lines = [
        f"{name.replace('_', '-')}: {shares[name]:.4%} of the energy" for name in ("curl_free", "coexact", "harmonic")
    ]
    missing = abs(shares["curl_free"] + shares["coexact"] + shares["harmonic"] - 1)
    if result.report["energy"] and missing > 1e-6:
        lines.append(f"warning: the parts' energies miss the whole by {missing:.1e}; the mesh has too thin slivers")
    if (lost := result.report["normal_part_removed"]) > 1e-12:
        lines.append(f"note: the field's part normal to the faces ({lost:.4%} of the energy) is left out")
    job.finish(mesh, result.report, lines)
