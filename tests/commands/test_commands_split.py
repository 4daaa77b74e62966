"""``split``: files, pieces, curves of files and of names, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read, write, write_csv
from geomhw.mesh import TriangleMesh, grid, icosphere
from geomhw.results import Field, Result
from support.meshes import two_spheres
from support.program import one_line, run, save_off

BALL = icosphere(3)
CORNERS = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
CUBE = TriangleMesh(CORNERS, [half for a, b, c, d in SIDES for half in ([a, b, c], [a, c, d])])


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a sphere, and its height."""
    fields = [Field("height", "vertex", BALL.vertices[:, 2].copy()), Field("index", "face", np.arange(BALL.n_faces))]
    write(Result(BALL, fields), "ball.vtp")
    save_off(BALL)
    return folder


def test_along_a_level() -> None:
    """Two halves in one file and in one each, with the arrays, and a report whose numbers add up."""
    Path("parts").mkdir()
    options = ["--along", "ball.vtp:height=0.25", "--pieces", "parts", "-o", "halves.vtp", "--json"]
    answer = run("split", "ball.vtp", *options)
    assert answer.exit_code == 0, answer.output
    report = json.loads(answer.stdout)
    whole, parts = read("halves.vtp"), [read(f"parts/ball.{k}.vtp") for k in range(2)]
    assert report["files"] == ["halves.vtp", "parts/ball.0.vtp", "parts/ball.1.vtp"]
    assert report["piece_count"] == 2
    for k, part in enumerate(parts):
        item = report["pieces"][k]
        assert part.mesh.face_areas.sum() == pytest.approx(item["area"], rel=1e-12)
        assert (part.mesh.n_faces, part.mesh.euler_characteristic) == (item["faces"], item["euler_characteristic"])
        assert set(part["piece"].tolist()) == {k}
        side = np.asarray(part["height"]) - 0.25
        assert side.min() == 0 or side.max() == 0
    np.testing.assert_array_equal(whole["index"], whole["parent"])
    assert whole.mesh.euler_characteristic == 2 == report["euler_characteristic"]["pieces"]


def test_pieces_by_pattern() -> None:
    """The number comes before the extension."""
    assert run("split", "ball.off", "--along", "ball.vtp:height=0", "--pieces", "p.ply", "-o", "h.vtk").exit_code == 0
    assert sorted(path.name for path in Path().glob("p.*")) == ["p.0.ply", "p.1.ply"]


@pytest.mark.parametrize("kind", [".csv", ".obj", ".vtp"])
def test_curves_of_files(kind: str) -> None:
    """Polylines of tables, OBJ lines and isolines divide the sphere in the same way."""
    assert (
        run("isolines", "ball.vtp:height", "--level", "0.5", "--level", "-0.3", "-o", "i.vtp", "-o", "i.csv").exit_code
        == 0
    )
    table = np.genfromtxt("i.csv", delimiter=",", names=True)
    places = np.stack([table[name] for name in "xyz"], axis=1)
    if kind == ".obj":
        lines = [f"v {' '.join(map(repr, place))}" for place in places.tolist()]
        lines += [f"l {i + 1} {i + 2}" for i in np.flatnonzero(np.diff(table["path"]) == 0)]
        Path("i.obj").write_text("\n".join(lines) + "\n")
    if kind == ".csv":
        rows = [
            dict(zip("xyz", place, strict=True)) | {"id": int(k)}
            for place, k in zip(places, table["path"], strict=True)
        ]
        write_csv("i.csv", rows)
    answer = run("split", "ball.off", "--curve", f"i{kind}", "-o", "p.vtp", "--json")
    assert answer.exit_code == 0, answer.output
    report = json.loads(answer.stdout)
    assert report["piece_count"] == 3
    assert report["cut"]["length"] == pytest.approx(2 * np.pi * (np.sqrt(0.75) + np.sqrt(0.91)), rel=0.01)
    assert sorted(item["euler_characteristic"] for item in report["pieces"]) == [0, 1, 1]


def test_named_curves() -> None:
    """Feature edges part a cube into six sides; borders of labels part faces of different labels."""
    save_off(CUBE, "cube.off")
    answer = run("split", "cube.off", "--curve", "edges:angle>40", "-o", "p.vtp", "--json")
    assert json.loads(answer.stdout)["piece_count"] == 6
    np.save("labels.npy", np.arange(12) // 4)
    answer = run("split", "cube.off", "--curve", "border:labels.npy", "-o", "p.vtp", "--json")
    report = json.loads(answer.stdout)
    assert [item["area"] for item in report["pieces"]] == pytest.approx([1] * 6)  # of three labels, on opposite sides
    save_off(grid(3, 3), "square.off")
    assert "separates nothing" in run("split", "square.off", "--curve", "boundary", "-o", "p.vtp").output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["--along or --curve"]),
        (["--along", "ball.vtp:height=9"], ["height", "no isoline at 9", "from -1 to 1"]),
        (["--along", "ball.vtp:height=x"], ["no level", "FILE:ARRAY=NUMBER"]),
        (["--along", "ball.vtp:index=3"], ["index", "one number per vertex"]),
        (["--curve", "boundary"], ["no boundary"]),
        (["--curve", "edges:angle>170"], ["no two faces", "170"]),
        (["--curve", "edges:sharp"], ["names no edges", "angle>"]),
        (["--curve", "far.csv"], ["far.csv", "from the surface"]),
        (["--curve", "point.csv"], ["point.csv", "one point"]),
        (["--curve", "none.csv"], ["none.csv"]),
        (["--curve", "ball.vtp"], ["ball.vtp", "no polyline"]),
        (["--curve", "ball.off"], ["ball.off", ".vtp .obj .csv"]),
        (["--along", "ball.vtp:height=0", "--pieces", "p.stl"], ["p.0.stl", "not a format"]),
    ],
)
def test_refusals(arguments: list[str], words: list[str]) -> None:
    """One sentence, and no file."""
    Path("far.csv").write_text("x,y,z\n5,0,0\n6,0,0\n")
    Path("point.csv").write_text("x,y,z\n1,0,0\n1,0,0\n")
    answer = run("split", "ball.off", *arguments, "-o", "o.vtp")
    assert answer.exit_code in (1, 2)
    message = answer.stderr.splitlines()[-1]
    assert [word for word in words if word not in message] == [], message
    assert not Path("o.vtp").exists()


def test_curve_on_two_components() -> None:
    """A segment between components is refused."""
    save_off(two_spheres(), "balls.off")
    Path("c.csv").write_text("x,y,z\n1,0,0\n3.5,0,0\n")
    one_line(run("split", "balls.off", "--curve", "c.csv", "-o", "o.vtp"), "different components")
