"""Curves as sources of ``geodesic``, ``voronoi``, ``vecdiffuse`` and ``isolines --between``."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read
from geomhw.mesh import TriangleMesh, grid
from support.program import run, save_off

SQUARE = grid(10, 10)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a square, a line across faces, and labels."""
    save_off(SQUARE, "square.off")
    Path("line.csv").write_text("x,y,z\n0.13,0.27,0\n0.81,0.27,0\n")
    np.save("half.npy", (SQUARE.face_centers[:, 0] > 0.5).astype(int))
    roof = TriangleMesh(SQUARE.vertices + np.abs(SQUARE.vertices[:, :1] - 0.5) * [0, 0, -2], SQUARE.faces)
    save_off(roof, "roof.off")
    return folder


def distances(*arguments: str) -> np.ndarray:
    """Run ``geodesic`` and return its distances."""
    answer = run("geodesic", *arguments, "-o", "d.vtp", "--no-png", "-q")
    assert answer.exit_code == 0, answer.output
    return np.asarray(read("d.vtp")["distance"])


@pytest.mark.parametrize("options", [["--method", "exact"], ["--refine"], ["--robust"]])
def test_exact_methods(options: list[str]) -> None:
    """All exact methods give the distance in the plane."""
    x, y = SQUARE.vertices[:, :2].T
    expected = np.hypot(np.maximum(np.maximum(0.13 - x, x - 0.81), 0), y - 0.27)
    np.testing.assert_allclose(distances("square.off", "--source", "curve:line.csv", *options), expected, atol=1e-12)


def test_named_curves() -> None:
    """The boundary, feature edges and borders of labels are sources along their edges."""
    x, y = SQUARE.vertices[:, :2].T
    exact = ["--method", "exact"]
    rim = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    np.testing.assert_allclose(distances("square.off", "--source", "curve:boundary", *exact), rim, atol=1e-12)
    ridge = np.sqrt(5) * np.abs(x - 0.5)
    np.testing.assert_allclose(distances("roof.off", "--source", "edges:angle>40", *exact), ridge, atol=1e-9)
    found = distances("square.off", "--source", "border:half.npy", *exact)
    np.testing.assert_allclose(found, np.abs(x - 0.5), atol=1e-12)


def test_report_and_picture() -> None:
    """A curve is one entry of the report; the picture is drawn."""
    answer = run("geodesic", "square.off", "--source", "curve:line.csv", "--source", "7", "-o", "d.vtp", "--json")
    report = json.loads(answer.stdout)
    assert report["sources"] == [7, {"curve": 15}]
    assert report["accuracy"]["mean"] < 0.2
    assert (
        "curve of"
        in run("geodesic", "square.off", "--source", "curve:line.csv", "-o", "d.vtp", "--png", "d.png").output
    )


def test_cells_and_vectors() -> None:
    """A curve is one site; vectors keep their angle with a curve; levels lie between curves."""
    answer = run("voronoi", "square.off", "--sites", "curve:line.csv", "--sites", "115", "-o", "v.vtp", "--json")
    report = json.loads(answer.stdout)
    assert len(report["areas"]) == 2
    assert sum(report["areas"]) == pytest.approx(1, rel=1e-12)
    assert run("voronoi", "square.off", "--sites", "curve:line.csv", "--relax", "2", "-o", "v.vtp").exit_code == 2
    assert run("vecdiffuse", "square.off", "--source", "curve:line.csv", "--angle", "90", "-o", "w.vtp").exit_code == 0
    np.testing.assert_allclose(read("w.vtp")["transported"], np.tile([0, 1, 0], (SQUARE.n_vertices, 1)), atol=1e-9)
    answer = run(
        "isolines", "square.off", "--between", "curve:line.csv", "curve:boundary", "--count", "3", "-o", "i.vtp"
    )
    assert answer.exit_code == 0, answer.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["path", "square.off", "--from", "curve:line.csv", "--to", "5"], ["line.csv", "is a curve", "points"]),
        (["geodesic", "square.off", "--source", "curve:none.csv"], ["none.csv"]),
        (["geodesic", "square.off", "--source", "curve:half.npy"], ["half.npy", ".vtp .obj .csv"]),
        (["geodesic", "square.off", "--source", "edges:angle>40"], ["no two faces", "40"]),
        (["geodesic", "square.off", "--source", "curve:far.csv"], ["far.csv", "from the surface"]),
        (["geodesic", "square.off", "--source", "curve:line.csv", "--mask", "half.npy"], ["outside of the mask"]),
        (["vecdiffuse", "square.off", "--source", "curve:line.csv", "--source", "3"], ["points or curves"]),
    ],
)
def test_refusals(arguments: list[str], words: list[str]) -> None:
    """One sentence."""
    Path("far.csv").write_text("x,y,z\n0,0,9\n1,0,9\n")
    answer = run(*arguments, "-o", "o.vtp")
    assert answer.exit_code in (1, 2)
    message = answer.stderr.splitlines()[-1]
    assert [word for word in words if word not in message] == [], message
