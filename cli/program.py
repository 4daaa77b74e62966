"""The ``geomhw`` program: its commands, and the conversion of errors to messages and exit codes."""

import io
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import click

from geomhw import __version__
from geomhw.errors import ArgumentError, GeomhwError, Remedy
from geomhw_cli.advect import advect
from geomhw_cli.batch import batch
from geomhw_cli.bracket import bracket
from geomhw_cli.center import center
from geomhw_cli.compare import compare
from geomhw_cli.completion import completion
from geomhw_cli.derive import derive
from geomhw_cli.design import design
from geomhw_cli.extrema import extrema
from geomhw_cli.fluid import fluid
from geomhw_cli.geodesic import geodesic
from geomhw_cli.gradient import gradient
from geomhw_cli.helmholtz import helmholtz
from geomhw_cli.info import info
from geomhw_cli.isolines import isolines
from geomhw_cli.killing import killing
from geomhw_cli.logmap import logmap
from geomhw_cli.merge import merge
from geomhw_cli.operators import operators
from geomhw_cli.path import path
from geomhw_cli.push import push
from geomhw_cli.repair import repair
from geomhw_cli.rois import rois
from geomhw_cli.runtime import interrupts
from geomhw_cli.runtime.pictures import keep_command_line
from geomhw_cli.sample import sample
from geomhw_cli.signed import signed
from geomhw_cli.smooth import smooth
from geomhw_cli.spectrum import spectrum
from geomhw_cli.split import split
from geomhw_cli.streamlines import streamlines
from geomhw_cli.trace import trace
from geomhw_cli.vecdiffuse import vecdiffuse
from geomhw_cli.view import view
from geomhw_cli.voronoi import voronoi

#: The option that stands for an argument of the library which avoids an error.
REMEDIES: dict[Remedy, str] = {
    "robust=True": "--robust",
    "solver='direct'": "--solver direct",
    "refine=False": "--no-refine",
}


WRONG_USAGE = 2


class Program(click.Group):
    """Turn an error of the library into one line on stderr and an exit code."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Choose the exit code of failures by the command line."""
        ctx.obj = failure_code(args)
        keep_command_line(ctx, args)
        return super().parse_args(ctx, args)

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Find the command; a file in its place gets an example."""
        if args[0] not in self.commands and os.path.isfile(args[0]):
            raise click.UsageError(f"The command comes before the mesh, as in: geomhw info {args[0]}", ctx)
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        try:
            with interrupts.restored():
                return super().invoke(ctx)
        except (GeomhwError, MemoryError) as error:
            click.echo(f"Error: {_message(error)}", err=True)
            ctx.exit(WRONG_USAGE if isinstance(error, ArgumentError) else ctx.obj)
        except BrokenPipeError:  # the reader of standard output has ended
            _close_output()
            ctx.exit(ctx.obj)
        except KeyboardInterrupt as stop:
            if not str(stop):
                raise
            click.echo(f"Error: interrupted; {stop}", err=True)
            ctx.exit(interrupts.exit_code())


def failure_code(arguments: Sequence[str]) -> int:
    """Return 2 for ``compare`` and ``info --check``, where exit code 1 is an answer, and else 1."""
    return 2 if arguments[:1] == ["compare"] or (arguments[:1] == ["info"] and "--check" in arguments) else 1


def _message(error: GeomhwError | MemoryError) -> str:
    """The message of an error, in which an option replaces the argument that avoids the error."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for this mesh"
    return str(error).replace(error.remedy, REMEDIES[error.remedy]) if error.remedy else str(error)


@click.group(
    cls=Program,
    context_settings={
        "help_option_names": ["-h", "--help"],
        "max_content_width": 100,
        "auto_envvar_prefix": "GEOMHW",
    },
)
@click.version_option(__version__, "-V", "--version", prog_name="geomhw")
def program() -> None:
    """Geometry on triangle meshes: distances, vector transport, decompositions and flows, with pictures.

    \b
    Exit codes: 0 success; 1 invalid input or failed computation, with one line on stderr
    and no incomplete output file; 2 a wrong value on the command line; 130 after Ctrl-C,
    143 after SIGTERM. Of compare: 0 same, 1 different, 2 failure. Of info --check: 0 no
    defects, 1 defects, 2 failure.

    \b
    Defaults of options: GEOMHW_COMMAND_OPTION, such as GEOMHW_FLUID_SCHEME=rk4 or
    GEOMHW_GEODESIC_ROBUST=1; the command line overrides them.

    \b
    Completion by the Tab key, also in zsh and fish:
      geomhw completion bash --install
    """


for command in (
    advect,
    batch,
    bracket,
    center,
    compare,
    completion,
    derive,
    design,
    extrema,
    fluid,
    geodesic,
    gradient,
    helmholtz,
    info,
    isolines,
    killing,
    logmap,
    merge,
    operators,
    path,
    push,
    repair,
    rois,
    sample,
    signed,
    smooth,
    spectrum,
    split,
    streamlines,
    trace,
    vecdiffuse,
    view,
    voronoi,
):
    program.add_command(command)


def run() -> int:
    """Run the program and return the exit code; interrupts are raised."""
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a terminal without Greek letters prints \u03c0 for π
            stream.reconfigure(errors="backslashreplace")
    try:
        code = program.main(prog_name="geomhw", standalone_mode=False)
        sys.stdout.flush()
        return int(code or 0)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except click.Abort:
        raise KeyboardInterrupt from None
    except OSError as error:  # of standard output; errors of files are FormatErrors
        where = error.filename or "cannot write standard output"
        click.echo(f"Error: {where}: {error.strerror or error}", err=True)
        _close_output()
        return failure_code(sys.argv[1:])


def _close_output() -> None:
    """Send the rest of standard output to the null device; flushing it at exit would fail again, with a traceback."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
