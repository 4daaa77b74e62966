"""``geomhw advect``: a color carried along a tangent field."""

from pathlib import Path
from typing import Any

from geomhw.options import Integrator
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, choice, command
from geomhw_cli.output_options import SERIES_FILES
from geomhw_cli.runtime.frame_writer import FrameWriter
from geomhw_cli.runtime.progress import progress
from geomhw_cli.specs import fields


@command(
    OptionGroup("Input", options.vector_field("--field", f"Vector field: {fields.FIELD_HELP}."), options.COLOR),
    OptionGroup(
        "Method",
        options.DT,
        options.STEPS,
        options.EVERY,
        choice(
            "--integrator",
            Integrator,
            "bounded: a scheme that keeps the range of the color. taylor3: the handout's I + tD + t²D²/2. expm: the "
            "exponential up to rounding. auto: taylor3 on the handout's sphere, bounded elsewhere.",
            krylov="expm",
        ),
        options.TRACERS,
    ),
    SERIES_FILES,
    options.REPORT,
)
def advect(
    mesh_path: Path,
    field: str,
    color_spec: str,
    dt: float,
    steps: int,
    every: int,
    integrator: Any,
    tracers: int | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Carry a color along a tangent field on MESH.

    The color at time t is exp(-tD) applied to the initial color, where D is the derivative along the field. Where the
    field enters through a boundary, it carries the initial color of the boundary in. Without -o, writes a contact
    sheet <stem>.advect.png, a film <stem>.advect.gif, and the series in the folder <stem>.advect/.

    \b
    Arrays of a frame, per vertex: color (1 or 3 components). Per face: velocity. Field data: time.
    Arrays of tracers: velocity, color, id, face, past (offset x y z to the position at each of past_times).
    CSV: step, time, color_min, color_max, color_mean (area-weighted).

    \b
    Example, one turn in five pictures:
      geomhw advect data/torus.off --field rigid:z --color x --dt 0.1 --steps 63 --every 16 --gif turn.gif
    """
    from geomhw.flow.advection import ColorRange, flow_of, frames, integrator_of

    writer = FrameWriter.plan("advect", mesh_path, report, **files)
    job = writer.job
    mesh = job.read()
    with job.stage("compute and write"), progress("advect") as bar, writer.running():
        integrator = integrator_of(mesh, integrator)
        velocity = fields.field(field, mesh)
        flow = flow_of(mesh, velocity, integrator)
        color = fields.color(color_spec, mesh, job.remarks)
        limits = ColorRange(color)
        tracer = pathlines = None
        if tracers:
            from geomhw.flow.pathlines import PathlineTracer

            tracer = PathlineTracer(mesh)
            pathlines = tracer.start(tracers)
        for frame in frames(flow, color, dt, steps, every, limits):
            cloud = None
            if tracer and pathlines:
                pathlines = tracer.step(pathlines, flow.field, frame.report["time"])
                cloud = tracer.cloud(pathlines, flow.field, frame["color"])
            writer.add(frame.report["time"], frame, frame.report, cloud)
            bar(frame.report["step"] / steps)
    writer.finish()
    last = writer.rows[-1]
    parameters = {"field": field, "color": color_spec, "dt": dt, "steps": steps, "every": every, "tracers": tracers}
    lines = [
        f"time: {last['time']:.6g} in {steps} steps, {len(writer.rows)} frames",
        f"color: {last['color_min']:.4g} to {last['color_max']:.4g} at the end",
    ]
    lines += fields.still_lines(mesh, float(abs(velocity).max()) * dt * steps, "field", "--field")
    if limits.since is not None:
        lines.append(
            f"warning: the color leaves its range from step {limits.since} on, by up to {limits.excess:.3g} times the "
            "width of the range; --integrator bounded keeps it"
        )
    job.finish(mesh, parameters | {"integrator": integrator, "frames": len(writer.rows), "last": last}, lines)
