"""``geomhw smooth``: smoothing of arrays along the surface by heat flow."""

from typing import TYPE_CHECKING, Any

from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.arrays import ARRAY, MESH_ARRAY, MeshArray
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.masks import MaskSpec, MeshPart
from geomhw_cli.specs.numbers import POSITIVE

if TYPE_CHECKING:
    from geomhw.arrays import Floats

#: Share of the range by which smoothed values may pass it without a warning: 3 % occur at a width of one edge.
OVERSHOOT = 0.05
MASK = option(
    "--mask",
    "FILE:ARRAY|@FILE",
    Spec(lambda text: [spec.path] if (spec := MaskSpec.parse(text)) else []),
    "Stay within the faces or vertices where the array is not zero, or within the vertices that a text file lists. "
    "Nothing passes the edge of the mask; outside, values stay.",
)


@command(
    OptionGroup("Input", ARRAY, MASK),
    OptionGroup(
        "Method",
        option("--fwhm", "L", POSITIVE, "Full width at half maximum of the Gaussian, in mesh units.", required=True),
        options.ROBUST,
    ),
    FIELD_FILES,
    options.REPORT,
    arguments=(MESH_ARRAY,),
)
def smooth(
    mesh_array: MeshArray,
    array: str | None,
    mask: str | None,
    fwhm: float,
    robust: bool,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Smooth an array on the vertices of MESH along the surface.

    Heat flows for the time FWHM² / (16 ln 2), after which a point of a plane is a Gaussian of that full width at half
    maximum; the standard deviation is FWHM / 2.3548. The integral, the sum of value times area of the vertex, stays to
    rounding, and so do constants. Without -o, writes <stem>.smooth.vtk and .png to the current directory.

    \b
    Array per vertex: that of the input, under its own name.

    \b
    Examples, in one file and in two:
      geomhw geodesic data/creature.obj -o result.vtp -o lh.surf.gii -o lh.func.gii
      geomhw smooth result.vtp:distance --fwhm 0.2 -o smooth.vtp
      geomhw smooth lh.surf.gii --array lh.func.gii:distance --fwhm 0.2 -o lh.smooth.func.gii
    """
    import numpy as np

    from geomhw.intrinsic import RobustTriangulation
    from geomhw.render import scalar_picture
    from geomhw.results import Field, Result
    from geomhw.scalars import HeatSmoothing

    job = Job.plan("smooth", mesh_array.path, **files, **report)
    mesh, field = mesh_array.read(job, array)
    part = MeshPart.of(mesh, MaskSpec.parse(mask))
    with job.stage("compute"):
        surface = RobustTriangulation.of(part.mesh).surface if robust else None
        smoothing = HeatSmoothing(part.mesh, fwhm, surface)
        values = smoothing(np.asarray(field.values, dtype=float))
    job.write(Result(mesh, [Field(field.name, "vertex", values)]), scalar_picture)
    areas, before = part.mesh.vertex_areas, np.asarray(field.values, dtype=float)
    totals = [(areas @ f).tolist() for f in (before, values)]
    deviations = [np.asarray(f).std(axis=0).max().item() for f in (before, values)]
    answers: dict[str, Any] = {
        "array": field.name,
        "fwhm": fwhm,
        "time": smoothing.time,
        "integral": {"before": totals[0], "after": totals[1]},
        "range": {
            "before": [before.min().item(), before.max().item()],
            "after": [values.min().item(), values.max().item()],
        },
        "beyond_range": _beyond(before, values),
        "standard_deviation": {"before": deviations[0], "after": deviations[1]},
    }
    if fwhm < 2 * mesh.mean_edge_length:
        job.remarks.append(
            f"note: the width is less than two edges (h = {mesh.mean_edge_length:.4g}); it is not resolved"
        )
    if (beyond := answers["beyond_range"]) > OVERSHOOT:
        remedy = "refine the mesh there" if robust else "compute with --robust"
        job.remarks.append(
            f"warning: values pass those of the array by {100 * beyond:.2g} % of their range, because of very obtuse "
            f"angles; {remedy}"
        )
    lines = [
        f"array: {field.name}, {values.min():.6g} to {values.max():.6g}",
        f"before: {before.min():.6g} to {before.max():.6g}",
        f"smoothed: full width at half maximum {fwhm:g}, t = {smoothing.time:.6g}",
    ]
    job.finish(mesh, answers, lines)


def _beyond(before: "Floats", after: "Floats") -> float:
    """Return by how much values, (n,) or (n, k), pass those before, as a share of their range; the largest share."""
    import numpy as np

    low, high = before.min(axis=0), before.max(axis=0)
    passed = np.maximum(np.maximum(low - after.min(axis=0), after.max(axis=0) - high), 0.0)
    return float(np.max(np.divide(passed, high - low, out=np.zeros_like(passed), where=high > low)))
