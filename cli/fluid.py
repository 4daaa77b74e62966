"""``geomhw fluid``: incompressible flow on a surface."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.options import Advection, ForceName, SchemeName
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, choice, command, option
from geomhw_cli.output_options import SERIES_FILES
from geomhw_cli.runtime.frame_writer import FrameWriter
from geomhw_cli.runtime.progress import progress
from geomhw_cli.runtime.resume import load_state, save_state
from geomhw_cli.specs import fields
from geomhw_cli.specs.numbers import LARGEST, POSITIVE, SMALLEST, Number

if TYPE_CHECKING:
    from geomhw.fluid.run import Plan
    from geomhw.fluid.state import FlowState, Scheme
    from geomhw.results import Result

VISCOSITY = Number(SMALLEST, LARGEST, or_zero=True)


@command(
    OptionGroup(
        "Input",
        options.vector_field(
            "--init",
            f"Initial velocity, of which the divergence-free part is used: {fields.FIELD_HELP}; or {fields.FLOW_HELP}.",
        ),
        options.COLOR,
        choice(
            "--force force_name",
            ForceName,
            "jet: the tangential part of (0.2 h/dt)(cos 0.2πt, sin 0.2πt, 0) near the top. none: free flow.",
        ),
        option(
            "--restart",
            "FILE",
            options.INPUT,
            "Resume from <OUT>.restart.npz of an earlier run. Options that are not given are those of that run.",
        ),
        name="choices",
    ),
    OptionGroup(
        "Method",
        choice(
            "--scheme",
            SchemeName,
            "conservative: preserves energy and circulation. rk4: Runge-Kutta for the same equation. stable-fluids: "
            "the handout's scheme, which advects, forces and projects the velocity, and loses energy in each step.",
            fast="rk4",
            handout="stable-fluids",
        ),
        choice(
            "--advection",
            Advection,
            "In stable-fluids: average the full velocity to vertices and back, or only its increment.",
        ),
        click.Option(["--filter/--no-filter", "smooth"], default=True, help="Remove noise at the grid scale."),
        option("--viscosity", "NU", VISCOSITY, "Viscosity, length squared per time.", default=0.0),
        options.DT,
        option("--cfl", "C", POSITIVE, "Instead of --dt: Courant number C; dt = C h / largest speed."),
        options.STEPS,
        option("--until", "T", POSITIVE, "Instead of --steps: exact time of the end."),
        options.EVERY,
        options.TRACERS,
        name="choices",
    ),
    SERIES_FILES,
    options.REPORT,
)
def fluid(mesh_path: Path, choices: dict[str, Any], files: dict[str, Any], report: dict[str, Any]) -> None:
    """Simulate incompressible flow, with a color that it carries, on MESH.

    Without -o, writes a contact sheet <stem>.fluid.png, a film <stem>.fluid.gif, and the series in the folder
    <stem>.fluid/. After Ctrl-C the series is valid up to its last frame, and --restart resumes it to the same result as
    an uninterrupted run.

    \b
    Arrays of a frame, per vertex: color, vorticity. Per face: velocity. Field data: time.
    Arrays of tracers: velocity, color, id, face, past (offset x y z to the position at each of past_times).
    CSV: step, time, energy, enstrophy, circulation, divergence, courant, color_min, color_max;
         harmonic_K, the coefficients of the harmonic fields; loop_K, the circulation around
         boundary loops.

    \b
    Examples, a free flow and a forced flow:
      geomhw fluid data/sphere.off --init random:1 --force none --cfl 1 --until 1 --every 6 --gif flow.gif
      geomhw fluid data/genus2.off --steps 40 --every 10 --csv energy.csv
    """
    from geomhw.fluid.conservation import ConservationCheck
    from geomhw.fluid.initial import top_jet
    from geomhw.fluid.run import run, scheme_of
    from geomhw.fluid.state import Diagnostics
    from geomhw.fluid.vorticity_scheme import VorticityScheme

    restart = choices.pop("restart")
    if restart:
        _continue(restart, choices, files)
    plan = _plan(choices)
    writer = FrameWriter.plan("fluid", mesh_path, report, restart=restart, **files)
    job = writer.job
    mesh = job.read_oriented()
    with job.stage("set up"):
        settings = {"advection": choices["advection"], "filter": choices["smooth"], "viscosity": choices["viscosity"]}
        scheme = untraced = scheme_of(mesh, choices["scheme"], **settings)
        traced = None
        if choices["tracers"]:  # compiled loops are loaded only then
            from geomhw.fluid.traced_scheme import TracedScheme

            scheme = traced = TracedScheme(untraced, choices["tracers"])
        force = top_jet(mesh, plan.dt) if choices["force_name"] == "jet" and plan.dt else None
        diagnostics = Diagnostics(scheme)
        state = load_state(writer, mesh, restart, choices) if restart else None
        if state is None:
            model = untraced.model if isinstance(untraced, VorticityScheme) else None
            velocity = fields.flow(choices["init"], mesh, model)
            state = scheme.start(velocity, fields.color(choices["color_spec"], mesh, job.remarks))
        first = writer.rows[0] if writer.rows else None
        fastest, begin = _largest_speed(scheme, state), state.time
        conservation = ConservationCheck(scheme, state, force, first, plan.dt or 0.0)
    with job.stage("compute and write"), progress("fluid") as bar, writer.running():
        for snapshot in run(scheme, state, plan, force, conservation):
            state = snapshot.state
            cloud = traced.cloud(state) if traced else None
            # An uninterrupted run passes the regular states too, and can be continued from them.
            checkpoint = partial(save_state, writer, mesh, state, choices) if snapshot.regular else None
            writer.add(state.time, _frame(scheme, state), diagnostics(state, snapshot.dt), cloud, checkpoint)
            bar(plan.share(state))
    writer.finish()
    first, last = writer.rows[0], writer.rows[-1]
    lines = [f"time: {last['time']:.6g} after {last['step']} steps, {len(writer.rows)} frames"]
    moved = max(fastest, _largest_speed(scheme, state)) * (state.time - begin)
    still = fields.still_lines(mesh, moved, "fluid", "--init") if state.time > begin else []
    if first["energy"] and not still:
        lines.append(f"energy: {last['energy'] / first['energy']:.10g} of that at the start")
    lines += still
    if choices["scheme"] == "stable-fluids":
        lines.append("note: the handout's scheme damps the flow at every step, however short; others do not")
    for name, step in conservation.since.items():
        lines.append(
            f"warning: {name} exceeds its bound from step {step} on, by up to {conservation.excess[name]:.3g} times "
            "the bound; take shorter steps"
        )
    if conservation.color.since is not None:
        lines.append(
            f"warning: the color leaves its range from step {conservation.color.since} on, by up to "
            f"{conservation.color.excess:.3g} times the width of the range; other schemes keep it"
        )
    job.finish(mesh, {**choices, "frames": len(writer.rows), "first": first, "last": last}, lines)


def _largest_speed(scheme: "Scheme", state: "FlowState") -> float:
    """The length of the longest velocity of a state."""
    import numpy as np

    return float(np.linalg.norm(scheme.velocity(state), axis=1).max())


def _continue(restart: Path, choices: dict[str, Any], files: dict[str, Any]) -> None:
    """Take the options that the command line leaves out from the run that wrote a state, and go on with its series.

    Raises FormatError for a value that the command line does not take. Files in values are inputs.
    """
    from geomhw.errors import FormatError
    from geomhw.io import read_checkpoint

    context, saved = click.get_current_context(), read_checkpoint(restart)[0]
    run, end = saved.get("run"), saved.get("end")
    if not (isinstance(run, dict) and isinstance(end, dict)):
        raise FormatError(f"{restart.name} holds no state of a fluid; give the .restart.npz of an earlier run")
    settings = {name: None if value is None else str(value) for name, value in {**run, **end}.items()}
    parameters = {parameter.name: parameter for parameter in context.command.params}
    for name in choices.keys() & settings.keys():
        rivals = [name, *(pair[1 - pair.index(name)] for pair in (("dt", "cfl"), ("steps", "until")) if name in pair)]
        if not any(map(options.is_given, rivals)):
            try:
                choices[name] = parameters[name].type_cast_value(context, settings[name])
            except click.UsageError as error:
                raise FormatError(f"{restart.name} is of no run that can be: {error.message}; start anew") from None
    suffix = ".restart.npz"
    if files["output"] is None and restart.name.endswith(suffix):
        files["output"] = restart.with_name(restart.name.removesuffix(suffix) + ".pvd")


def _plan(choices: dict[str, Any]) -> "Plan":
    """Time steps of the run; --cfl and --until take the places of the defaults of --dt and --steps in ``choices``."""
    from geomhw.fluid.run import Plan

    for replaced, name in (("dt", "cfl"), ("steps", "until")):
        if choices[name] is not None:
            if options.is_given(replaced):
                raise click.UsageError(f"--{replaced} and --{name} exclude each other.")
            choices[replaced] = None
    if choices["cfl"] is not None and choices["force_name"] == "jet":
        raise click.UsageError("the jet needs a fixed --dt; with --cfl give --force none.")
    return Plan(**{name: choices[name] for name in ("dt", "cfl", "steps", "until", "every")})


def _frame(scheme: "Scheme", state: "FlowState") -> "Result":
    """The arrays of a frame."""
    import numpy as np

    from geomhw.results import Field, Result

    fields = [
        Field("color", "vertex", state.color),
        Field("vorticity", "vertex", scheme.vorticity(state)),
        Field("velocity", "face", scheme.velocity(state)),
        Field("time", "mesh", np.array([state.time])),
    ]
    return Result(scheme.mesh, fields)
