"""``geomhw spectrum``: eigenfunctions of Laplacians, signatures and spectral distances."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.options import EndCondition, SignatureName, SpectralDistanceName, SpectrumName
from geomhw_cli import options
from geomhw_cli.options import Choice, OptionGroup, choice, command, is_given, option
from geomhw_cli.output_options import VECTOR_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.numbers import POSITIVE, Number

if TYPE_CHECKING:
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Field, Result

#: Pairs at most; time and memory grow with the square of their number.
MAX_PAIRS = 5000
#: Residuals beyond this are reported as a warning.
ACCURATE = 1e-8


@command(
    OptionGroup(
        "Method",
        option(
            "-k --pairs", "N", Number(1, MAX_PAIRS, whole=True), "Number of eigenpairs, from the smallest.", default=100
        ),
        choice(
            "--of kind",
            SpectrumName,
            "functions: Laplacian. vectors: connection Laplacian on tangent vectors. fields: Hodge Laplacian on "
            "tangent fields.",
        ),
        choice("--boundary", EndCondition, "neumann: no flux through the boundary. dirichlet: zero there."),
        options.ROBUST,
    ),
    OptionGroup(
        "From the eigenfunctions",
        click.Option(["--signature"], type=Choice(SignatureName), help="Descriptor of vertices: heat or wave kernel."),
        option("--scales", "N", Number(1, 1000, whole=True), "Numbers of the signature at each vertex.", default=16),
        click.Option(
            ["--distance"],
            type=Choice(SpectralDistanceName),
            help="Distance from the source: sum over eigenfunctions with weights 1/λ² or exp(-2λt).",
        ),
        options.SOURCE,
        option("--time", "T", POSITIVE, "t of the diffusion distance.  [default: 1 / first positive eigenvalue]"),
    ),
    VECTOR_FILES,
    options.REPORT,
)
def spectrum(
    mesh_path: Path,
    pairs: int,
    kind: SpectrumName,
    boundary: EndCondition,
    robust: bool,
    signature: SignatureName | None,
    scales: int,
    distance: SpectralDistanceName | None,
    sources: Any,
    time: float | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Compute the smallest eigenvalues and eigenfunctions of a Laplacian on MESH.

    Eigenfunctions have the square integral 1 and a fixed sign; those of one eigenvalue are a fixed basis, so that runs
    agree. The residual of each pair is in the report. Without -o, writes <stem>.spectrum.vtk and .png to the current
    directory.

    \b
    Arrays per vertex: eigenfunction_0, eigenfunction_1, ... (per face for --of fields);
                       hks_0 ... or wks_0 ... with --signature;
                       biharmonic_distance or diffusion_distance with --distance.

    \b
    Examples:
      geomhw spectrum data/creature.obj -k 20 -o modes.vtp
      geomhw spectrum data/torus.off -k 6 --of fields --json
      geomhw spectrum data/creature.obj --signature hks --distance biharmonic --source 0 -o shape.vtp
    """
    from geomhw.render.pictures import spectrum_picture

    if kind != "functions":
        for name in ("boundary", "robust", "signature", "distance"):
            if is_given(name):
                raise click.UsageError(f"--{name} is for --of functions.")
    if time and distance != "diffusion":
        raise click.UsageError("--time is for --distance diffusion.")
    job = Job.plan("spectrum", mesh_path, **files, **report)
    mesh = job.read_oriented() if kind != "functions" else job.read()
    start = sources.resolve(mesh, job.remarks) if distance else None
    if start is not None and (len(start) != 1 or start.faces[0] >= 0):
        raise click.UsageError("--distance needs one source, a vertex.")
    with job.stage("compute"):
        result = _spectrum(mesh, kind, pairs, boundary, robust)
    with job.stage("signatures"):
        extra = _derived(result, signature, scales, distance, start, time)
        result = type(result)(mesh, [*result.fields, *extra], result.report)
    job.write(result, spectrum_picture)
    answers = result.report
    values = answers["eigenvalues"]
    shown = ", ".join(f"{value:.6g}" for value in values[:8])
    worst = max(answers["residuals"])
    lines = [f"values: {shown}{' ...' if len(values) > 8 else ''}"]
    lines.append(f"{'warning' if worst > ACCURATE else 'residual'}: {worst:.2g} at most, relative to the eigenvalue")
    job.finish(mesh, answers, lines)


def _spectrum(mesh: "TriangleMesh", kind: SpectrumName, pairs: int, boundary: EndCondition, robust: bool) -> "Result":
    from geomhw import spectral
    from geomhw.intrinsic import RobustTriangulation

    if kind == "vectors":
        return spectral.connection_spectrum(mesh, pairs)
    if kind == "fields":
        return spectral.hodge_spectrum(mesh, pairs)
    surface = RobustTriangulation.of(mesh).surface if robust else None
    return spectral.laplacian_spectrum(mesh, pairs, boundary, surface)


def _derived(
    result: "Result",
    signature: SignatureName | None,
    scales: int,
    distance: SpectralDistanceName | None,
    start: Any,
    time: float | None,
) -> "list[Field]":
    """Fields of signatures and spectral distances."""
    import numpy as np

    from geomhw import spectral
    from geomhw.results import Field

    if not signature and not distance:
        return []
    values = np.array(result.report["eigenvalues"])
    functions = np.stack([field.values for field in result.fields], axis=1)
    fields = []
    if signature:
        columns = spectral.signature(signature, values, functions, scales).T
        fields += [Field(f"{signature}_{i}", "vertex", column) for i, column in enumerate(columns)]
    if distance:
        vertex = int(start.corners[0, 0])
        found = spectral.spectral_distance(distance, values, functions, vertex, time)
        fields.append(Field(f"{distance}_distance", "vertex", found))
    return fields
