"""``geomhw design``: smooth direction fields under constraints."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import INPUT, OUTPUT, OptionGroup, command, flag, is_given, option
from geomhw_cli.output_options import FIELD_FILES, MESH_FORMATS
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, write_points
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.curves import read_curves
from geomhw_cli.specs.fields import array_files, axis
from geomhw_cli.specs.files import Spec, read_input, require_writable, write_outputs
from geomhw_cli.specs.numbers import Number, excerpt
from geomhw_cli.specs.sources import SourceSpecs, source_files
from geomhw_cli.specs.vertex_maps import MAP_HELP, vertex_map

if TYPE_CHECKING:
    from geomhw.arrays import Complexes
    from geomhw.directions import DirectionFields


@command(
    OptionGroup(
        "Field",
        option(
            "-n --directions count",
            "1|2|4|6",
            Number(1, 6, whole=True),
            "Number of directions at each vertex: 1 vectors, 2 lines, 4 crosses, 6.",
            default=1,
        ),
        option(
            "-s --energy s",
            "S",
            Number(-1, 1),
            "Energy: 0 Dirichlet, 1 holomorphic, -1 antiholomorphic, often with fewer singularities, or between.",
            default=0.0,
        ),
        option(
            "--relax",
            "STEPS",
            Number(0, 10000, whole=True),
            "Steps that lower the energy of the unit directions further. 0: the global optimum among fields of any "
            "length.  [default: 20; with another --energy 0]",
        ),
    ),
    OptionGroup(
        "Constraints",
        option(
            "--align alignments",
            "SPEC:X,Y,Z",
            Spec(lambda text: source_files(text.rpartition(":")[0])),
            "Direction at points: a source as of geodesic, and a vector such as x or 1,0,2. May be repeated.",
            multiple=True,
        ),
        option(
            "--along curve_files", "FILE", INPUT, "Along curves, such as those of path: .vtp or .csv.", multiple=True
        ),
        flag("--boundary", "Along the boundary."),
        option(
            "--curvature weight",
            "W",
            Number(0, 1e9),
            "Toward principal curvature directions, with this weight over 4π/area. For -n 2, along the larger "
            "curvature, and for -n 4.",
        ),
    ),
    OptionGroup(
        "Instead",
        option("--map map_spec", "FILE", Spec(array_files), f"Field that commutes with a vertex map: {MAP_HELP}."),
        option("--other other_path", "MESH2", INPUT, "Second mesh, to which --map goes: fields on both at once."),
        option("--other-output", "FILE", OUTPUT, f"Second mesh with its field: {MESH_FORMATS}."),
        option(
            "--singularity singularities",
            "SPEC=INDEX",
            Spec(lambda text: source_files(text.rpartition("=")[0])),
            "Field with exactly these singularities, at vertices or in faces, such as 12=1 or face:17=-1/4. May be "
            "repeated. On a closed mesh the indices must sum to the Euler characteristic.",
            multiple=True,
        ),
    ),
    OptionGroup(
        FIELD_FILES.title,
        option("--points", "FILE", OUTPUT, "Singularities as points with their index, .vtp or .csv."),
    ),
    FIELD_FILES,
    options.REPORT,
)
def design(
    mesh_path: Path,
    count: int,
    s: float,
    relax: int | None,
    alignments: Sequence[str],
    curve_files: Sequence[Path],
    boundary: bool,
    weight: float | None,
    map_spec: str | None,
    other_path: Path | None,
    other_output: Path | None,
    singularities: Sequence[str],
    points: Path | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Compute the smoothest direction field on MESH, free or under constraints.

    A field has n unit directions at each vertex, a full turn over n apart. Its singularities are in faces, with an
    index that is a multiple of 1/n. Indices, and the turns of the boundary against the field, sum to the Euler
    characteristic. Without -o, writes <stem>.design.vtk and .png to the current directory.

    \b
    Arrays per vertex: direction for -n 1; direction_0, direction_1, ... else.
    Arrays of --points: index, vertex (-1 in a face), face, barycentric (3).

    \b
    Examples:
      geomhw design data/creature.obj -n 4 --points cones.csv -o crosses.vtp --png crosses.png
      geomhw design data/torus.off -n 2 --curvature 10 -o lines.vtp
      geomhw design data/sphere.off --align max-z:x --align 0:0,1,0 --no-png -o aligned.vtp
      geomhw design data/torus.off --singularity 0=1 --singularity 700=-1 --no-png -o pair.vtp
    """
    from geomhw.directions import DirectionFields, commuting, joint_fields, singular_points, trivial_connection
    from geomhw.directions.smooth_fields import RELAXATION
    from geomhw.io import WRITABLE
    from geomhw.mesh import oriented
    from geomhw.render.direction_picture import direction_picture

    constrained = bool(alignments or curve_files or boundary or weight is not None)
    if (map_spec and singularities) or ((map_spec or singularities) and constrained):
        raise click.UsageError(
            "--map and --singularity exclude each other, --align, --along, --boundary and --curvature."
        )
    if (singularities and is_given("s")) or ((singularities or map_spec) and relax is not None):
        raise click.UsageError("--singularity and --map exclude --relax, and --singularity --energy.")
    steps = relax if relax is not None else 0 if s else RELAXATION
    if (other_path or other_output) and not (map_spec and other_path and other_output):
        raise click.UsageError("--other, --other-output and --map go together.")
    if points:
        require_writable([points], CURVE_EXTENSIONS)
    if other_output:
        require_writable([other_output], WRITABLE)
    job = Job.plan("design", mesh_path, **files, **report)
    mesh = job.read_oriented()
    with job.stage("compute"):
        fields, relaxed = DirectionFields(mesh, count, s), None
        if singularities:
            u = trivial_connection(fields.mesh, count, *_indices(singularities, fields, job))
        elif map_spec and other_path:
            other = DirectionFields(oriented(read_input(other_path).mesh), count, s)
            u, v = joint_fields(fields, other, vertex_map(map_spec, mesh, other.given.n_vertices))
            image = other.result(v)
        elif map_spec:
            u = commuting(fields, vertex_map(map_spec, mesh))
        elif constrained:
            u, relaxed = _aligned(fields, alignments, curve_files, boundary, weight, steps, job)
        else:
            u = fields.smoothest()
            relaxed = fields.relaxed(u, steps=steps)
        result = fields.result(u, relaxed)
    job.write(result, direction_picture)
    if other_output:
        write_outputs(image, [other_output])
        job.written.append(str(other_output))
    if points:
        write_points(singular_points(fields.mesh, result.report), [points])
        job.written.append(str(points))
    answers = result.report
    found = answers["singularities"]
    total = f"indices sum to {answers['index_sum']:g}, Euler characteristic {answers['euler_characteristic']}"
    lines = [
        f"energy: {answers['energy']:.6g}, of unit directions {answers['unit_energy']:.6g}",
        f"singular: {counted(len(found), 'singularity', 'singularities')}; {total}",
    ]
    if answers["nonnegative_weights"]:
        lines.append("note: negative cotan weights are taken as 0, since the energy is not positive with them")
    settings = {
        "relax": None if relaxed is None else steps,
        "align": list(alignments),
        "along": [str(path) for path in curve_files],
        "boundary": boundary,
        "curvature": weight,
        "map": map_spec,
        "singularity": list(singularities),
    }
    answers = {**answers, **({"other": image.report} if other_path else {})}
    job.finish(mesh, {**answers, "settings": {name: value for name, value in settings.items() if value}}, lines)


