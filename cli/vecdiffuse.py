"""``geomhw vecdiffuse``: vectors diffused and transported over a surface."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.options import Connection
from geomhw_cli import options
from geomhw_cli.runtime.job import Job, robust_line
from geomhw_cli.specs.sources import SourceSpecs, shortened, source_line

if TYPE_CHECKING:
    from geomhw.arrays import Floats
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh


@click.command(no_args_is_help=True, short_help="Vectors diffused and transported.")
@options.mesh_argument
@options.source_option
@click.option(
    "--vector",
    "vectors",
    metavar="X Y Z",
    type=float,
    nargs=3,
    multiple=True,
    help="Vector at the source, of which the tangential part counts; one for all sources, or one for each, in order.",
)
@click.option(
    "--angle",
    "angles",
    metavar="DEG",
    type=float,
    multiple=True,
    help="Instead: unit vector at this angle, counterclockwise from the edge that starts the vertex's first face; "
    "within a face, from its first edge.",
)
@click.option(
    "--seed",
    "seeds",
    metavar="K",
    type=click.IntRange(min=0),
    multiple=True,
    help="Instead: unit vector at an angle drawn from this seed.  [default: 0]",
)
@click.option(
    "--dt",
    "times",
    metavar="T",
    multiple=True,
    help="How long vectors diffuse: auto, sqrt-h, h2, a multiple such as 0.5*h2, or a number (length squared); may be "
    "repeated, for arrays and panels side by side.  [default: auto]",
)
@click.option(
    "--connection",
    type=options.choice(Connection),
    default="normals",
    show_default=True,
    help="Transport along an edge: the smallest rotation between vertex normals, or Levi-Civita with angles round "
    "each vertex stretched to a full turn.",
)
@options.robust_option
@options.solver_option
@options.output_option
@options.png_option
@options.no_png_option
@options.width_option
@options.json_option
@options.quiet_option
def vecdiffuse(
    mesh_path: Path,
    sources: SourceSpecs,
    vectors: tuple[tuple[float, float, float], ...],
    angles: tuple[float, ...],
    seeds: tuple[int, ...],
    times: tuple[str, ...],
    connection: str,
    robust: bool,
    solver: Any,
    outputs: tuple[Path, ...],
    png: Path | None,
    no_png: bool,
    width: int,
    as_json: bool,
    quiet: bool,
) -> None:
    """Diffuse tangent vectors at points of MESH, and transport them along shortest paths (vector heat method).

    Without -o, writes <stem>.vecdiffuse.vtk and .png into the current directory; with -o, those files and a picture
    only if --png asks for one.

    \b
    Arrays, per vertex: diffused, transported (both with three components; with several --dt diffused_0,
                        transported_0, diffused_1, ...). Field data: dt.

    \b
    Example, for a short and for a long time:
      geomhw vecdiffuse data/creature.obj --source 0 --angle 30 --dt h2 --dt 100
    """
    from geomhw.render.vector_pictures import transport_picture
    from geomhw.transport.vector_heat import transport_over_times

    if sum(map(bool, (vectors, angles, seeds))) > 1:
        raise click.UsageError("--vector, --angle and --seed exclude each other.")
    if robust and connection == "intrinsic":
        raise click.UsageError("--robust and --connection intrinsic exclude each other; normals go with both.")
    job = Job.plan(
        "vecdiffuse",
        mesh_path,
        outputs=outputs,
        png=png,
        no_png=no_png,
        as_json=as_json,
        quiet=quiet,
        inputs=sources.paths,
    )
    mesh = job.read()
    with job.stage("compute"):
        where = sources.on(mesh)
        start = _vectors(mesh, where, vectors, angles, seeds)
        result = transport_over_times(mesh, where, start, times or ("auto",), connection, robust, solver)  # type: ignore[arg-type]
    job.write(result, partial(transport_picture, width=width))
    report = result.report
    lines = [source_line(report["sources"])]
    lines += [f"dt: {step['t']:.6g} ({step['reason']})" for step in report["times"]]
    if robust:
        lines.append(robust_line(report["robust"]))
    if crossings := report.get("non_manifold_edges", 0) + report.get("non_manifold_vertices", 0):
        lines.append(
            f"warning: {crossings} edges or vertices are not manifold and have no tangent plane; vectors pass there by "
            "the mean of the normals, which depends on how the faces are turned"
        )
    if unreached := report["unreachable_vertices"]:
        lines.append(f"warning: {unreached} vertices lie on components without a source; their vectors are 0")
    job.finish(mesh, shortened(report), lines)


def _vectors(
    mesh: "TriangleMesh",
    sources: "SurfacePoints",
    vectors: Sequence[Sequence[float]],
    angles: Sequence[float],
    seeds: Sequence[int],
) -> "Floats":
    """One vector a source, (k, 3), from whichever of the three options was given."""
    import numpy as np

    from geomhw.errors import FieldError
    from geomhw.transport.source_vectors import seeded_angle, source_frames, turned

    count = len(sources)
    if vectors:
        return np.array(_one_each("--vector", vectors, count))
    if angles:
        if not np.isfinite(angles).all():
            raise FieldError("an angle is a finite number of degrees")
        degrees = _one_each("--angle", angles, count)
    else:
        degrees = _one_each("--seed", [seeded_angle(seed) for seed in seeds or (0,)], count)
    return turned(source_frames(mesh, sources), degrees)


def _one_each(option: str, given: Sequence[Any], count: int) -> list[Any]:
    """As many values as sources; a single one serves all."""
    if len(given) not in (1, count):
        raise click.UsageError(f"{option} is given {len(given)} times for {count} sources; give one, or one each.")
    return list(given) * (count if len(given) == 1 else 1)
