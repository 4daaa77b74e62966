"""``geomhw vecdiffuse``: vector diffusion and parallel transport by the vector heat method."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.options import Connection, EngineName
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, choice, command, option
from geomhw_cli.output_options import VECTOR_FILES
from geomhw_cli.runtime.job import Job, robust_line, time_line
from geomhw_cli.runtime.transport_reach import lines_on_reach
from geomhw_cli.specs.numbers import LARGEST, Number
from geomhw_cli.specs.sources import SourceSpecs, shortened, source_line

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: Beyond this, the last digit of an angle is a ten thousandth of a degree.
MAX_DEGREES = 1e12
MAX_SEED = 10**18 - 1
#: Distance between the points that stand for a curve, in mean edges.
SPACING = 0.25


@command(
    OptionGroup("Input", options.SOURCE),
    OptionGroup(
        "Input",
        option(
            "--vector",
            "X Y Z",
            Number(-LARGEST, LARGEST),
            "Vector at the source; its tangential part is used. One for all sources, or one for each, in order.",
            nargs=3,
            multiple=True,
        ),
        option(
            "--angle",
            "DEG",
            Number(-MAX_DEGREES, MAX_DEGREES),
            "Instead: unit vector at this angle, counterclockwise. It is measured from the first edge of the vertex's "
            "first face, or of the face that contains the source; on a curve, from the direction of the curve.",
            multiple=True,
        ),
        option(
            "--seed",
            "K",
            Number(0, MAX_SEED, whole=True),
            "Instead: unit vector at a random angle, from this seed.  [default: 0]",
            multiple=True,
        ),
        name="start",
    ),
    OptionGroup(
        "Method",
        option(
            "--dt times",
            "T",
            str,
            f"Diffusion time: {options.TIME_HELP}. May be repeated, for several arrays and panels.",
            multiple=True,
            default=("auto",),
        ),
        choice(
            "--connection",
            Connection,
            "Transport along an edge: the smallest rotation between vertex normals, or Levi-Civita with the angles at "
            "each vertex scaled to sum to a full turn.",
        ),
        options.ROBUST,
        options.SOLVER,
        name="method",
    ),
    OptionGroup("Method", options.ENGINE),
    VECTOR_FILES,
    options.REPORT,
)
def vecdiffuse(
    mesh_path: Path,
    sources: SourceSpecs,
    start: dict[str, tuple[Any, ...]],
    method: dict[str, Any],
    engine: EngineName,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Diffuse and transport tangent vectors on MESH.

    The vector heat method transports vectors from the source points along shortest paths. Without -o, writes
    <stem>.vecdiffuse.vtk and .png to the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per vertex: diffused, transported (both with three components; with several --dt diffused_0,
                       transported_0, diffused_1, ...). Field data: dt.

    \b
    Examples, for a short and for a long time, and over MPI ranks:
      geomhw vecdiffuse data/creature.obj --source 0 --angle 30 --dt h2 --dt 100
      mpirun -n 4 geomhw vecdiffuse huge.ply --source 0 --engine petsc -o out.pvtu
    """
    if sum(map(bool, start.values())) > 1:
        raise click.UsageError("--vector, --angle and --seed exclude each other.")
    if engine == "petsc":
        from geomhw_cli.runtime.mpi_transport import transport_over_ranks

        def given(mesh: "TriangleMesh", points: "SurfacePoints", sides: "Ints") -> "Floats":
            return _vectors(mesh, points, start, sides)

        transport_over_ranks(mesh_path, sources, given, method["times"], method["connection"], files["outputs"], report)
        return
    from geomhw.render.vector_pictures import transport_picture
    from geomhw.transport.vector_heat import transport_over_times

    if method["robust"] and method["connection"] == "intrinsic":
        raise click.UsageError("--robust and --connection intrinsic exclude each other; take --connection normals.")
    job = Job.plan("vecdiffuse", mesh_path, **files, **report)
    mesh = job.read()
    with job.stage("compute"):
        points = sources.resolve(mesh, job.remarks, curves=True)
        curve = len(points.segments) > 0
        if curve:
            points, along = _samples(mesh, points, start)
        vectors = _along(mesh, points, along, start) if curve else _vectors(mesh, points, start)
        result = transport_over_times(mesh, points, vectors, **method)
    job.write(result, transport_picture)
    answers = result.report
    lines = [source_line(answers["sources"])]
    lines += [time_line(step, "dt") for step in answers["times"]]
    if "robust" in answers:
        lines.append(robust_line(answers["robust"]))
    job.finish(mesh, shortened(answers), lines + lines_on_reach(answers))


def _samples(
    mesh: "TriangleMesh", points: "SurfacePoints", start: dict[str, tuple[Any, ...]]
) -> "tuple[SurfacePoints, Floats]":
    """Points spread along curves, with the directions of these."""
    import numpy as np

    from geomhw.mesh import even_samples

    if any(len(values) > 1 for values in start.values()):
        raise click.UsageError("With a curve as a source, give one --vector or --angle for all of it.")
    if len(np.setdiff1d(np.arange(len(points)), points.segments[:, :2])):
        raise click.UsageError("Sources are points or curves, not both.")
    return even_samples(mesh, points, SPACING * mesh.mean_edge_length)


def _along(
    mesh: "TriangleMesh", points: "SurfacePoints", along: "Floats", start: dict[str, tuple[Any, ...]]
) -> "Floats":
    """One vector for each point on curves, (k, 3): the same, or at an angle to the curve, by default along it."""
    import numpy as np

    from geomhw.transport.source_vectors import unit_vectors

    if start["vector"]:
        return np.tile(np.array(start["vector"]), (len(points), 1))
    frames = np.stack([along, np.cross(mesh.face_normals[points.faces], along)], axis=1)
    degrees = start["angle"][0] if start["angle"] else 0.0
    return unit_vectors(frames, np.full(len(points), degrees))


def _vectors(
    mesh: "TriangleMesh", sources: "SurfacePoints", start: dict[str, tuple[Any, ...]], sides: "Ints | int" = 1
) -> "Floats":
    """One vector for each of k sources, (k, 3), by --vector, --angle or --seed; a single one serves all.

    sides : (k,) -1 where angles are clockwise.
    """
    import numpy as np

    from geomhw.transport.source_vectors import seeded_angle, source_frames, unit_vectors

    name, values = next(((name, values) for name, values in start.items() if values), ("seed", (0,)))
    count = len(sources)
    if len(values) not in (1, count):
        raise click.UsageError(f"--{name} is given {len(values)} times for {count} sources; give one, or one each.")
    values *= count if len(values) == 1 else 1
    if name == "vector":
        return np.array(values)
    degrees = [seeded_angle(seed) for seed in values] if name == "seed" else values
    return unit_vectors(source_frames(mesh, sources), sides * np.asarray(degrees))
