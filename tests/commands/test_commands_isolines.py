"""``isolines``: outputs, levels, reports, refusals and the picture."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.curves import isolines
from geomhw.io import read_cloud, read_csv, write
from geomhw.mesh import grid, icosphere
from geomhw.results import Field, Result
from support.program import one_line, run, save_off

BALL = icosphere(3)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a sphere and its height."""
    height = BALL.vertices[:, 2].copy()
    fields = [Field("height", "vertex", height), Field("area", "face", BALL.face_areas)]
    write(Result(BALL, [*fields, Field("normal", "vertex", BALL.vertex_normals)]), "ball.vtp")
    return folder


def test_files_agree() -> None:
    """VTP, CSV and JSON hold the same lines, and the report their lengths."""
    outputs = ["-o", "i.vtp", "-o", "i.csv", "-o", "i.json"]
    answer = run("isolines", "ball.vtp:height", "--every", "0.5", *outputs, "--json")
    assert answer.exit_code == 0, answer.output
    report, lines = json.loads(answer.stdout), json.loads(Path("i.json").read_text())
    found = isolines(BALL, BALL.vertices[:, 2], [-0.5, 0, 0.5])
    assert [item["level"] for item in report["levels"]] == [item["level"] for item in lines] == [-0.5, 0, 0.5]
    assert [item["length"] for item in report["isolines"]] == found.lengths.tolist()
    assert [item["enclosed_area"] for item in lines] == found.enclosed_areas.tolist()
    np.testing.assert_array_equal(np.concatenate([item["points"] for item in lines]), found.positions)
    np.testing.assert_array_equal(np.concatenate([item["barycentric"] for item in lines]), found.weights)
    table, cloud = read_csv("i.csv"), read_cloud("i.vtp")
    assert list(table) == ["path", "x", "y", "z", "face", "b0", "b1", "b2", "arc_length", "level", "closed"]
    np.testing.assert_array_equal(np.stack([table[k] for k in "xyz"], axis=1), cloud.points)
    np.testing.assert_array_equal(cloud.lines, found.starts)
    assert set(table["closed"]) == {1}
    ends = np.append(np.flatnonzero(np.diff(table["path"])), -1)
    np.testing.assert_allclose(table["arc_length"][ends], found.lengths, rtol=1e-12)


def test_cell_arrays_as_vtk_reads_them() -> None:
    """VTK finds the arrays of each line."""
    pyvista = pytest.importorskip("pyvista")
    assert run("isolines", "ball.vtp:height", "--count", "3", "-o", "i.vtp", "--no-png").exit_code == 0
    found = pyvista.read("i.vtp")
    assert set(found.cell_data) == {"level", "length", "closed", "enclosed_area", "area_below", "area_above"}
    length = found.compute_cell_sizes(area=False, volume=False)["Length"]
    np.testing.assert_allclose(length, found.cell_data["length"], rtol=1e-12)
    np.testing.assert_allclose(found.cell_data["level"], [-0.5, 0, 0.5], atol=1e-12)


def test_between() -> None:
    """Levels between two sides of a square are straight lines at fixed shares; arrays come from another file, too."""
    save_off(grid(6, 6), "square.off")
    options = ["--between", "min-x,35,42", "max-x", "--count", "3"]
    assert run("isolines", "square.off", *options, "-o", "b.json", "--no-png").exit_code == 0
    assert [item["level"] for item in json.loads(Path("b.json").read_text())] == [0.25, 0.5, 0.75]
    np.save("x.npy", grid(6, 6).vertices[:, 0])
    assert run("isolines", "square.off", "--array", "x.npy", "--level", "0.3", "-o", "x.json").exit_code == 0
    (line,) = json.loads(Path("x.json").read_text())
    np.testing.assert_allclose(np.array(line["points"])[:, 0], 0.3, atol=1e-12)
    assert (line["closed"], line["area_below"]) == (False, pytest.approx(0.3))


def test_infinite_values_are_left_out() -> None:
    """Vertices without a finite value are counted in a remark."""
    values = BALL.vertices[:, 2].copy()
    values[:5] = np.inf
    np.save("u.npy", values)
    save_off(BALL)
    answer = run("isolines", "ball.off", "--array", "u.npy", "--level", "0", "-o", "i.vtp")
    assert answer.exit_code == 0, answer.output
    assert "5 vertices with infinite or undefined values" in answer.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["ball.vtp:area"], ["area", "faces", "vertex"]),
        (["ball.vtp:normal"], ["normal", "3 numbers"]),
        (["ball.vtp:heat"], ["no array 'heat'", "height"]),
        (["ball.vtp"], ["which array", "height"]),
        (["ball.vtp:height", "--level", "7"], ["from -1 to 1", "7"]),
        (["ball.vtp:height", "--level", "inf"], ["finite"]),
        (["ball.vtp:height", "--every", "1e-9"], ["more than 10000"]),
        (["ball.vtp:height", "--every", "5e-1", "--count", "3"], ["exclude"]),
        (["ball.vtp:height", "--between", "0", "1"], ["ball.vtp", "without an array"]),
        (["ball.vtp", "--between", "0,1", "1"], ["vertex 1", "both"]),
        (["none.vtp:height"], ["none.vtp", "no such file"]),
        (["ball.vtp:height", "-o", "i.stl"], ["i.stl", ".json"]),
    ],
)
def test_refusals(arguments: list[str], words: list[str]) -> None:
    """One sentence, and no file."""
    answer = run("isolines", *arguments, *([] if "-o" in arguments else ["-o", "i.vtp"]))
    assert answer.exit_code in (1, 2)
    message = answer.stderr.splitlines()[-1]
    assert [word for word in words if word not in message] == [], message
    assert not Path("i.vtp").exists()


def test_constant_array() -> None:
    """A constant has no isolines: one line on stderr."""
    np.save("u.npy", np.ones(BALL.n_vertices))
    save_off(BALL)
    answer = run("isolines", "ball.off", "--array", "u.npy", "-o", "i.vtp")
    one_line(answer, "1 at all vertices")
