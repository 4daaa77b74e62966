"""``path`` and ``trace``: outputs, reports and pictures."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic import ExactDistance
from geomhw.io import read, read_csv
from geomhw.io.reading import read_cloud
from geomhw.mesh.primitives import grid, torus
from support.meshes import crumpled, two_spheres
from support.messages import missing
from support.program import one_line, run, save_off

MESH = crumpled(torus(16, 13))


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh."""
    save_off(MESH, "mesh.off")
    return folder


def test_path() -> None:
    """Both files have the points of the path, and the report its length."""
    answer = run("path", "mesh.off", "--from", "3", "--to", "90,face:17", "-o", "p.vtp", "-o", "p.csv", "--json")
    assert answer.exit_code == 0
    first, second = json.loads(answer.stdout)["paths"]
    assert first["length"] == pytest.approx(ExactDistance(MESH).from_vertices([3])["distance"][90], rel=1e-12)
    assert (first["start"], first["end"], second["end"]["face"]) == (3, 90, 17)
    cloud, table = read_cloud("p.vtp"), read_csv("p.csv")
    assert list(table) == ["path", "x", "y", "z", "face", "b0", "b1", "b2", "arc_length"]
    np.testing.assert_array_equal(np.stack([table[name] for name in "xyz"], axis=1), cloud.points)
    np.testing.assert_array_equal(np.stack([table[f"b{k}"] for k in range(3)], axis=1), cloud["barycentric"])
    np.testing.assert_array_equal(table["path"], cloud["path"])
    ends = np.append(np.flatnonzero(np.diff(table["path"])), -1)
    assert table["arc_length"][ends].tolist() == [first["length"], second["length"]] == cloud["length"].tolist()


def test_polylines_as_vtk_reads_them() -> None:
    """VTK finds one polyline per path."""
    pyvista = pytest.importorskip("pyvista")
    assert run("path", "mesh.off", "--from", "3", "--to", "90,17", "-o", "p.vtp").exit_code == 0
    found = pyvista.read("p.vtp")
    assert (found.n_lines, found.n_cells) == (2, 2)
    length = found.compute_cell_sizes(area=False, volume=False)["Length"]
    np.testing.assert_allclose(length, found.field_data["length"], rtol=1e-12)


def test_default_names() -> None:
    """Without -o, polylines and a picture."""
    assert run("path", "mesh.off", "--from", "3", "--to", "90").exit_code == 0
    assert Path("mesh.path.vtp").exists()
    assert Path("mesh.path.png").exists()


def test_way_points_loops_and_pairs() -> None:
    """Legs of a path through points are paths of pairs; a loop has one more."""
    Path("pairs.txt").write_text("3 50\n50 90\n90 3\n")

    def lengths(*options: str) -> list[float]:
        answer = run("path", "mesh.off", *options, "--json", "-o", "p.csv")
        assert answer.exit_code == 0, answer.output
        return [item["length"] for item in json.loads(answer.stdout)["paths"]]

    legs = lengths("--pairs", "pairs.txt")
    assert lengths("--from", "3", "--via", "50", "--to", "90") == pytest.approx([sum(legs[:2])])
    assert lengths("--from", "3", "--via", "50", "--via", "90", "--loop") == pytest.approx([sum(legs)])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--from", "1", "--to", "170"], ["no path", "170", "component"]),
        (["--from", "1", "--via", "170", "--to", "3"], ["no path", "170", "component"]),
    ],
)
def test_no_path(options: list[str], words: list[str]) -> None:
    """Components are not connected, one sentence."""
    save_off(two_spheres(), "two.off")
    one_line(run("path", "two.off", *options, "-o", "p.vtp"), *words)
    assert not Path("p.vtp").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--from", "1"], ["--to"]),
        (["--from", "1", "--loop"], ["--via"]),
        (["--from", "1", "--to", "2", "--pairs", "mesh.off"], ["--pairs"]),
        (["--from", "1,2", "--via", "4", "--to", "3"], ["one point"]),
        (["--from", "1", "--to", "9999"], ["9999"]),
        (["--from", "1", "--to", "2", "-o", "p.obj"], [".obj"]),
    ],
)
def test_wrong_usage(options: list[str], words: list[str]) -> None:
    """Options that do not fit are refused with exit code 2."""
    answer = run("path", "mesh.off", *options)
    assert answer.exit_code == 2
    for word in words:
        assert not missing(answer.stderr, word)


def test_face_of_zero_area() -> None:
    """A point inside a face of zero area is refused."""
    Path("flat.off").write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n2 0 0\n0 1 0\n3 0 1 2\n3 0 1 3\n")
    one_line(run("path", "flat.off", "--from", "face:0", "--to", "3", "-o", "p.vtp"), "face 0", "zero area")


