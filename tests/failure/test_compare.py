"""``compare`` reports files that it cannot compare, with exit code 2."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.compare import Tolerance
from geomhw.errors import GeomhwError
from geomhw.io import write
from geomhw.mesh.primitives import icosphere
from geomhw.results import Result
from support.messages import missing
from support.program import run, save_off

BALL = icosphere(2)


pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize("rtol", [-1e-9, np.nan, np.inf])
def test_tolerances_are_checked(rtol):
    """Tolerances that are negative or not finite raise."""
    with pytest.raises(GeomhwError, match="rtol is"):
        Tolerance(rtol)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["a.off", "none.off"], "none.off ... no such file"),
        (["none.off", "a.off"], "none.off ... no such file"),
        (["none.csv", "a.csv"], "none.csv ... no such file"),
        (["none.pvd", "a.pvd"], "none.pvd ... no such file"),
        (["a.pvd", "lost.pvd"], "gone.vtp ... no such file"),
        (["a.pvd", "empty.pvd"], "empty.pvd ... without frames"),
        (["a.off", "a.csv"], "a.off (mesh) ... a.csv (table) ... cannot be compared"),
        (["a.xyz", "a.off"], "'.xyz' is not compared"),
        (["bad.json", "a.json"], "bad.json ... JSON"),
        (["bad.csv", "a.csv"], "row 0 ... 1 cells ... 2"),
        (["twice.csv", "a.csv"], "twice.csv ... two columns 'u'"),
        (["blank.csv", "a.csv"], "blank.csv ... names"),
        (["bad.npz", "bad.npz"], "bad.npz ... numpy file"),
        (["bad.mtx", "bad.mtx"], "bad.mtx ... Matrix Market"),
        (["bad.png", "bad.png"], "bad.png ... PNG"),
        (["a.off", "a.off", "--rtol", "-1"], "--rtol ... '-1' is not a number from 0"),
        (["a.off", "a.off", "--rtol", "nan"], "--rtol ... 'nan' is not a number from 0"),
        (["a.off", "a.off", "--rtol", "much"], "'much' is not a number"),
        (["a.off", "a.off", "--ignore", "*"], "nothing is compared"),
        (["a.off", "a.off", "--diff", "d.png"], "--diff is for pictures"),
        (["a.off"], "Missing argument"),
        (["folder.csv", "a.csv"], "folder.csv is a folder"),
    ],
)
def test_trouble_is_not_a_difference(arguments, words, folder):
    """Files that cannot be compared give exit code 2 and one line, and nothing on stdout."""
    save_off(icosphere(0), "a.off")
    write(Result(icosphere(0)), "a.00000.vtp")
    pvd = "<VTKFile><Collection>{}</Collection></VTKFile>"
    Path("a.pvd").write_text(pvd.format('<DataSet timestep="0" part="0" file="a.00000.vtp"/>'))
    Path("lost.pvd").write_text(pvd.format('<DataSet timestep="0" part="0" file="gone.vtp"/>'))
    Path("empty.pvd").write_text(pvd.format(""))
    Path("a.csv").write_text("u,v\n1,2\n")
    Path("a.json").write_text("{}")
    Path("bad.json").write_text("{")
    Path("bad.csv").write_text("u,v\n1\n")
    Path("twice.csv").write_text("u,u\n1,2\n")
    Path("blank.csv").write_text("\n\n")
    for name in ("bad.npz", "bad.mtx", "bad.png", "a.xyz"):
        Path(name).write_text("rubbish")
    Path("folder.csv").mkdir()
    answer = run("compare", *arguments)
    assert answer.exit_code == 2
    assert answer.stdout == ""
    assert not missing(answer.stderr, words)
    assert len([line for line in answer.stderr.splitlines() if line.startswith("Error")]) == 1


def test_trouble_says_which_file():
    """Of two files of one name, the message has the folder."""
    for where in "ab":
        Path(where).mkdir()
        save_off(BALL, f"{where}/m.off")
        Path(where, "m.json").write_text("{}")
        Path(where, "m.csv").write_text("u\n1\n")
    Path("b/m.off").write_text("rubbish")
    Path("b/m.json").write_text("rubbish {")
    Path("b/m.csv").write_text("u,u\n1,2\n")
    for name in ("m.off", "m.json", "m.csv"):
        answer = run("compare", f"a/{name}", f"b/{name}")
        assert answer.exit_code == 2
        assert f"b/{name}" in answer.stderr
        assert f"a/{name}" not in answer.stderr


def test_other_commands_still_fail_with_one():
    """Other commands exit with code 1 on failure."""
    assert run("info", "none.off").exit_code == 1
