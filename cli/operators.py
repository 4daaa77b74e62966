"""``geomhw operators``: the matrices themselves."""

from collections.abc import Callable
from pathlib import Path

import click

from geomhw_cli import options

OPERATORS = {
    "gradient": "piecewise-linear gradient, 3m x n",
    "divergence": "integrated divergence of face fields, n x 3m",
    "stiffness": "cotan stiffness, n x n",
    "mass": "lumped mass, n x n",
    "consistent-mass": "Galerkin mass, n x n",
    "faces-to-vertices": "area-weighted average FtoV, n x m",
    "vertices-to-faces": "average VtoF, m x n",
    "connection": "connection stiffness of the normals, 3n x 3n",
    "complex-connection": "the same on complex tangent vectors, n x n",
}


def operator_options(command: Callable[..., None]) -> Callable[..., None]:
    """A flag for each operator."""
    for name, shape in reversed(OPERATORS.items()):
        command = click.option(f"--{name}", is_flag=True, help=shape)(command)
    return command


@click.command(no_args_is_help=True, short_help="The sparse operators as matrices.")
@options.mesh_argument
@operator_options
@click.option("-o", "--output", metavar="FILE", type=options.FILE, required=True, help="Matrix: .npz (scipy) or .mtx.")
@options.quiet_option
def operators(mesh_path: Path, output: Path, quiet: bool, **flags: bool) -> None:
    """Write one of the sparse operators on MESH as a matrix.

    n vertices, m faces; vectors are stored x, y, z: row 3f+k is component k on face f.

    \b
    Example:
      geomhw operators data/torus.off --connection -o C.npz
    """
    from geomhw import operators as library
    from geomhw.io import WRITABLE_MATRICES, check_outputs, read_mesh, write_matrix

    asked = [name for name in OPERATORS if flags[name.replace("-", "_")]]
    if len(asked) != 1:
        what = "Choose one operator a file" if asked else "Choose an operator"
        raise click.UsageError(f"{what}: {', '.join('--' + name for name in asked or OPERATORS)}.")
    (operator,) = asked
    check_outputs([output], [mesh_path], extensions=WRITABLE_MATRICES)
    build = {
        "gradient": library.gradient,
        "divergence": library.divergence,
        "stiffness": library.stiffness,
        "mass": library.lumped_mass,
        "consistent-mass": library.consistent_mass,
        "faces-to-vertices": library.faces_to_vertices,
        "vertices-to-faces": library.vertices_to_faces,
        "connection": library.connection_stiffness,
        "complex-connection": library.complex_connection_stiffness,
    }[operator]
    matrix = build(read_mesh(mesh_path))
    write_matrix(output, matrix)
    if not quiet:
        rows, columns = matrix.shape
        click.echo(f"wrote {output}: {operator}, {rows} x {columns}, {matrix.nnz} entries")
