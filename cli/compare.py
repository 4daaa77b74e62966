"""``geomhw compare``: whether two files hold the same values."""

import math
from pathlib import Path
from typing import Any

import click

from geomhw.compare.rules import DOUBLE, HEAVIEST_SPOT, SINGLE
from geomhw_cli.options import FORMAT, INPUT, OUTPUT, REPORT, OptionGroup, command, flag, is_given, option
from geomhw_cli.runtime.job import print_json
from geomhw_cli.specs.files import STANDARD, input_as_file, require_writable
from geomhw_cli.specs.numbers import Number

TOLERANCE = Number(0, math.inf)


@command(
    OptionGroup("Input", FORMAT),
    OptionGroup(
        "Numbers",
        option(
            "--rtol",
            "R",
            TOLERANCE,
            f"Relative tolerance.  [default: {DOUBLE:g}; {SINGLE:g} for arrays stored in single precision]",
        ),
        option("--atol", "A", TOLERANCE, "Absolute tolerance.", default=0.0),
        option(
            "--ignore",
            "NAME",
            str,
            "Array, column or value to leave out; * stands for any letters, ? for any letter. May be repeated.",
            multiple=True,
        ),
        flag("--everything", "In JSON: compare also seconds, files, path and file."),
    ),
    OptionGroup(
        "Pictures",
        option("--spot", "W", TOLERANCE, "Weight of the heaviest spot that passes.", default=HEAVIEST_SPOT),
        option("--diff", "FILE", OUTPUT, "PNG that shows where the pictures differ."),
    ),
    REPORT,
    arguments=[click.Argument([name], metavar=letter, type=INPUT) for name, letter in (("one", "A"), ("other", "B"))],
)
def compare(
    one: Path,
    other: Path,
    rtol: float | None,
    atol: float,
    ignore: tuple[str, ...],
    everything: bool,
    spot: float,
    diff: Path | None,
    report: dict[str, Any],
) -> None:
    """Compare the values in A and B.

    A and B are two meshes with arrays, of any formats, two time series (.pvd), tables (.csv), JSON documents, matrices
    or arrays (.mtx .npz .npy), or pictures (.png). One of them may be - (standard input); by default it has the format
    of the other.

    Prints one line per array: same or different, its location, name and size, the largest deviation, its index
    (counted from 0), and the values in A and in B. An array that one file lacks is a difference.

    \b
    Numbers   agree if |a - b| <= atol + rtol * scale. The scale is the largest finite
              magnitude in the two arrays (for positions: the diagonal of the bounding box;
              for a time series: in each frame), so values near zero need the accuracy of
              their array, and the order of A and B does not matter. NaN equals NaN, inf
              equals inf. Integers, faces and texts must be equal.
    Series    are compared frame by frame, with times; the line is that of the worst frame.
              Tracers are left out.
    Tables    Columns are matched by name, in any order.
    JSON      Values are matched by path, as in mesh.vertices or times[0].t. A list of numbers
              is an array, any other number has its own scale. Without --everything, seconds,
              files, path and file are left out, since they differ from run to run.
    Matrices  are compared entry by entry; an entry that is not stored is zero.
    Pictures  A pixel differs by the distance of its color (CIELAB, dE*ab > 2.3) from the colors
              in the other picture within half a pixel, so other anti-aliasing passes. Connected
              pixels that differ are a spot, whose weight is the sum of their dE*ab: 200 is two
              black pixels on white; a changed digit weighs 260 and more, a lost arrow 900.

    \b
    Exit codes: 0 same; 1 different; 2 failure (unreadable file, files of two kinds,
    wrong usage).

    \b
    Example, one result in two formats:
      geomhw geodesic data/torus.off -o torus.vtk -o torus.ply
      geomhw compare torus.vtk torus.ply --rtol 1e-8
    """
    from geomhw.compare import Ignored, Tolerance, compare_files

    if one == other == STANDARD:
        raise click.UsageError("A and B are both standard input; give one of them as a file.")
    if STANDARD not in (one, other) and is_given("format"):
        raise click.UsageError("--format is for - (standard input); the extensions of A and B name their formats.")
    with input_as_file(one, other.suffix) as a, input_as_file(other, one.suffix) as b:
        if diff:
            _check_diff(diff, a)
        comparison = compare_files(a, b, Tolerance(rtol, atol), Ignored(ignore), spot, everything)
        if diff:
            _write_diff(diff, a, b, spot)
    if report["as_json"] and not report["quiet"]:
        print_json(
            {
                "command": "compare",
                "a": {"path": str(one)},
                "b": {"path": str(other)},
                "kind": comparison.kind,
                "same": comparison.same,
                "rtol": rtol,
                "atol": atol,
                "ignore": list(ignore),
                "findings": [finding.as_json() for finding in comparison.findings],
                "files": [str(diff)] if diff else [],
            }
        )
    elif not report["quiet"]:
        click.echo(comparison)
    click.get_current_context().exit(0 if comparison.same else 1)


def _check_diff(diff: Path, one: Path) -> None:
    """Raise an error unless A is a picture and the picture of the difference can be written."""
    from geomhw.compare.files import kind_of

    if kind_of(one) != "picture":
        raise click.UsageError("--diff is for pictures, but A and B are of another kind.")
    require_writable([diff], [".png"])


def _write_diff(diff: Path, one: Path, other: Path, spot: float) -> None:
    from geomhw.compare.pictures import difference_picture
    from geomhw.io.artifacts.images import read_png, write_png

    write_png(diff, difference_picture(read_png(one), read_png(other), spot))
