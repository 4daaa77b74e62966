"""``geomhw helmholtz``: Helmholtz-Hodge decomposition of a vector field."""

from pathlib import Path
from typing import Any

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import VECTOR_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.fields import array_files
from geomhw_cli.specs.files import Spec

#: Largest share of the energy in the harmonic part of a mesh without handles.
SPURIOUS = 1e-9


@command(
    OptionGroup(
        "Input",
        option(
            "--field field_spec",
            "FILE:ARRAY",
            Spec(array_files),
            "Vector field per face or per vertex: an array of a mesh file, a .npy file, or columns of a CSV file.",
            required=True,
        ),
    ),
    VECTOR_FILES,
    options.REPORT,
)
def helmholtz(mesh_path: Path, field_spec: str, files: dict[str, Any], report: dict[str, Any]) -> None:
    """Decompose a vector field on MESH by the Helmholtz-Hodge theorem.

    The tangential part of the field is the sum of a gradient (curl-free), a rotated gradient (coexact) and a harmonic
    field. The last two are divergence-free. Without -o, writes <stem>.helmholtz.vtk and .png to the current directory.

    \b
    Arrays per face:   field, curl_free, divergence_free, coexact, harmonic.
    Arrays per vertex: potential, stream_function.

    \b
    Example, for the directions away from a point:
      geomhw geodesic data/torus.off -o torus.vtp
      geomhw helmholtz data/torus.off --field torus.vtp:direction -o parts.vtp
    """
    from geomhw.flow.helmholtz import HelmholtzDecomposition
    from geomhw.flow.tangent_fields import face_vectors
    from geomhw.io import read_field
    from geomhw.render.pictures import helmholtz_picture

    job = Job.plan("helmholtz", mesh_path, **files, **report)
    mesh = job.read()
    with job.stage("read field"):
        field = read_field(field_spec, mesh)
    with job.stage("compute"):
        result = HelmholtzDecomposition(mesh)(face_vectors(mesh, field))
    job.write(result, helmholtz_picture)
    answers = result.report
    shares = {name: answers["energy_shares"][name] for name in ("curl_free", "coexact", "harmonic")}
    lines = [f"{name.replace('_', '-')}: {share:.4%} of the energy" for name, share in shares.items()]
    if pinched := answers.get("pinched_vertices", 0):
        where = counted(pinched, "vertex", "vertices")
        lines.append(
            f"note: the mesh is cut open at {where} where several fans of faces meet; potentials are means there"
        )
    if mesh.genus == 0 and shares["harmonic"] > SPURIOUS:
        lines.append("warning: the harmonic part is an effect of rounding, as the mesh has no handles; it has slivers")
    if (lost := answers["normal_part_removed"]) > 1e-12:
        lines.append(f"note: the part of the field normal to the faces ({lost:.4%} of the energy) is left out")
    job.finish(mesh, answers, lines)
