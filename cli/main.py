"""The ``geomhw`` program: its commands, and the one place where an error becomes a message and an exit code."""

import io
import os
import signal
import sys
from typing import Any, NoReturn

import click

from geomhw import __version__
from geomhw.errors import GeomhwError
from geomhw_cli.advect import advect
from geomhw_cli.compare import compare
from geomhw_cli.fluid import fluid
from geomhw_cli.geodesic import geodesic
from geomhw_cli.helmholtz import helmholtz
from geomhw_cli.info import info
from geomhw_cli.operators import operators
from geomhw_cli.trouble import Trouble
from geomhw_cli.vecdiffuse import vecdiffuse

#: What the libraries of linear algebra read, before they are loaded, for how many threads to use.
BLAS_THREADS = [f"{name}_NUM_THREADS" for name in ("OPENBLAS", "MKL", "BLIS", "OMP")] + ["VECLIB_MAXIMUM_THREADS"]


class Program(click.Group):
    """Turns what the library refuses into one line on stderr and exit code 1, or 2 of ``compare``."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except GeomhwError as error:
            raise self._failure(ctx, str(error)) from error
        except MemoryError as error:
            raise self._failure(ctx, "there is not enough memory for this mesh") from error

    def _failure(self, ctx: click.Context, message: str) -> click.ClickException:
        return (Trouble if ctx.invoked_subcommand == "compare" else click.ClickException)(message)


@click.group(cls=Program, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="geomhw")
def program() -> None:
    """Geometry on triangle meshes: distances, decompositions and flows, with pictures.

    \b
    Exit codes: 0 done; 1 the input or the computation failed (one line on stderr says
    why, and no output is left half written); 2 wrong usage. Of compare: 0 same,
    1 different, 2 trouble; of info --check: 0 no defect, 1 defects, 2 trouble.

    \b
    Completion by the Tab key, in bash:
      eval "$(_GEOMHW_COMPLETE=bash_source geomhw)"
    """


for command in (advect, compare, fluid, geodesic, helmholtz, info, operators, vecdiffuse):
    program.add_command(command)


def main() -> None:
    """Entry point of the console script."""
    # More threads of BLAS add up in another order: the last digits would depend on the machine's cores.
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
    # kill and a closed terminal are Ctrl-C by other means: what is half written goes away.
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _interrupt)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a terminal without Greek letters gets \u03c0 for π
            stream.reconfigure(errors="backslashreplace")
    try:
        program.main(prog_name="geomhw")
    except OSError as error:  # of what is printed; files have sentences of their own
        about = error.filename or "standard output"
        click.echo(f"Error: cannot write {about}: {error.strerror or error}", err=True)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left to print would fail again, with a traceback
        sys.exit(Trouble.exit_code if sys.argv[1:2] == ["compare"] else 1)


def _interrupt(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt
