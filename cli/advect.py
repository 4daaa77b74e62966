"""``geomhw advect``: a color carried by a field."""

from functools import partial
from pathlib import Path

import click

from geomhw.options import Integrator
from geomhw_cli import options
from geomhw_cli.runtime.frame_writer import FrameWriter, frame_options
from geomhw_cli.runtime.job import Job
from geomhw_cli.runtime.progress import progress
from geomhw_cli.specs import fields


@click.command(no_args_is_help=True, short_help="A color carried along a field: series and film.")
@options.mesh_argument
@click.option("--field", "field_spec", metavar="SPEC", default="rotation:x", show_default=True, help=fields.FIELD_HELP)
@click.option("--color", "color_spec", metavar="SPEC", default="hue", show_default=True, help=fields.COLOR_HELP)
@click.option("--dt", metavar="T", type=float, default=0.0005, show_default=True, help="Time step.")
@click.option("--steps", metavar="N", type=int, default=1980, show_default=True, help="Number of steps.")
@click.option("--every", metavar="K", type=int, default=66, show_default=True, help="Steps from frame to frame.")
@click.option(
    "--integrator",
    type=options.choice(Integrator, krylov="expm"),
    default="taylor3",
    show_default=True,
    help="I + tD + t²D²/2, or the exponential to rounding; either splits a step that is too large for it.",
)
@frame_options
@options.json_option
@options.quiet_option
def advect(
    mesh_path: Path,
    field_spec: str,
    color_spec: str,
    dt: float,
    steps: int,
    every: int,
    integrator: str,
    output: Path | None,
    gif: Path | None,
    mp4: Path | None,
    png: Path | None,
    width: int,
    csv: Path | None,
    tracers: int | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Carry a color downstream along a tangent field on MESH (operator approach, exp(-tD)).

    Without -o, writes the series <stem>.advect.pvd with its frames into the current directory.

    \b
    Arrays of a frame, per vertex: color (1 or 3 components). Per face: velocity. Field data: time.
    Arrays of tracers: velocity, color, id, face, past (x y z for each of past_times, less where it is).
    CSV: step, time, color_min, color_max, color_mean (by area).

    \b
    Example, one turn in five pictures:
      geomhw advect data/torus.off --field rigid:z --color x --dt 0.1 --steps 63 --every 16 --gif turn.gif
    """
    from geomhw.flow.flow_map import FlowMap, frames
    from geomhw.render.flow_pictures import contact_sheet, flow_film

    inputs = fields.files_of(field_spec, color_spec)
    job = Job("advect", mesh_path, as_json=as_json, quiet=quiet)
    writer = FrameWriter.plan(job, output, gif, mp4, png, csv, inputs)
    mesh = job.read()
    with job.stage("compute and write"), progress("advect") as bar, writer.background:
        flow = FlowMap(mesh, fields.field(field_spec, mesh), integrator)  # type: ignore[arg-type]
        tracer = pathlines = None
        if tracers:
            from geomhw.flow.pathlines import PathlineTracer

            tracer = PathlineTracer(mesh)
            pathlines = tracer.start(tracers)
        for frame in frames(flow, fields.color(color_spec, mesh), dt, steps, every):
            cloud = None
            if tracer and pathlines:
                pathlines = tracer.step(pathlines, flow.field, frame.report["time"])
                cloud = tracer.cloud(pathlines, flow.field, frame["color"])
            writer.add(frame.report["time"], frame, frame.report, cloud)
            bar(frame.report["step"] / steps)
    writer.finish(partial(flow_film, width=width), contact_sheet)
    low, high = writer.rows[-1]["color_min"], writer.rows[-1]["color_max"]
    parameters = {
        "field": field_spec,
        "color": color_spec,
        "dt": dt,
        "steps": steps,
        "every": every,
        "tracers": tracers,
    }
    job.finish(
        mesh,
        parameters | {"integrator": integrator, "frames": len(writer.rows), "last": writer.rows[-1]},
        [
            f"time: {writer.rows[-1]['time']:.6g} in {steps} steps, {len(writer.rows)} frames",
            f"color: {low:.4g} to {high:.4g} at the end",
        ],
    )
