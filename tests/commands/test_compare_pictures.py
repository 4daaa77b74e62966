"""``geomhw compare`` on pictures: verdict, report, and the picture of the difference."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.compare import compare_files
from geomhw.compare.pictures import difference_picture
from geomhw.io.artifacts.images import read_png
from support.pictures import PLAIN, drawing, save
from support.program import run

pytestmark = pytest.mark.usefixtures("folder")


def test_command():
    """Exit codes, and one line with number, size and place of the deviations, also in the report."""
    save("a.png", PLAIN)
    save("b.png", drawing(without=5))
    assert run("compare", "a.png", "a.png").exit_code == 0
    answer = run("compare", "a.png", "b.png")
    assert answer.exit_code == 1
    for words in ("different", "240 x 160", "of 38400 pixels unequal", "255 levels", "(200 passes), at x 6"):
        assert words in answer.stdout
    report = json.loads(run("compare", "a.png", "b.png", "--json", "--diff", "d.png").stdout)
    assert report["files"] == ["d.png"]
    (found,) = report["findings"]
    assert found["details"]["unequal_pixels"] >= found["details"]["noticeable_pixels"] > 20
    assert found["tolerance"] == 200
    assert run("compare", "a.png", "b.png", "--spot", "5000").exit_code == 0
    assert run("compare", "a.png", "b.png", "--spot", "-1").exit_code == 2


def test_difference_picture():
    """The difference is drawn as gray for equal, blue for unequal, red for noticeable pixels, and orange frames."""
    save("a.png", PLAIN)
    other = drawing(without=5).copy()
    other[5, 5, :3] = 254
    save("b.png", other)
    assert run("compare", "a.png", "b.png", "--diff", "d.png", "-q").exit_code == 1
    shown = read_png("d.png")[..., :3]
    equal = (other == PLAIN).all(axis=2)
    is_orange = (shown == (240, 130, 0)).all(axis=2)
    pale = shown[equal & ~is_orange]
    assert (pale == pale[:, :1]).all()
    assert pale.min() > 160
    assert tuple(shown[5, 5]) == (175, 205, 240)
    red = (shown == (200, 0, 60)).all(axis=2)
    assert red.sum() == compare_files("a.png", "b.png").findings[0].details["noticeable_pixels"]
    rows, columns = np.nonzero(is_orange)
    (spot,) = compare_files("a.png", "b.png").findings[0].details["heaviest_spots"][:1]
    assert (columns.min(), columns.max()) == (spot["x"][0] - 6, spot["x"][1] + 6)
    assert (rows.min(), rows.max()) == (spot["y"][0] - 6, spot["y"][1] + 6)
    before = Path("d.png").read_bytes()
    run("compare", "a.png", "b.png", "--diff", "d.png")
    assert Path("d.png").read_bytes() == before


def test_other_sizes():
    """Pictures of different sizes give one line; the difference covers both, orange where one is missing."""
    save("a.png", PLAIN)
    save("b.png", PLAIN[:100, :200])
    answer = run("compare", "a.png", "b.png", "--diff", "d.png")
    assert answer.exit_code == 1
    assert "240 x 160 in A, 200 x 100 in B" in answer.stdout
    shown = read_png("d.png")[..., :3]
    assert shown.shape == (160, 240, 3)
    assert (shown[100:] == (240, 130, 0)).all()
    np.testing.assert_array_equal(shown[:100, :200], difference_picture(PLAIN[:100, :200], PLAIN[:100, :200]))