def test_trace() -> None:
    """A line has the requested length; a fan has a line for each angle, the first as without --fan."""
    answer = run("trace", "mesh.off", "--from", "3", "--angle", "40", "--length", "2", "-o", "l.csv", "--json")
    (line,) = json.loads(answer.stdout)["lines"]
    assert (line["start"], line["length"], line["stop"]) == (3, pytest.approx(2, rel=1e-12), None)
    one = read_csv("l.csv")
    fan = ["--fan", "12", "-o", "fan.csv", "--png", "fan.png", "--json"]
    answer = run("trace", "mesh.off", "--from", "3", "--angle", "40", "--length", "2", *fan)
    assert len(json.loads(answer.stdout)["lines"]) == 12
    many = read_csv("fan.csv")
    for name, values in one.items():
        np.testing.assert_array_equal(many[name][many["path"] == 0], values)


def test_lines_end_at_the_boundary() -> None:
    """The report says how many lines end before their length, and how many have no direction on the surface."""
    save_off(grid(4, 4), "grid.off")
    answer = run("trace", "grid.off", "--from", "0", "--length", "9", "--fan", "8", "-o", "l.vtp")
    assert answer.exit_code == 0
    assert "3 lines end before the length, at a boundary" in answer.stdout
    assert "5 directions off the surface" in answer.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--angle", "30", "--vector", "1", "0", "0"], ["--vector", "--angle"]),
        (["--vector", "0", "0", "1"], ["normal"]),
        (["--vector", "-1", "0.5", "0"], ["off the surface"]),
        (["--angle", "200"], ["off the surface"]),
        (["--length", "-1"], ["--length"]),
    ],
)
def test_wrong_directions(options: list[str], words: list[str]) -> None:
    """Directions that are impossible are refused with exit code 2."""
    save_off(grid(4, 4), "grid.off")
    answer = run("trace", "grid.off", "--from", "0", "--length", "1", *options, "-o", "l.vtp")
    assert answer.exit_code == 2
    for word in words:
        assert not missing(answer.stderr, word)


def test_logmap() -> None:
    """Arrays, report and a note where the radius is beyond the surface."""
    answer = run("logmap", "mesh.off", "--source", "3", "--radius", "99", "-o", "l.vtu", "--png", "l.png", "--json")
    assert answer.exit_code == 0
    report, result = json.loads(answer.stdout), read("l.vtu")
    assert {field.name for field in result.fields} == {"radius", "angle", "log"}
    np.testing.assert_allclose(result["radius"], ExactDistance(MESH).from_vertices([3])["distance"], rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(result["log"], axis=1), result["radius"], rtol=1e-12)
    assert report["vertices"] == MESH.n_vertices
    assert "no vertex of the surface is beyond" in report["remarks"][0]


def test_logmap_needs_one_source() -> None:
    """Several sources are refused with exit code 2."""
    answer = run("logmap", "mesh.off", "--source", "3,4", "-o", "l.vtu")
    assert answer.exit_code == 2
    assert not missing(answer.stderr, "one source")


def test_straighten() -> None:
    """Curves of all kinds of files; a loop that bounds a disk is reported as a point."""
    save_off(torus(24, 12), "torus.off")
    answer = run(
        "path", "torus.off", "--from", "0", "--via", "8", "--via", "16", "--loop", "-o", "c.vtp", "-o", "c.csv"
    )
    assert answer.exit_code == 0
    Path("c.txt").write_text("0,8,16,0\n")

    def loops(name: str, *options: str) -> list[dict]:
        answer = run("path", "torus.off", "--straighten", name, *options, "-o", "g.vtp", "--json")
        assert answer.exit_code == 0, answer.output
        return json.loads(answer.stdout)["paths"]

    expected = pytest.approx(48 * 0.6 * np.sin(np.pi / 24), rel=1e-12)
    for name in ("c.vtp", "c.csv", "c.txt"):
        (found,) = loops(name)
        assert (found["length"], found["loop"], found["contractible"]) == (expected, True, False)
    Path("c.txt").write_text("0,30,27\n")
    assert loops("c.txt")[0]["loop"] is False
    assert loops("c.txt", "--loop")[0]["contractible"] is True
    (table,) = ["x,y\n0,1\n"]
    Path("bad.csv").write_text(table)
    one_line(run("path", "torus.off", "--straighten", "bad.csv", "-o", "g.vtp"), "bad.csv", "b0")


def test_ties() -> None:
    """The report says which paths have others as short."""
    save_off(torus(24, 12), "torus.off")
    answer = run("path", "torus.off", "--from", "0", "--to", "12,29", "-o", "p.vtp", "--json")
    assert [item["tied"] for item in json.loads(answer.stdout)["paths"]] == [True, False]
    assert "1 path of several" in json.loads(answer.stdout)["remarks"][0]
