"""``geomhw extrema``: local maxima and minima of a function, separated by geodesic distance."""

from math import inf
from typing import Any

from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.smooth import MASK
from geomhw_cli.specs.arrays import ARRAY, MESH_ARRAY, MeshArray
from geomhw_cli.specs.masks import MaskSpec, MeshPart
from geomhw_cli.specs.numbers import LARGEST, Number

#: Extrema of each kind that are printed.
SHOWN = 5


@command(
    OptionGroup("Input", ARRAY, MASK),
    OptionGroup(
        "Method",
        option("--distance", "D", Number(0, LARGEST), "No vertex this near is more extreme.", default=0.0),
        option("--above", "V", Number(-inf, inf), "Only maxima of this value or more."),
        option("--below", "V", Number(-inf, inf), "Only minima of this value or less."),
    ),
    FIELD_FILES,
    options.REPORT,
    arguments=(MESH_ARRAY,),
)
def extrema(
    mesh_array: MeshArray,
    array: str | None,
    mask: str | None,
    distance: float,
    above: float | None,
    below: float | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Find the local extrema of an array on the vertices of MESH.

    A vertex counts if none of its neighbors, and none within the exact geodesic distance D, is more extreme. Connected
    vertices of one value are one extremum, at the lowest index. With --mask, vertices at its edge do not count.
    Without -o, writes <stem>.extrema.vtk and .png to the current directory. The report lists vertices and values.

    \b
    Arrays per vertex: extrema (1 at maxima, -1 at minima, 0 elsewhere), and the array.

    \b
    Examples, in one file and in two:
      geomhw geodesic data/creature.obj -o result.vtp -o lh.surf.gii -o lh.func.gii
      geomhw extrema result.vtp:distance --distance 0.3 -o e.vtp --json
      geomhw extrema lh.surf.gii --array lh.func.gii:divergence --distance 1 -o lh.extrema.func.gii
    """
    import numpy as np

    from geomhw.errors import FieldError
    from geomhw.render import scalar_picture
    from geomhw.results import Field, Result
    from geomhw.scalars import local_extrema

    job = Job.plan("extrema", mesh_array.path, **files, **report)
    mesh, field = mesh_array.read(job, array)
    values = np.asarray(field.values, dtype=float)
    if values.ndim != 1:
        raise FieldError(f"the array '{field.name}' has {values.shape[1]} components; extrema are of one number")
    part = MeshPart.of(mesh, MaskSpec.parse(mask))
    allowed = np.ones(mesh.n_vertices, dtype=bool)
    if part.faces is not None:
        allowed[np.delete(mesh.faces, part.faces, axis=0)] = False
    with job.stage("compute"):
        found = local_extrema(part.mesh, values, distance, allowed)
        maxima = found.maxima if above is None else found.maxima[values[found.maxima] >= above]
        minima = found.minima if below is None else found.minima[values[found.minima] <= below]
    marks = np.zeros(mesh.n_vertices, dtype=np.int32)
    marks[maxima], marks[minima] = 1, -1
    job.write(Result(mesh, [Field("extrema", "vertex", marks), Field(field.name, "vertex", values)]), scalar_picture)
    answers: dict[str, Any] = {"array": field.name, "distance": distance}
    lines = []
    for name, vertices in (("maxima", maxima), ("minima", minima)):
        rows = [{"vertex": int(v), "value": float(values[v])} for v in vertices]
        answers[name] = rows
        shown = ", ".join(f"{row['value']:.6g} at vertex {row['vertex']}" for row in rows[:SHOWN])
        lines.append(f"{name}: {len(rows)}" + (f": {shown}" if rows else "") + (" ..." if len(rows) > SHOWN else ""))
    job.finish(mesh, answers, lines)