def _aligned(
    fields: "DirectionFields",
    alignments: Sequence[str],
    curve_files: Sequence[Path],
    boundary: bool,
    weight: float | None,
    steps: int,
    job: Job,
) -> "tuple[Complexes, Complexes]":
    """The smoothest field under constraints, and its directions after relaxation."""
    import numpy as np

    from geomhw import directions

    mesh, n = fields.mesh, fields.n
    parts = [np.zeros(mesh.n_vertices, dtype=complex)]
    for text in alignments:
        spec, colon, vector = text.rpartition(":")
        if not colon:
            raise click.UsageError(f"'{excerpt(text)}' is no alignment; give a point and a vector, such as 12:0,0,1.")
        at = SourceSpecs.parse([spec]).resolve(mesh, job.remarks)
        parts.append(directions.directions_at(mesh, at, np.tile(axis(vector), (len(at), 1)), n))
    for path in curve_files:
        parts.append(directions.directions_along(mesh, read_curves(path, mesh), n))
    if boundary:
        parts.append(directions.directions_along_boundary(mesh, n))
    target = directions.principal_target(mesh, n) if weight is not None else None
    vertices, values = directions.combined(parts)
    u = fields.aligned(vertices, values, target, weight or 0.0)
    return u, fields.relaxed(u, vertices, target, weight or 0.0, steps)


def _indices(texts: Sequence[str], fields: "DirectionFields", job: Job) -> tuple[dict[int, float], dict[int, float]]:
    """The index of each singular vertex, and of each singular face."""
    from fractions import Fraction

    vertices: dict[int, float] = {}
    faces: dict[int, float] = {}
    for text in texts:
        spec, equals, number = text.rpartition("=")
        try:
            if not equals:
                raise ValueError
            index = float(Fraction(number))
        except (ValueError, ZeroDivisionError):
            raise click.UsageError(
                f"'{excerpt(text)}' is no singularity; give a point and an index, such as 12=1 or face:17=-1/4."
            ) from None
        at = SourceSpecs.parse([spec]).resolve(fields.mesh, job.remarks)
        for face, vertex in zip(at.faces.tolist(), at.corners[:, 0].tolist(), strict=True):
            places, key = (vertices, vertex) if face < 0 else (faces, face)
            places[key] = places.get(key, 0.0) + index
    return vertices, faces
