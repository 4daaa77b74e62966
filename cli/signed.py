"""``geomhw signed``: signed distance to curves."""

from pathlib import Path
from typing import Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, flag, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job, time_line
from geomhw_cli.specs.curve_specs import CURVE_HELP, curve_files, curves_on
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.sources import shortened, source_line


@command(
    OptionGroup(
        "Input",
        option(
            "--curve curves",
            "SPEC",
            Spec(curve_files),
            f"Curve with a direction: {CURVE_HELP}. May be repeated. The inside of the boundary, and the higher of "
            "two labels, are on the left.",
            multiple=True,
            required=True,
        ),
        flag("--flip", "Make distances negative on the left of curves."),
        click.Option(
            ["--bridge/--no-bridge"],
            default=True,
            help="Close gaps between ends and starts of curves by smooth arcs.  [default: --bridge]",
        ),
    ),
    OptionGroup(
        "Method",
        click.Option(
            ["--correct/--no-correct"],
            default=True,
            help="Replace distances of the signed heat method by exact ones where the curve is closed.  "
            "[default: --correct]",
        ),
        option(
            "--time",
            "T",
            str,
            f"Diffusion time of curve normals: {options.TIME_HELP}. h is the mean edge length; auto is 0.45*h2, more "
            "on meshes of over 20,480 faces.",
            default="auto",
        ),
    ),
    FIELD_FILES,
    options.REPORT,
)
def signed(
    mesh_path: Path,
    curves: tuple[str, ...],
    flip: bool,
    bridge: bool,
    correct: bool,
    time: str,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Compute the signed distance from curves on MESH: positive on their left, seen from outside.

    Where curves are closed, distances are exact, and the zero level is the curve. Elsewhere, such as at broken, partial
    and crossing curves, the signed heat method gives a generalized distance. Where a closed curve has one piece of the
    surface on both sides, no sign is known, and distances are unsigned. Without -o, writes <stem>.signed.vtk and .png
    to the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Array per vertex: signed_distance (inf on components without a curve).

    \b
    Examples:
      geomhw geodesic data/creature.obj --source 0 --no-png -o d.vtp
      geomhw isolines d.vtp:distance --level 1 --no-png -o ring.vtp
      geomhw signed data/creature.obj --curve ring.vtp -o s.vtp --png s.png
    """
    from dataclasses import replace

    from geomhw.curves.bridged import bridge_gaps
    from geomhw.curves.signed_distance import signed_distance
    from geomhw.errors import ArgumentError
    from geomhw.mesh import curve_points
    from geomhw.mesh.surface_points import concatenate
    from geomhw.render.curve_pictures import signed_picture
    from geomhw.results import Field

    job = Job.plan("signed", mesh_path, **files, **report)
    mesh = job.read_oriented()
    with job.stage("curves"):
        mesh.require_oriented("signed distance")
        found = [curves_on(mesh, text, job.remarks) for text in curves]
        for text, item in zip(curves, found, strict=True):
            if not item.directed:
                raise ArgumentError(f"'{text}' names edges without a direction, and so without sides")
        arcs = bridge_gaps(mesh, [path for item in found for path in item.paths]) if bridge else []
        parts = [item.points(mesh) for item in found]
        points = concatenate([*parts, *(curve_points(mesh, path.faces, path.weights) for path in arcs)])
    with job.stage("compute"):
        result = signed_distance(mesh, points, correct, time)
    if flip:
        values = -result["signed_distance"]
        values[values == -float("inf")] = float("inf")
        result = replace(result, fields=[Field("signed_distance", "vertex", values + 0.0)])
    job.write(result, signed_picture)
    answers = result.report
    if flip:
        answers = {**answers, "least": -answers["largest"], "largest": -answers["least"]}
    bridges = {"gaps": len(arcs), "length": sum(path.length for path in arcs)}
    lines = [source_line(answers["sources"], "curves"), f"range: {answers['least']:.10g} to {answers['largest']:.10g}"]
    if "time" in answers:
        lines.append(time_line(answers["time"]))
    if arcs:
        lines.append(f"note: {counted(len(arcs), 'gap')} closed by arcs of length {bridges['length']:.4g} together")
    kinds = answers["vertices"]
    if kinds["generalized"] and correct:
        lines.append(
            f"note: {counted(kinds['generalized'], 'vertex', 'vertices')} with the generalized distance of the signed "
            "heat method: a curve there is open or crosses itself or another"
        )
    if kinds["unsigned"]:
        lines.append(
            f"warning: {counted(kinds['unsigned'], 'vertex', 'vertices')} with unsigned distance: curves have the same "
            "piece of the surface on both sides"
        )
    if far := answers["unreachable_vertices"]:
        lines.append(f"warning: {counted(far, 'vertex', 'vertices')} on components without a curve: distance inf")
    job.finish(mesh, {**shortened(answers), "bridges": bridges, "flipped": flip}, lines)
