"""Arguments and options that several commands share, and the commands that list their options by group."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, get_args

import click
from click.core import ParameterSource

from geomhw.options import DEFAULT_COLOR, DEFAULT_DT, DEFAULT_EVERY, DEFAULT_STEPS, EngineName, SolverName
from geomhw_cli.runtime.memory import COMPUTING, require_memory
from geomhw_cli.specs.fields import COLOR_HELP, color_files, field_files
from geomhw_cli.specs.files import FormatName, InputFile, OutputFile, Spec, set_format
from geomhw_cli.specs.numbers import COUNT, POSITIVE, Number
from geomhw_cli.specs.sources import SOURCE_HELP, SourceSpecs, source_files

INPUT, OUTPUT = InputFile(), OutputFile()
MESH = click.Argument(["mesh_path"], metavar="MESH", type=INPUT)
MESHES = click.Argument(["mesh_paths"], metavar="MESH...", type=INPUT, nargs=-1, required=True)
TIME_HELP = "auto, sqrt-h, h2, a multiple such as 0.5*h2, or a number (length squared)"
#: Words that users of other programs try for an option.
SYNONYMS = {
    "--stiffness": "laplacian laplace cotan cot",
    "--connection": "transport levi civita",
    "--gradient": "grad",
    "--divergence": "div",
    "--vertices-to-faces": "average vtof",
    "--faces-to-vertices": "average ftov",
    "--source": "seed start from vertex point points vertices",
    "--sources": "batch",
    "--all-pairs": "matrix all apsp pairwise",
    "--time": "t dt step timestep tau m",
    "--dt": "time timestep step delta tau",
    "--steps": "iterations iter frames n nsteps until end duration",
    "--until": "end duration tmax",
    "--every": "stride interval skip save",
    "--robust": "intrinsic delaunay mollify tufted",
    "--refine": "exact accurate",
    "--field": "velocity vector vectors direction",
    "--init": "initial velocity field start",
    "--color": "scalar dye",
    "--viscosity": "nu diffusion",
    "--restart": "resume continue checkpoint",
    "--tracers": "particles streamlines",
    "--output": "out outfile save",
    "--png": "picture image plot screenshot figure",
    "--view": "camera azimuth elevation angle",
    "--colormap": "cmap palette",
    "--range": "clim limits vmin vmax",
    "--isolines": "contours levels contour",
    "--gif": "film movie animation video",
    "--mp4": "film movie animation video",
    "--csv": "table",
    "--rtol": "tolerance tol relative eps",
    "--atol": "tolerance tol absolute eps",
    "--quiet": "silent",
}
#: Tracers, at most.
MAX_TRACERS = 10_000_000


class OptionGroup:
    """Options under one title of the help.

    name: of the parameter, a dict, in which the command receives their values; without it, each is a parameter.
    """

    def __init__(self, title: str, *options: click.Option, name: str = "") -> None:
        self.title, self.options, self.name = title, options, name


class Command(click.Command):
    """A command whose options are in groups."""

    def __init__(self, *, groups: Sequence[OptionGroup], **settings: Any) -> None:
        super().__init__(no_args_is_help=True, context_settings={"show_default": True}, **settings)
        self.groups = groups

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments; the message about an unknown option suggests one of the same meaning."""
        given = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            names = [name for option in self.params for name in option.opts if isinstance(option, click.Option)]
            if whole := next((word for word in given if f"-{word.partition('=')[0]}" in names), ""):
                name = whole.partition("=")[0]
                raise click.UsageError(f"No such option '{name}'. Did you mean '-{name}'?", ctx) from None
            words = {word for word in error.option_name.strip("-").split("-") if word}
            meant = [name for name in names if words & set(SYNONYMS.get(name, "").split())]
            if not meant:
                raise
            close = " or ".join(f"'{name}'" for name in dict.fromkeys([*meant, *(error.possibilities or ())]))
            raise click.UsageError(f"No such option '{error.option_name}'. Did you mean {close}?", ctx) from None
        except click.UsageError as error:
            if "extra argument" in error.message and MESH in self.params:
                hint = "The command takes one mesh; options such as -o name other files."
                raise click.UsageError(f"{error.message}. {hint}", ctx) from None
            raise

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options group by group; ``--help`` is in the last."""
        titles = {option: group.title for group in self.groups for option in group.options}
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            if isinstance(parameter, click.Option) and (record := parameter.get_help_record(ctx)):
                sections.setdefault(titles.get(parameter, self.groups[-1].title), []).append(record)
        for title, records in sections.items():
            with formatter.section(title):
                formatter.write_dl(records)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, with a dict of values for each named group."""
        for group in self.groups:
            if group.name:
                names = [option.name for option in group.options]
                values = {name: ctx.params.pop(name) for name in list(ctx.params) if name in names}
                ctx.params.setdefault(group.name, {}).update(values)
        require_memory(COMPUTING, "computing")
        return super().invoke(ctx)


