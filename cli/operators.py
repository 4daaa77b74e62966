"""``geomhw operators``: the matrices themselves."""

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


@click.command(no_args_is_help=True)
@options.mesh_argument
@click.option("--gradient", "operator", flag_value="gradient", help=OPERATORS["gradient"])
@click.option("--divergence", "operator", flag_value="divergence", help=OPERATORS["divergence"])
@click.option("--stiffness", "operator", flag_value="stiffness", help=OPERATORS["stiffness"])
@click.option("--mass", "operator", flag_value="mass", help=OPERATORS["mass"])
@click.option("--consistent-mass", "operator", flag_value="consistent-mass", help=OPERATORS["consistent-mass"])
@click.option("--faces-to-vertices", "operator", flag_value="faces-to-vertices", help=OPERATORS["faces-to-vertices"])
@click.option("--vertices-to-faces", "operator", flag_value="vertices-to-faces", help=OPERATORS["vertices-to-faces"])
@click.option("--connection", "operator", flag_value="connection", help=OPERATORS["connection"])
@click.option("--complex-connection", "operator", flag_value="complex-connection", help=OPERATORS["complex-connection"])
@click.option("-o", "--output", metavar="FILE", type=options.FILE, required=True, help="Matrix: .npz (scipy) or .mtx.")
@options.quiet_option
def operators(mesh_path: Path, operator: str | None, output: Path, quiet: bool) -> None:
    """Write one of the sparse operators on MESH as a matrix.

    n vertices, m faces; vectors are stored x, y, z: row 3f+k is component k on face f.

    \b
    Example: geomhw operators moomoo.off --connection -o C.npz
    """
    from geomhw.io import check_outputs, read_mesh
    from geomhw.io.matrix import WRITABLE_MATRICES, write_matrix
    from geomhw.operators import averaging, connection, gradient, laplacian

    if operator is None:
        raise click.UsageError(f"Choose an operator: {', '.join('--' + name for name in OPERATORS)}.")
    check_outputs([output], [mesh_path], extensions=WRITABLE_MATRICES)
    build = {
        "gradient": gradient.gradient,
        "divergence": gradient.divergence,
        "stiffness": laplacian.stiffness,
        "mass": laplacian.lumped_mass,
        "consistent-mass": laplacian.consistent_mass,
        "faces-to-vertices": averaging.faces_to_vertices,
        "vertices-to-faces": averaging.vertices_to_faces,
        "connection": connection.connection_stiffness,
        "complex-connection": connection.complex_connection_stiffness,
    }[operator]
    matrix = build(read_mesh(mesh_path))
    write_matrix(output, matrix)
    if not quiet:
        rows, columns = matrix.shape
        click.echo(f"wrote {output}: {operator}, {rows} x {columns}, {matrix.nnz} entries")
