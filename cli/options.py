"""Arguments and options that several commands share, each declared once."""

from pathlib import Path
from typing import Any, get_args

import click

from geomhw.options import Boundary, SolverName
from geomhw_cli.specs.sources import SOURCE_HELP, SourceSpecs

FILE = click.Path(path_type=Path)


class Choice(click.Choice[str]):
    """A choice among names, where former names are still understood."""

    def __init__(self, names: tuple[str, ...], former: dict[str, str]) -> None:
        super().__init__(names)
        self._former = former

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name as the library knows it."""
        return super().convert(self._former.get(value, value), param, ctx)


def choice(names: Any, **former: str) -> Choice:
    """A choice among the names of a Literal of `geomhw.options`; ``former``: earlier names of some of them."""
    return Choice(get_args(names), former)


mesh_argument = click.argument("mesh_path", metavar="MESH", type=FILE)

source_option = click.option(
    "--source",
    "sources",
    metavar="SPEC",
    multiple=True,
    callback=lambda _context, _option, texts: SourceSpecs.parse(texts),
    help=f"Where it starts: {SOURCE_HELP}. May be repeated.  [default: max-y]",
)

time_option = click.option(
    "--time",
    metavar="T",
    default="auto",
    show_default=True,
    help="How long heat flows: auto, sqrt-h, h2, a multiple such as 0.5*h2, or a number (length squared). "
    "auto is sqrt-h (h the mean edge length) where that is a short time, else h2.",
)

robust_option = click.option(
    "--robust",
    is_flag=True,
    help="Compute on the intrinsic Delaunay triangulation: for slivers, faces without area, edges where three "
    "faces meet.",
)

refine_option = click.option(
    "--refine/--no-refine",
    default=None,
    help="Correct the distances by unfolding them from triangle to triangle.  [default: with --robust]",
)

boundary_option = click.option(
    "--boundary",
    type=choice(Boundary),
    default="neumann",
    show_default=True,
    help="How heat meets the boundary of an open mesh: none leaves, it is kept cold, or the mean of both, which is "
    "best next to it.",
)

solver_option = click.option(
    "--solver",
    type=choice(SolverName),
    default="auto",
    show_default=True,
    help="direct factors; multigrid iterates, in a fraction of the time on large meshes; auto goes by the size, and "
    "factors where iteration does not converge.",
)

output_option = click.option(
    "-o",
    "--output",
    "outputs",
    metavar="FILE",
    type=FILE,
    multiple=True,
    help="Mesh with the computed arrays: .vtk, .vtp, .vtu or .ply; may be repeated.",
)

png_option = click.option("--png", metavar="FILE", type=FILE, help="Picture.")
width_option = click.option(
    "--width",
    metavar="PX",
    type=click.IntRange(120, 4000),
    default=600,
    show_default=True,
    help="Width of each panel of a picture, in pixels.",
)
no_png_option = click.option("--no-png", is_flag=True, help="No picture.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print the whole report as JSON.")
quiet_option = click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
