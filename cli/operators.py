"""``geomhw operators``: sparse operators written as matrices."""

from pathlib import Path

import click

from geomhw_cli.options import OUTPUT, QUIET, OptionGroup, command, flag, option
from geomhw_cli.specs.files import read_input, require_writable

#: Operators by option: the function in `geomhw.operators` and a description.
OPERATORS = {
    "gradient": ("gradient", "Piecewise linear gradient, 3m x n."),
    "divergence": ("divergence", "Integrated divergence of fields on faces, n x 3m."),
    "stiffness": ("stiffness", "Cotan stiffness, n x n."),
    "mass": ("lumped_mass", "Lumped mass, n x n."),
    "consistent-mass": ("consistent_mass", "Galerkin mass, n x n."),
    "faces-to-vertices": ("faces_to_vertices", "Area-weighted average FtoV, n x m."),
    "vertices-to-faces": ("vertices_to_faces", "Average VtoF, m x n."),
    "connection": ("connection_stiffness", "Connection stiffness of the vertex normals, 3n x 3n."),
    "complex-connection": ("complex_connection_stiffness", "The same for complex tangent vectors, n x n."),
}


@command(
    OptionGroup("Operators", *(flag(f"--{name}", description) for name, (_, description) in OPERATORS.items())),
    OptionGroup("Output", option("-o --output", "FILE", OUTPUT, "Matrix: .npz (scipy) or .mtx.", required=True), QUIET),
)
def operators(mesh_path: Path, output: Path, quiet: bool, **flags: bool) -> None:
    """Write a sparse operator on MESH as a matrix.

    n is the number of vertices, m of faces. Vectors are stored x, y, z: row 3f+k is component k on face f.

    \b
    Example:
      geomhw operators data/torus.off --connection -o C.npz
    """
    from geomhw import operators as library
    from geomhw.io import WRITABLE_MATRICES, write_matrix

    chosen = [name for name in OPERATORS if flags[name.replace("-", "_")]]
    if len(chosen) != 1:
        what = "Choose one operator per file" if chosen else "Choose an operator"
        raise click.UsageError(f"{what}: {', '.join('--' + name for name in chosen or OPERATORS)}.")
    require_writable([output], WRITABLE_MATRICES)
    matrix = getattr(library, OPERATORS[chosen[0]][0])(read_input(mesh_path).mesh)
    write_matrix(output, matrix)
    if not quiet:
        rows, columns = matrix.shape
        click.echo(f"wrote {output}: {chosen[0]}, {rows} x {columns}, {matrix.nnz} entries")
