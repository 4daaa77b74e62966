"""``geomhw compare``: exit codes, lines and report."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import write
from geomhw.mesh.primitives import icosphere
from support.comparisons import arrays_on, planted
from support.program import run

BALL = icosphere(2)


pytestmark = pytest.mark.usefixtures("folder")


def test_exit_codes_and_lines():
    """Exit codes 0 and 1; one line per array with verdict, location, name, size and largest deviation."""
    result = arrays_on(BALL)
    write(result, "a.vtp")
    write(planted(result, "wind", (9, 2), 5.0), "b.vtp")
    answer = run("compare", "a.vtp", "a.vtp")
    assert (answer.exit_code, answer.stdout.splitlines()[-1]) == (0, "same: 6 compared")
    answer = run("compare", "a.vtp", "b.vtp")
    assert answer.exit_code == 1
    (line,) = [line for line in answer.stdout.splitlines() if "wind" in line]
    assert line.split()[:6] == ["different", "vertex", "wind", "162", "x", "3"]
    before = float(np.asarray(result["wind"])[9, 2])
    assert f"at [9, 2]: {before!r} in A, 5.0 in B" in line
    assert answer.stdout.splitlines()[-1] == "different: 1 of 6 differ"
    assert (run("compare", "a.vtp", "b.vtp", "-q").exit_code, run("compare", "a.vtp", "b.vtp", "-q").output) == (1, "")
    assert run("compare", "a.vtp", "b.vtp", "--ignore", "wind").exit_code == 0
    assert run("compare", "a.vtp", "b.vtp", "--atol", "10").exit_code == 0
    assert run("compare", "a.vtp", "b.vtp", "--rtol", "1e-3").exit_code == 1


def test_report():
    """``--json`` prints files, tolerances and findings; values that are not finite are words."""
    result = arrays_on(BALL)
    write(result, "a.vtp")
    write(planted(result, "reach", (0,), 1.0), "b.vtp")
    answer = run("compare", "a.vtp", "b.vtp", "--rtol", "1e-8", "--ignore", "gale", "--json")
    report = json.loads(answer.stdout)
    assert answer.exit_code == 1
    assert (report["command"], report["kind"], report["same"]) == ("compare", "mesh", False)
    assert (report["a"], report["rtol"], report["ignore"]) == ({"path": "a.vtp"}, 1e-8, ["gale"])
    assert [f["name"] for f in report["findings"]] == ["positions", "faces", "reach", "wind", "label"]
    found = report["findings"][2]
    assert (found["same"], found["index"], found["values"], found["absolute"]) == (False, [0], ["inf", 1.0], "inf")
    assert json.loads(run("compare", "a.vtp", "a.vtp", "--json").stdout)["same"] is True


def test_complex_values_in_a_report():
    """Complex values are pairs of numbers in the report."""
    np.save("a.npy", np.array([1 + 2j]))
    np.save("b.npy", np.array([1 + 3j]))
    report = json.loads(run("compare", "a.npy", "b.npy", "--json").stdout)
    assert report["findings"][0]["values"] == [[1, 2], [1, 3]]


def test_same_bytes_elsewhere(folder):
    """Files of equal names in two folders are compared."""
    (folder / "golden").mkdir()
    write(arrays_on(BALL), "m.vtk")
    shutil.copy("m.vtk", "golden/m.vtk")
    assert run("compare", "golden/m.vtk", "m.vtk").exit_code == 0


def test_standard_input():
    """``-`` is compared in the format of the other file, or the one that ``--format`` names; messages name it."""
    result = arrays_on(BALL)
    for name in ("a.vtp", "a.ply"):
        write(result, name)
    data = Path("a.vtp").read_bytes()
    assert run("compare", "-", "a.vtp", stdin=data).exit_code == 0
    assert run("compare", "a.ply", "-", "--format", "vtp", stdin=data).exit_code == 0
    answer = run("compare", "a.ply", "-", stdin=data)
    assert answer.exit_code == 2
    assert "standard input" in answer.stderr
    assert "/stdin" not in answer.stderr
    write(planted(result, "wind", (9, 2), 5.0), "b.vtp")
    assert run("compare", "b.vtp", "-", stdin=data).exit_code == 1
    assert run("compare", "-", "-", stdin=data).exit_code == 2
    assert run("compare", "a.vtp", "a.ply", "--format", "vtp").exit_code == 2
