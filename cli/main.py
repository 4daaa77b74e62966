"""The ``geomhw`` program: its commands, and the one place where an error becomes a message and an exit code."""

from typing import Any

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
    """


for command in (advect, compare, fluid, geodesic, helmholtz, info, operators, vecdiffuse):
    program.add_command(command)


def main() -> None:
    """Entry point of the console script."""
    program.main(prog_name="geomhw")
