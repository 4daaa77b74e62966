"""``geomhw bracket`` and ``geomhw derive``: arrays, reports, matrices and refusals."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import load_npz

from geomhw.flow import rigid_field
from geomhw.io import read
from geomhw.mesh.primitives import icosphere, moebius_band
from support.pictures import needs_opengl
from support.program import one_line, run, save_off

pytestmark = pytest.mark.usefixtures("folder")


def test_bracket_of_rotations() -> None:
    """The bracket of two rotations is the third; the commutator applies it to functions."""
    mesh = icosphere(3)
    save_off(mesh)
    line = ["--field", "rigid:x", "--field", "rigid:y", "-o", "b.vtp", "--commutator", "c.npz", "--json"]
    report = json.loads(run("bracket", "ball.off", *line).stdout)
    found = read("b.vtp")
    assert [field.name for field in found.fields] == ["bracket", "first", "second"]
    np.testing.assert_allclose(found["bracket"], -rigid_field(mesh, [0, 0, 1]), atol=0.006)
    np.testing.assert_allclose(list(report["energies"].values()), 8 * np.pi / 3, rtol=0.02)
    x, y, _ = mesh.vertices.T
    np.testing.assert_allclose(load_npz("c.npz") @ x, y, atol=0.05)
    assert report["files"] == ["b.vtp", "c.npz"]
    answer = run("bracket", "ball.off", "--field", "random:1", "--field", "b.vtp:bracket", "-o", "c.vtp")
    assert "energy" in answer.stdout


def test_derivatives_of_a_rotation() -> None:
    """All arrays, with the direction V by default, in each format."""
    mesh = icosphere(3)
    save_off(mesh)
    report = json.loads(run("derive", "ball.off", "--field", "rigid:z", "-o", "d.vtk", "-o", "d.ply", "--json").stdout)
    found = read("d.vtk")
    names = ["field", "covariant_derivative", "strain", "hodge_laplacian", "divergence", "curl"]
    assert {field.name for field in found.fields} == set(names) == set(report["root_mean_square"])
    assert found["strain"].shape == (mesh.n_faces, 9)
    np.testing.assert_allclose(found["curl"], 2 * mesh.vertices[:, 2], atol=0.002)
    np.testing.assert_allclose(found["hodge_laplacian"], 2 * rigid_field(mesh, [0, 0, 1]), atol=0.005)
    assert np.abs(found["strain"]).max() < 2e-4
    along = run("derive", "ball.off", "--field", "rigid:z", "--along", "rigid:x", "-o", "x.vtp", "--json")
    assert json.loads(along.stdout)["along"] == "rigid:x"


@needs_opengl
def test_pictures() -> None:
    """Without -o, both commands write a mesh and a picture."""
    save_off(icosphere(2))
    answer = run("bracket", "ball.off", "--field", "rigid:x", "--field", "rigid:y", "--width", "120")
    assert "ball.bracket.png" in answer.stdout
    assert "ball.derive.png" in run("derive", "ball.off", "--field", "rigid:x", "--width", "120").stdout


def test_refusals() -> None:
    """Wrong fields are one sentence; a curl needs an orientable surface, a bracket does not."""
    save_off(icosphere(1))
    for count in (0, 1, 3):
        answer = run("bracket", "ball.off", *["--field", "rigid:x"] * count, "--no-png")
        assert answer.exit_code == 2
        assert "two fields" in answer.stderr
    assert run("derive", "ball.off").exit_code == 2
    assert run("bracket", "ball.off", "--field", "rigid:x", "--field", "up", "--no-png").exit_code == 2
    assert run("bracket", "ball.off", *["--field", "rigid:x"] * 2, "--no-png", "--commutator", "c.txt").exit_code != 0
    save_off(moebius_band(30, 3), "band.off")
    one_line(run("derive", "band.off", "--field", "rigid:x", "--no-png"), "orient")
    assert run("bracket", "band.off", "--field", "rigid:x", "--field", "rigid:z", "--no-png").exit_code == 0


def test_push_as_a_series() -> None:
    """A quarter turn: frames, table, report; functions and 1-forms, too."""
    mesh = icosphere(2)
    save_off(mesh)
    line = ["--by", "rigid:z", "--time", str(np.pi / 2), "--frames", "2", "-o", "s.pvd", "--no-png"]
    answer = run("push", "ball.off", "--field", "rigid:x", *line, "--csv", "s.csv", "--json")
    report = json.loads(answer.stdout)
    assert report["divergence_stays_zero"] is False
    last = read(sorted(Path().glob("s*.vtp"))[-1])
    np.testing.assert_allclose(last["pushed"], rigid_field(mesh, [0, 1, 0]), atol=0.08)
    assert len(Path("s.csv").read_text().splitlines()) == 4
    assert run("push", "ball.off", "--field", "rigid:x", "--as", "form", *line).exit_code == 0
    assert run("push", "ball.off", "--color", "x", *line).exit_code == 0
    last = read(sorted(Path().glob("s*.vtp"))[-1])
    np.testing.assert_allclose(last["color"], mesh.vertices[:, 1], atol=0.1)
    for wrong in (["--field", "rigid:x", "--color", "x"], [], ["--color", "x", "--as", "form"]):
        assert run("push", "ball.off", *wrong, *line).exit_code == 2


@needs_opengl
def test_film_of_a_pushed_field() -> None:
    """Without -o, a film and a contact sheet."""
    save_off(icosphere(1))
    answer = run("push", "ball.off", "--field", "random:1", "--by", "rigid:z", "--frames", "2", "--width", "120")
    assert "ball.push.gif" in answer.stdout


def test_push_says_that_a_field_grows() -> None:
    """Where the flow diverges, a pushed field grows without bound; parallel transport keeps its size."""
    ball = icosphere(2)
    save_off(ball)
    np.save("up.npy", np.array([0.0, 0, 1]) - ball.face_normals[:, 2:] * ball.face_normals)
    line = ["--field", "rigid:x", "--by", "up.npy", "--time", "8", "--frames", "2", "--no-png", "-o", "s.pvd"]
    assert "the energy grows" in run("push", "ball.off", *line).output
    assert "the energy grows" not in run("push", "ball.off", *line, "--as", "parallel").output
