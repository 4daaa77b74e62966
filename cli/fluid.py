"""``geomhw fluid``: incompressible flow on a surface."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.options import Advection, ForceName, SchemeName
from geomhw_cli import options
from geomhw_cli.runtime.frame_writer import FrameWriter, frame_options
from geomhw_cli.runtime.job import Job
from geomhw_cli.runtime.progress import progress
from geomhw_cli.runtime.resume import resumed, save_state
from geomhw_cli.specs import fields

if TYPE_CHECKING:
    from geomhw.fluid.run import Snapshot
    from geomhw.fluid.state import Diagnostics, Force, Scheme
    from geomhw.fluid.traced_scheme import TracedScheme

DEFAULT_DT = 0.0005
DEFAULT_STEPS = 1980


@click.command(no_args_is_help=True, short_help="Incompressible flow: series and film.")
@options.mesh_argument
@click.option(
    "--scheme",
    type=options.choice(SchemeName, fast="rk4", handout="stable-fluids"),
    default="conservative",
    show_default=True,
    help="conservative keeps energy and circulation; rk4 is Runge-Kutta on the same equation; stable-fluids, the "
    "handout's, advects, forces and projects the velocity, and loses energy at every step.",
)
@click.option(
    "--advection",
    type=options.choice(Advection),
    default="full",
    show_default=True,
    help="Of stable-fluids: average the whole velocity to vertices and back, or only what changes.",
)
@click.option("--filter/--no-filter", "smooth", default=True, show_default=True, help="Take grid-scale noise away.")
@click.option("--viscosity", metavar="NU", type=float, default=0.0, show_default=True, help="Length squared per time.")
@click.option(
    "--init",
    metavar="SPEC",
    default="rotation:x",
    show_default=True,
    help=f"Initial velocity, made free of divergence: {fields.FIELD_HELP}; or {fields.FLOW_HELP}.",
)
@click.option(
    "--force",
    "force_name",
    type=options.choice(ForceName),
    default="jet",
    show_default=True,
    help="jet: (0.2 h/dt)(cos 0.2πt, sin 0.2πt, 0) near the top, tangential part; none: free flow.",
)
@click.option("--color", "color_spec", metavar="SPEC", default="hue", show_default=True, help=fields.COLOR_HELP)
@click.option("--dt", metavar="T", type=float, help=f"Time step.  [default: {DEFAULT_DT}]")
@click.option("--cfl", metavar="C", type=float, help="Instead: step by this Courant number, C h / largest speed.")
@click.option("--steps", metavar="N", type=int, help=f"Last step.  [default: {DEFAULT_STEPS}]")
@click.option("--until", metavar="T", type=float, help="Instead: time to end at, exactly.")
@click.option("--every", metavar="K", type=int, default=66, show_default=True, help="Steps from frame to frame.")
@click.option("--restart", metavar="FILE", type=options.FILE, help="Go on from <OUT>.restart.npz of an earlier run.")
@frame_options
@options.json_option
@options.quiet_option
def fluid(
    mesh_path: Path,
    output: Path | None,
    gif: Path | None,
    mp4: Path | None,
    png: Path | None,
    width: int,
    csv: Path | None,
    as_json: bool,
    quiet: bool,
    restart: Path | None,
    **choices: Any,
) -> None:
    """Incompressible flow on MESH: velocity, vorticity, and a color that it carries.

    Without -o, writes the series <stem>.fluid.pvd with its frames into the current directory. After Ctrl-C the series
    is valid up to its last frame, and --restart goes on from there to what an uninterrupted run gives.

    \b
    Arrays of a frame, per vertex: color, vorticity. Per face: velocity. Field data: time.
    Arrays of tracers: velocity, color, id, face, past (x y z for each of past_times, less where it is).
    CSV: step, time, energy, enstrophy, circulation, divergence, courant, color_min, color_max;
         harmonic_K, the coefficients of the harmonic fields; loop_K, the circulation round
         boundary loops.

    \b
    Examples, a free flow and one that is pushed:
      geomhw fluid data/sphere.off --init random:1 --force none --cfl 1 --until 1 --every 6 --gif flow.gif
      geomhw fluid data/genus2.off --steps 40 --every 10 --csv energy.csv
    """
    from geomhw.fluid.run import run
    from geomhw.fluid.state import Diagnostics
    from geomhw.fluid.vorticity_scheme import VorticityScheme
    from geomhw.render.flow_pictures import contact_sheet, flow_film

    plan = _plan(choices)
    inputs = fields.files_of(choices["init"], choices["color_spec"])
    job = Job("fluid", mesh_path, as_json=as_json, quiet=quiet)
    writer = FrameWriter.plan(job, output, gif, mp4, png, csv, inputs)
    mesh = job.read_oriented()
    with job.stage("set up"):
        untraced, force = _scheme(mesh, choices), _force(mesh, choices, plan.dt)
        traced = _traced(untraced, choices["tracers"])
        scheme = traced or untraced
        diagnostics = Diagnostics(scheme)
        state = resumed(writer, mesh, restart, choices) if restart else None
        if state is None:
            model = untraced.model if isinstance(untraced, VorticityScheme) else None
            velocity = fields.flow(choices["init"], mesh, model)
            state = scheme.start(velocity, fields.color(choices["color_spec"], mesh))
    try:
        with job.stage("compute and write"), progress("fluid") as bar, writer.background:
            for snapshot in run(scheme, state, plan, force):
                _save(writer, scheme, traced, diagnostics, snapshot, choices)
                bar(plan.share(snapshot.state))
    except KeyboardInterrupt:
        if not writer.rows:
            raise
        kept = f"{writer.series.path} is valid up to step {writer.rows[-1]['step']}"
        raise click.ClickException(f"interrupted; {kept}, go on with --restart {writer.checkpoint}") from None
    writer.finish(partial(flow_film, width=width), contact_sheet)
    first, last = writer.rows[0], writer.rows[-1]
    lines = [f"time: {last['time']:.6g} after {last['step']} steps, {len(writer.rows)} frames"]
    if first["energy"]:
        lines.append(f"energy: {last['energy'] / first['energy']:.10g} of that at the start")
    if choices["scheme"] == "stable-fluids":
        lines.append("note: the handout's scheme damps the flow at every step, however short; others do not")
    job.finish(mesh, {**choices, "frames": len(writer.rows), "first": first, "last": last}, lines)


def _plan(choices: dict[str, Any]) -> Any:
    from geomhw.fluid.run import Plan

    for one, other in (("dt", "cfl"), ("steps", "until")):
        if choices[one] is not None and choices[other] is not None:
            raise click.UsageError(f"--{one} and --{other} exclude each other.")
    if choices["dt"] is None and choices["cfl"] is None:
        choices["dt"] = DEFAULT_DT
    if choices["steps"] is None and choices["until"] is None:
        choices["steps"] = DEFAULT_STEPS
    if choices["cfl"] is not None and choices["force_name"] == "jet":
        raise click.UsageError("the jet is made for a fixed --dt; with --cfl give --force none.")
    return Plan(**{name: choices[name] for name in ("dt", "cfl", "steps", "until", "every")})


def _scheme(mesh: Any, choices: dict[str, Any]) -> "Scheme":
    from geomhw.fluid.run import scheme_of

    return scheme_of(
        mesh,
        choices["scheme"],
        advection=choices["advection"],
        filter=choices["smooth"],
        viscosity=choices["viscosity"],
    )


def _force(mesh: Any, choices: dict[str, Any], dt: float | None) -> "Force | None":
    from geomhw.fluid.initial import top_jet

    return top_jet(mesh, dt) if choices["force_name"] == "jet" and dt else None


def _traced(scheme: "Scheme", count: int | None) -> "TracedScheme | None":
    if not count:
        return None
    from geomhw.fluid.traced_scheme import TracedScheme

    return TracedScheme(scheme, count)


def _save(
    writer: FrameWriter,
    scheme: "Scheme",
    traced: "TracedScheme | None",
    diagnostics: "Diagnostics",
    snapshot: "Snapshot",
    choices: dict[str, Any],
) -> None:
    """Add a frame, its row of the table and, if an uninterrupted run has this state too, the state to restart from."""
    import numpy as np

    from geomhw.results import Field, Result

    state = snapshot.state
    fields = [
        Field("color", "vertex", state.color),
        Field("vorticity", "vertex", scheme.vorticity(state)),
        Field("velocity", "face", scheme.velocity(state)),
        Field("time", "mesh", np.array([state.time])),
    ]
    tracers = traced.cloud(state) if traced else None
    keep = partial(save_state, writer, scheme.mesh, state, choices) if snapshot.regular else None
    writer.add(state.time, Result(scheme.mesh, fields), diagnostics(state, snapshot.dt), tracers, keep)
