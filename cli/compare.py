"""``geomhw compare``: whether two files hold the same."""

from pathlib import Path

import click

from geomhw.compare.rules import HEAVIEST_SPOT
from geomhw_cli import options


@click.command(no_args_is_help=True, short_help="Whether two results hold the same.")
@click.argument("one", metavar="A", type=options.FILE)
@click.argument("other", metavar="B", type=options.FILE)
@click.option(
    "--rtol",
    metavar="R",
    type=float,
    help="Relative tolerance.  [default: 1e-9; 1e-6 for an array that A or B stores in single precision]",
)
@click.option("--atol", metavar="A", type=float, default=0.0, show_default=True, help="Absolute tolerance.")
@click.option(
    "--ignore",
    metavar="NAME",
    multiple=True,
    help="Array, column or value to leave out; * and ? stand for any letters and any letter. May be repeated.",
)
@click.option("--everything", is_flag=True, help="Of JSON: also seconds, files, path and file.")
@click.option(
    "--spot",
    metavar="W",
    type=click.FloatRange(min=0),
    default=HEAVIEST_SPOT,
    help="Weight of the heaviest spot that passes in a picture.  [default: 200]",
)
@click.option("--diff", metavar="FILE", type=options.FILE, help="Of pictures: PNG that shows where they differ.")
@options.json_option
@options.quiet_option
def compare(
    one: Path,
    other: Path,
    rtol: float | None,
    atol: float,
    ignore: tuple[str, ...],
    everything: bool,
    spot: float,
    diff: Path | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Whether A and B hold the same: two meshes with arrays, in whatever formats, two time series (.pvd), tables
    (.csv), JSON documents, matrices or arrays (.mtx .npz .npy), or pictures (.png).

    Prints a line for each array: same or different, where it lies, its name and size, the worst deviation, its index
    (counted from 0), the value in A and in B. An array that one file lacks is a difference.

    \b
    Numbers   pass where |a - b| <= atol + rtol * scale. The scale is the largest finite
              magnitude in the two arrays (of positions: the diagonal of the bounding box; of a
              time series: frame by frame), so a value near zero is held to the accuracy of its
              array, and the order of A and B does not matter. NaN equals NaN, inf equals inf.
              Integers, faces and texts must be equal.
    Series    Frame by frame, times too; the line is that of the worst frame. Tracers are left out.
    Tables    Columns go by name, in any order.
    JSON      Values go by path, as in mesh.vertices or times[0].t. A list of numbers is an array,
              any other number a scale of its own. Without --everything, what differs from run to
              run is left out: seconds, files, path, file.
    Matrices  go entry by entry; what is not stored is zero.
    Pictures  A pixel counts by how far its color (CIELAB, dE*ab > 2.3) lies outside of those that
              the other picture has within half a pixel, so other anti-aliasing passes. Such
              pixels that touch make a spot, which weighs the sum of their dE*ab: 200 is two black
              pixels on white; a changed digit weighs 260 and more, a lost arrow 900.

    \b
    Exit codes: 0 same; 1 different; 2 trouble (a file that cannot be read, files of two
    kinds, wrong usage).

    \b
    Example, of one result in two formats:
      geomhw geodesic data/torus.off -o torus.vtk -o torus.ply
      geomhw compare torus.vtk torus.ply --rtol 1e-8
    """
    import json

    from geomhw.compare import Ignored, Tolerance, compare_files

    if diff:
        _check_diff(diff, one, other)
    found = compare_files(one, other, Tolerance(rtol, atol), Ignored(ignore), spot, everything)
    if diff:
        _write_diff(diff, one, other, spot)
    if as_json:
        report = {
            "command": "compare",
            "a": {"path": str(one)},
            "b": {"path": str(other)},
            "kind": found.kind,
            "same": found.same,
            "rtol": rtol,
            "atol": atol,
            "ignore": list(ignore),
            "findings": [finding.as_json() for finding in found.findings],
            "files": [str(diff)] if diff else [],
        }
        click.echo(json.dumps(report, indent=2, allow_nan=False))
    elif not quiet:
        click.echo(found)
    click.get_current_context().exit(0 if found.same else 1)


def _check_diff(diff: Path, one: Path, other: Path) -> None:
    """That there are pictures, and that the picture of their difference can be written."""
    from geomhw.compare.files import kind_of
    from geomhw.io import check_outputs

    if kind_of(one) != "picture":
        raise click.UsageError("--diff is for pictures; A and B are none.")
    check_outputs([diff], [one, other], extensions=[".png"])


def _write_diff(diff: Path, one: Path, other: Path, spot: float) -> None:
    from geomhw.compare.pictures import difference_picture
    from geomhw.io.artifacts.images import read_png, write_png

    write_png(diff, difference_picture(read_png(one), read_png(other), spot))
