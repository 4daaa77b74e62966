"""``geomhw push``: the pushforward of a field, a 1-form or a function by the flow of a tangent field."""

from pathlib import Path
from typing import Any

import click

from geomhw.options import TransportName
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, choice, command, is_given, option
from geomhw_cli.output_options import SERIES_FILES
from geomhw_cli.runtime.frame_writer import FrameWriter
from geomhw_cli.runtime.progress import progress
from geomhw_cli.specs import fields
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.numbers import COUNT, POSITIVE

#: Growth of the energy of a field from which a warning says so.
GROWTH = 1e6


@command(
    OptionGroup(
        "Input",
        options.vector_field("--field", f"Field V that is carried: {fields.FLOW_FIELD_HELP}.", default=None),
        option(
            "--color color_spec",
            "SPEC",
            Spec(fields.color_files),
            f"A function that is carried, instead of a field: {fields.COLOR_HELP}.",
        ),
        options.vector_field("--by", "Field U whose flow carries it, written as --field.", required=True),
    ),
    OptionGroup(
        "Method",
        choice(
            "--as kind",
            TransportName,
            "vector: by the differential of the flow. form: V is the field of a 1-form. parallel: by parallel "
            "transport along the paths of the flow.",
        ),
        option("--time", "T", POSITIVE, "Time of the flow.", default=1.0),
        option("--frames", "N", COUNT, "Number of frames after the first, at even times.", default=20),
    ),
    SERIES_FILES,
    options.REPORT,
)
def push(
    mesh_path: Path,
    field: str | None,
    color_spec: str | None,
    by: str,
    kind: TransportName,
    time: float,
    frames: int,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Push a field, a 1-form or a function on MESH forward by the flow of a tangent field.

    The pushforward is exp(-tL) with the Lie derivative L along U. A field without divergence keeps none, to rounding,
    if U has none either. Where the flow enters through a boundary, values do not change. Without -o, writes a contact
    sheet <stem>.push.png, a film <stem>.push.gif, and the series in the folder <stem>.push/.

    \b
    Arrays of a frame, per face: pushed (with --field), velocity (U). Per vertex: color (with --color).
    Field data: time. CSV: step, time, energy of the field or mean of the function.

    \b
    Example, a quarter turn:
      geomhw push data/sphere.off --field rigid:x --by rigid:z --time 1.5708 --frames 4 -o turn.pvd
    """
    import numpy as np

    from geomhw.flow.flow_map import require_possible_step
    from geomhw.flow.pushforward import Pushforward
    from geomhw.flow.tangent_fields import energy
    from geomhw.results import Field, Result

    if (field is None) == (color_spec is None):
        raise click.UsageError("Give either --field or --color.")
    if color_spec and is_given("kind"):
        raise click.UsageError("--as is for --field.")
    writer = FrameWriter.plan("push", mesh_path, report, **files)
    job = writer.job
    mesh = job.read_oriented()
    answers: dict[str, Any] = {"by": by, "time": time, "frames": frames}
    with job.stage("compute and write"), progress("push") as bar, writer.running():
        flow = Pushforward(mesh, fields.flow(by, mesh))
        require_possible_step(mesh, flow.by, time / frames)
        if field:
            V = fields.flow(field, mesh)
            answers |= {"field": field, "as": kind}
            if kind == "vector":
                answers["divergence_stays_zero"] = flow.keeps_divergence_zero(V)
            series = flow.frames(V, time, frames, kind)
        else:
            answers["color"] = color_spec
            series = flow.functions(fields.color(str(color_spec), mesh, job.remarks), time, frames)
        for step, values in enumerate(series):
            now = step * time / frames
            carried = Field("pushed", "face", values) if field else Field("color", "vertex", values)
            mean = float(np.mean(mesh.vertex_areas @ values) / mesh.vertex_areas.sum()) if color_spec else 0.0
            size = {"color_mean": mean} if color_spec else {"energy": energy(mesh, values)}
            row = {"step": step, "time": now, **size}
            arrays = [carried, Field("velocity", "face", flow.by), Field("time", "mesh", np.array([now]))]
            writer.add(now, Result(mesh, arrays, row), row)
            bar(step / frames)
    writer.finish()
    last = writer.rows[-1]
    lines = [f"time: {time:.6g}, {len(writer.rows)} frames"]
    if field:
        first = writer.rows[0]["energy"]
        lines.append(f"energy: {first:.6g} at the start, {last['energy']:.6g} at the end")
        if last["energy"] > GROWTH * first:
            lines.append(
                f"warning: the energy grows {last['energy'] / first:.3g} times: V is stretched where the flow of --by "
                "diverges or shears; give a shorter --time, a --by without sources, or --as parallel"
            )
    job.finish(mesh, answers | {"last": last}, lines)
