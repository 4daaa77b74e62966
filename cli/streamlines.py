"""``geomhw streamlines``: evenly spaced streamlines of a vector field."""

from math import isfinite
from pathlib import Path
from typing import Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import CURVE_FILES
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, write_curves
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs import fields
from geomhw_cli.specs.numbers import LARGEST, SMALLEST, excerpt

#: Streamlines side by side on a square of the area of the mesh, by default and at most.
DEFAULT_COUNT, MOST = 30, 2000


class Spacing(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    """A spacing (with a decimal point), or a number of streamlines side by side (without)."""

    name = "spacing"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return an int or a float."""
        text = str(value).strip()
        if text.isascii() and text.isdecimal() and 1 <= int(text[:9]) <= MOST:
            return int(text)
        try:
            spacing = float(text) if not text.isdecimal() else 0.0
        except ValueError:
            spacing = 0.0
        if not (isfinite(spacing) and SMALLEST <= spacing <= LARGEST):
            self.fail(
                f"'{excerpt(text)}' is no spacing; give a length such as 0.5 or 5.0, or a number of streamlines side "
                f"by side from 1 to {MOST}."
            )
        return spacing


@command(
    OptionGroup(
        "Input",
        options.vector_field("--field", f"Vector field: {fields.FLOW_FIELD_HELP}.", required=True),
        option(
            "--spacing",
            "D|N",
            Spacing(),
            "Distance of neighbors, such as 0.5 or 5.0, or their number (no decimal point) side by side on a square of "
            "the area of the mesh.",
            default=DEFAULT_COUNT,
        ),
    ),
    CURVE_FILES,
    options.REPORT,
)
def streamlines(mesh_path: Path, field: str, spacing: float, files: dict[str, Any], report: dict[str, Any]) -> None:
    """Trace evenly spaced streamlines of a vector field on MESH.

    Streamlines are exact for a field that is constant on each face. Distances are measured on the surface. A streamline
    ends where it closes, at the boundary, at a critical point, or at 0.6 of the spacing from another one or from
    itself. Where the fields on both sides of an edge point into it, it follows the edge. Without -o, writes
    <stem>.streamlines.vtp and .png to the current directory. With -o, writes those files, and a picture only with
    --png.

    \b
    Arrays per point: path, face, barycentric (3), arc_length, time, speed, along_edge (1 where it follows an edge),
                      stop (at ends: 1 closed, 2 boundary, 3 critical point, 4 near another, 5 near itself).
    Field data:       length, closed (per path).
    Columns of .csv:  path, x, y, z, face, b0, b1, b2, arc_length, time, speed, along_edge, stop.

    \b
    Examples:
      geomhw streamlines data/sphere.off --field rigid:z -o lines.vtp --png lines.png
      geomhw streamlines data/creature.obj --field random:1 --spacing 50 --no-png -o lines.csv
    """
    from geomhw.errors import ArgumentError, FieldError
    from geomhw.flow.even_streamlines import default_spacing, even_streamlines
    from geomhw.flow.streamline_polylines import STOPS
    from geomhw.render.field_pictures import streamlines_picture

    job = Job.plan("streamlines", mesh_path, **files, **report, extensions=CURVE_EXTENSIONS)
    mesh = job.read()
    with job.stage("read field"):
        V = fields.flow(field, mesh)
    with job.stage("compute"):
        distance = default_spacing(mesh, spacing) if isinstance(spacing, int) else spacing
        if distance**2 > mesh.face_areas.sum():
            raise ArgumentError(f"the spacing, {distance:.6g}, is larger than the root of the area of the mesh")
        found = even_streamlines(mesh, V, distance)
        if not len(found):
            raise FieldError(f"the field is zero, or none of its streamlines is as long as the spacing, {distance:.6g}")
    job.write(found.polylines(), lambda _cloud, look: streamlines_picture(found, V, look), write_curves, mesh)
    answers = found.report()
    near = answers["neighbor_distance"]
    share = f"{100 * near['share_from_half_to_twice']:.3g} % from half to twice of it"
    lines = [
        f"lines: {counted(len(found), 'streamline')}, {answers['closed']} closed, length {answers['length']:.6g}",
        f"spacing: {distance:.6g}; distance to the nearest {near['median']:.3g} of it in the median, {share}",
    ]
    if ends := answers["ends"]:
        lines.append("ends: " + ", ".join(f"{count} {name}" for name, count in ends.items()))
    each = [
        {"length": length, "begin": STOPS[begin], "end": STOPS[end]}
        for length, (begin, end) in zip(found.lengths.tolist(), found.stops.tolist(), strict=True)
    ]
    job.finish(mesh, {"field": field, **answers, "lines": each}, lines)
