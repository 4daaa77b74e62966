"""``streamlines``: outputs, report and usage; ``--draw`` of commands that draw vectors."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read_csv, write
from geomhw.io.reading import read_cloud
from geomhw.mesh.primitives import grid, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result
from support.meshes import book
from support.pictures import needs_opengl
from support.program import one_line, run, save_off

MESH = torus(24, 12)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh."""
    save_off(MESH, "mesh.off")
    return folder


def test_files_and_report() -> None:
    """Both files have the points; the report has the spacing, and each streamline with its ends."""
    command = ("streamlines", "mesh.off", "--field", "random:3", "--spacing", "0.4", "--json")
    answer = run(*command, "-o", "s.vtp", "-o", "s.csv")
    assert answer.exit_code == 0
    report, cloud, table = json.loads(answer.stdout), read_cloud("s.vtp"), read_csv("s.csv")
    assert list(table)[-4:] == ["time", "speed", "along_edge", "stop"]
    assert list(table)[:9] == ["path", "x", "y", "z", "face", "b0", "b1", "b2", "arc_length"]
    np.testing.assert_array_equal(np.stack([table[name] for name in "xyz"], axis=1), cloud.points)
    assert report["spacing"] == 0.4
    assert report["streamlines"] == len(report["lines"]) == len(cloud["length"])
    assert report["neighbor_distance"]["share_from_half_to_twice"] > 0.95
    assert [line["length"] for line in report["lines"]] == cloud["length"].tolist()
    ends = [line[name] for line in report["lines"] for name in ("begin", "end")]
    assert ends.count("closed") == 2 * report["closed"] == 2 * int(np.sum(cloud["closed"]))
    assert {name: ends.count(name) for name in report["ends"]} == report["ends"]
    last = np.append(np.flatnonzero(np.diff(table["path"])), -1)
    assert ((table["stop"] > 0).sum(), (table["stop"][last] > 0).all()) == (2 * report["streamlines"], True)


def test_number_of_streamlines() -> None:
    """A whole number is a number of streamlines side by side on a square of the area of the mesh."""
    save_off(grid(9, 9), "sheet.off")
    answer = run("streamlines", "sheet.off", "--field", "rigid:z", "--spacing", "8", "--json", "-o", "s.vtp")
    assert json.loads(answer.stdout)["spacing"] == pytest.approx(1 / 8)


def test_field_without_streamlines() -> None:
    """A field that is zero has none."""
    write(Result(MESH, [Field("still", "face", np.zeros((MESH.n_faces, 3)))]), "still.vtp")
    one_line(run("streamlines", "mesh.off", "--field", "still.vtp:still", "-o", "s.vtp"), "zero", "spacing")
    assert not Path("s.vtp").exists()


@pytest.mark.parametrize("spacing", ["0", "-1", "nan", "inf", "many", "3000", "0.0"])
def test_wrong_spacing(spacing: str) -> None:
    """A wrong spacing is a wrong value of the command line."""
    answer = run("streamlines", "mesh.off", "--field", "rigid:z", "--spacing", spacing, "-o", "s.vtp")
    assert answer.exit_code == 2
    assert "spacing" in answer.stderr
    assert not Path("s.vtp").exists()


def test_edges_of_three_faces() -> None:
    """A mesh with edges of more than two faces has no streamlines."""
    save_off(book(), "book.off")
    one_line(run("streamlines", "book.off", "--field", "rigid:z", "-o", "s.vtp"), "manifold")


@needs_opengl
def test_drawing_styles() -> None:
    """Arrows are the default; the other styles give other pictures, and pages with curves for streamlines."""
    pictures = {}
    for style in ("arrows", "streamlines", "lic"):
        draw = ["--draw", style] if style != "arrows" else []
        command = ["vecdiffuse", "mesh.off", "--source", "0", *draw, "--width", "120", "-o", "v.vtp", "--png", "v.png"]
        assert run(*command, "--html", "v.html", "-q").exit_code == 0
        pictures[style] = pixels("v.png")
        assert ("streamlines of transported" in Path("v.html").read_text()) == (style == "streamlines")
    assert (pictures["streamlines"] != pictures["arrows"]).any()
    assert pictures["lic"].std() > pictures["arrows"].std()


@needs_opengl
def test_films_and_meshes_without_streamlines() -> None:
    """Contact sheets have the style, too; a mesh that has no streamlines is an error after the data are written."""
    series = ["--dt", "0.01", "--steps", "2", "--every", "1", "--width", "120", "-o", "a.pvd", "--png", "a.png"]
    assert run("advect", "mesh.off", *series, "--draw", "streamlines").exit_code == 0
    ball = icosphere(2)
    a, b = ball.edges[0]
    fin = np.append(ball.vertices, ball.vertices[[a]] + ball.vertices[[b]], axis=0)
    save_off(TriangleMesh(fin, np.append(ball.faces, [[a, b, len(ball.vertices)]], axis=0)), "fin.off")
    answer = run("vecdiffuse", "fin.off", "--source", "5", "--draw", "lic", "-o", "b.vtp", "--png", "b.png", "-q")
    one_line(answer, "manifold", "b.vtp")
    assert Path("b.vtp").exists()


def pixels(name: str) -> np.ndarray:
    """Return the pixels of a picture."""
    from PIL import Image

    return np.asarray(Image.open(name)).astype(int)
