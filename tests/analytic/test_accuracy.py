"""The reported errors of distances against straight lines on flat meshes."""

import json
import subprocess
import sys

import numpy as np
import pytest

from geomhw.geodesic import HeatDistance, accuracy, distance_errors
from geomhw.mesh import TriangleMesh, grid, vertex_points
from support.program import run, save_off


def shaken(slope: float) -> TriangleMesh:
    """A flat square of 17 x 17 vertices, sheared."""
    square = grid(16, 16)
    return TriangleMesh(square.vertices @ [[1, 0, 0], [slope, 1, 0], [0, 0, 1]], square.faces)


@pytest.mark.parametrize("slope", [0.0, 0.7, 4.0])
@pytest.mark.parametrize("most", [50_000, 60])
def test_errors_are_those_to_straight_lines(slope: float, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Mean, largest error and its vertex are right, on all vertices or on those nearest to the source."""
    monkeypatch.setattr(accuracy, "MOST_VERTICES", most)
    mesh, source = shaken(slope), 40
    distance = np.asarray(HeatDistance(mesh, "h2").from_vertices([source])["distance"])
    found = distance_errors(mesh, vertex_points(mesh, [source]), distance)
    straight = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    compared = (straight > 0) & (straight <= found.get("within", np.inf))
    errors = np.where(compared, np.abs(distance / np.maximum(straight, 1e-300) - 1), 0.0)
    assert found["vertices"] == np.count_nonzero(compared)
    assert found["vertices"] < mesh.n_vertices / 2 or most > mesh.n_vertices
    np.testing.assert_allclose(found["mean"], errors[compared].mean(), rtol=1e-9)
    np.testing.assert_allclose(found["largest"], errors.max(), rtol=1e-9)
    assert errors[found["vertex"]] == pytest.approx(errors.max(), rel=1e-9)


def test_isolated_source() -> None:
    """There is nothing to compare where no vertex but the source is reached."""
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]], [[0, 1, 2]])
    assert distance_errors(mesh, vertex_points(mesh, [0]), np.array([0, np.inf, np.inf, np.inf])) == {}


@pytest.mark.usefixtures("folder")
def test_the_report_warns_from_five_percent_on() -> None:
    """Beyond 5 % on average or 10 % at a vertex, a warning names ``--refine``; refined distances are exact."""
    save_off(shaken(4.0), "m.off")
    save_off(grid(3, 3), "square.off")
    answer = run("geodesic", "m.off", "--no-png")
    report = json.loads(run("geodesic", "m.off", "--no-png", "--json").stdout)["accuracy"]
    assert report["mean"] > 0.05
    assert f"warning   distances are {report['mean']:.2%} off" in answer.stdout
    assert "--refine" in answer.stdout
    assert "accuracy  exact" in run("geodesic", "m.off", "--no-png", "--refine").stdout


@pytest.mark.usefixtures("folder")
def test_quiet_runs_compare_nothing() -> None:
    """With ``-q`` there is no report, and no compiled loop is loaded."""
    save_off(grid(3, 3), "m.off")
    code = "import sys; from geomhw_cli.program import run; c = run(); assert 'numba' not in sys.modules; sys.exit(c)"
    arguments = ["geodesic", "m.off", "--time", "h2", "-o", "r.vtp", "-q"]
    answer = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