class Choice(click.Choice[str]):
    """A choice among the names of a Literal of `geomhw.options`. former: names of the past, and what they became."""

    def __init__(self, names: Any, former: Mapping[str, str] | None = None) -> None:
        super().__init__(get_args(names), case_sensitive=False)
        self._former = former or {}

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name as the library knows it."""
        return super().convert(self._former.get(value, value), param, ctx)


class Choices(Choice):
    """Several different names of a Literal, separated by commas."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the names in the given order."""
        names = tuple(super(Choices, self).convert(name, param, ctx) for name in value.split(","))
        if len(set(names)) < len(names):
            self.fail(f"'{value}' names one of them twice.", param, ctx)
        return names


def option(names: str, metavar: str, kind: Any, help: str, **settings: Any) -> click.Option:
    """An option with a value of some kind: a type or a `click.ParamType`. names: separated by blanks."""
    return click.Option(names.split(), metavar=metavar, type=kind, help=help, **settings)


def flag(names: str, help: str) -> click.Option:
    """An option without a value. names: separated by blanks."""
    return click.Option(names.split(), is_flag=True, help=help)


def choice(names: str, of: Any, help: str, **former: str) -> click.Option:
    """An option for one name of a Literal of `geomhw.options`, by default the first."""
    return click.Option(names.split(), type=Choice(of, former), default=get_args(of)[0], help=help)


def command(
    *groups: OptionGroup, arguments: Sequence[click.Argument] = (MESH,)
) -> Callable[[Callable[..., None]], Command]:
    """Make a function a command with these groups of options, by default on one mesh."""
    if MESH in arguments or MESHES in arguments:
        k = int(groups[0].title == "Input")
        groups = (*groups[:k], OptionGroup("Input", FORMAT), *groups[k:])
    params = [*arguments, *(option for group in groups for option in group.options)]
    return click.command(cls=Command, groups=groups, params=params)


def points_option(names: str, help: str) -> click.Option:
    """An option for points on the mesh, written as sources."""
    parse = SourceSpecs.parse
    help = f"{help} Written as in --source of geodesic: 12, face:17:0.2,0.3,0.5, near:X,Y,Z, max-y, @FILE and so on."
    settings: dict[str, Any] = {"multiple": True, "callback": lambda _context, _option, texts: parse(texts)}
    return option(names, "SPEC", Spec(source_files), help, **settings)


def is_given(parameter: str) -> bool:
    """Whether the command line sets this parameter of the current command."""
    return click.get_current_context().get_parameter_source(parameter) is ParameterSource.COMMANDLINE


FORMAT = option(
    "--format",
    "FORMAT",
    FormatName(),
    "Format of - (standard input), or of a file without known extension: off, obj, ply, stl, vtk ...",
    expose_value=False,
    callback=set_format,
)
SOURCE = option(
    "--source sources",
    "SPEC",
    Spec(source_files),
    f"Source points: {SOURCE_HELP}. May be repeated.  [default: max-y]",
    multiple=True,
    callback=lambda _context, _option, texts: SourceSpecs.parse(texts),
)
ROBUST = flag(
    "--robust",
    "Compute on the intrinsic Delaunay triangulation. For meshes with slivers, zero-area faces or edges of more than "
    "two faces.",
)
SOLVER = choice(
    "--solver",
    SolverName,
    "direct: factorization. multigrid: iteration, faster on large meshes. auto: by the number of vertices, with "
    "factorization if the iteration does not converge.",
)
ENGINE = choice(
    "--engine",
    EngineName,
    "petsc: distribute the mesh over the ranks of mpirun, for meshes beyond the memory of one machine; "
    "MESH is a binary .ply, an .off, or a .vtu or .vtp of raw arrays, and -o OUT.pvtu, .pvtp, .vtu or .vtp, for "
    "distances also .npy. Needs petsc4py and mpi4py.",
)
COLOR = option("--color color_spec", "SPEC", Spec(color_files), f"Initial color: {COLOR_HELP}.", default=DEFAULT_COLOR)
DT = option("--dt", "T", POSITIVE, "Time step.", default=DEFAULT_DT)
STEPS = option("--steps", "N", COUNT, "Number of the last step.", default=DEFAULT_STEPS)
EVERY = option("--every", "K", COUNT, "Steps from frame to frame.", default=DEFAULT_EVERY)
TRACERS = option(
    "--tracers",
    "N",
    Number(1, MAX_TRACERS, whole=True),
    "Number of particles carried by the flow. They are points of <OUT>.tracers.*.vtp, part 1 of the series, and "
    "streaks in films.",
)
QUIET = flag("-q --quiet", "Print nothing but errors.")
VERBOSE = flag("-v --verbose", "Print on stderr what is done, with times.")
REPORT = OptionGroup("Report", flag("--json as_json", "Print the report as JSON."), QUIET, VERBOSE, name="report")


def vector_field(name: str, help: str, **settings: Any) -> click.Option:
    """The option for a vector field; by default a rotation, unless it is required."""
    settings = settings or {"default": "rotation:x"}
    return option(name, "SPEC", Spec(field_files), help, **settings)
