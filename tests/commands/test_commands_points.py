"""``center``, ``voronoi`` and ``sample``: outputs, reports and pictures."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic import farthest_points, voronoi_cells
from geomhw.io import read, read_csv
from geomhw.io.reading import read_cloud
from geomhw.mesh import torus, vertex_points
from support.meshes import crumpled, two_spheres
from support.messages import missing
from support.program import one_line, run, save_off

MESH = crumpled(torus(16, 13))


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with meshes."""
    save_off(MESH, "mesh.off")
    save_off(two_spheres(), "two.off")
    return folder


def test_sample() -> None:
    """Both files have the points, and the report their spacing."""
    answer = run("sample", "mesh.off", "--count", "9", "-o", "p.vtp", "-o", "p.csv", "--png", "p.png", "--json")
    assert answer.exit_code == 0
    report, expected = json.loads(answer.stdout), farthest_points(MESH, 9)
    assert report["points"] == expected.points.vertices.tolist()
    assert report["spacing"] == pytest.approx(expected.spacing)
    cloud, table = read_cloud("p.vtp"), read_csv("p.csv")
    assert list(table) == ["vertex", "x", "y", "z", "face", "b0", "b1", "b2", "gap"]
    np.testing.assert_array_equal(table["vertex"], report["points"])
    np.testing.assert_array_equal(np.stack([table[f"b{k}"] for k in range(3)], axis=1), cloud["barycentric"])
    corners = MESH.vertices[MESH.faces[table["face"].astype(int)]]
    np.testing.assert_allclose(np.einsum("kc,kcx->kx", cloud["barycentric"], corners), cloud.points, atol=1e-12)
    assert Path("p.png").exists()


def test_poisson_sample() -> None:
    """Equal seeds give equal files; points lie within faces."""
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        options = ["--spacing", "0.6", "--method", "poisson", "--seed", seed, "-o", f"{name}.csv"]
        assert run("sample", "mesh.off", *options).exit_code == 0
    first, second, third = (Path(f"{name}.csv").read_bytes() for name in "abc")
    assert first == second != third
    assert read_csv("a.csv")["gap"][1:].min() >= 0.6
    assert read_csv("a.csv")["vertex"].min() == -1


def test_voronoi() -> None:
    """Arrays, sites and report are those of the library."""
    given = ["--sites", "3,40,99", "-o", "v.vtu", "--points", "s.csv", "--png", "v.png", "--json"]
    answer = run("voronoi", "mesh.off", *given)
    assert answer.exit_code == 0
    report, result, cells = (
        json.loads(answer.stdout),
        read("v.vtu"),
        voronoi_cells(MESH, vertex_points(MESH, [3, 40, 99])),
    )
    np.testing.assert_array_equal(result["label"], cells.label)
    np.testing.assert_allclose(result["distance"], cells.distance, rtol=1e-12)
    np.testing.assert_allclose(report["areas"], cells.areas, rtol=1e-12)
    assert report["dual_edges"] == [[0, 1], [0, 2], [1, 2]]
    assert report["files"] == ["v.vtu", "s.csv", "v.png"]
    np.testing.assert_allclose(read_csv("s.csv")["area"], cells.areas, rtol=1e-12)


def test_number_of_sites() -> None:
    """A single number is a number of sites; relaxation reduces squared distances."""

    def energy(*options: str) -> float:
        answer = run("voronoi", "mesh.off", "--sites", "6", *options, "--no-png", "-o", "v.vtk", "--json")
        assert answer.exit_code == 0, answer.output
        assert len(json.loads(answer.stdout)["areas"]) == 6
        return float(MESH.vertex_areas @ np.asarray(read("v.vtk")["distance"]) ** 2)

    assert energy("--relax", "5") < 0.9 * energy()


def test_components_without_a_site() -> None:
    """They have the label -1, and the report says so."""
    answer = run("voronoi", "two.off", "--sites", "0,5", "-o", "v.vtk")
    assert answer.exit_code == 0
    assert "162 vertices on components without a site: label -1" in answer.stdout
    assert (np.asarray(read("v.vtk")["label"]) == -1).sum() == 163  # with one vertex of no face


def test_center() -> None:
    """Points as text, as list and as table give the same center."""
    Path("points.txt").write_text("3\n40\n99\n")
    Path("points.csv").write_text(
        "x,y,z\n" + "".join(",".join(map(repr, p)) + "\n" for p in MESH.vertices[[3, 40, 99]].tolist())
    )
    centers = []
    for text in ("3,40,99", "points.txt", "points.csv"):
        answer = run("center", "mesh.off", "--points", text, "-o", "c.csv", "--png", "c.png", "--json")
        assert answer.exit_code == 0, answer.output
        centers.append(json.loads(answer.stdout)["position"])
        assert np.stack([read_csv("c.csv")[name] for name in "xyz"], axis=1)[0].tolist() == centers[-1]
    np.testing.assert_allclose(centers[1:], [centers[0]] * 2, atol=1e-9)
    answer = run("center", "mesh.off", "--points", "3,40,99", "--median", "-o", "c.vtp", "--json")
    assert json.loads(answer.stdout)["sum"] == pytest.approx(sum(json.loads(answer.stdout)["distances"]))


def test_several_centers() -> None:
    """The report says that the mean is not unique, and the file has all."""
    save_off(torus(24, 12), "torus.off")
    answer = run("center", "torus.off", "--points", "near:1.4,0,0", "--points", "near:-1.4,0,0", "-o", "c.csv")
    assert answer.exit_code == 0
    assert "not unique" in answer.stdout
    assert len(read_csv("c.csv")["x"]) > 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sample"], ["--count", "--spacing"]),
        (["sample", "--count", "0"], ["--count"]),
        (["sample", "--count", "9999"], ["208 distinct vertices"]),
        (["voronoi"], ["--sites"]),
        (["voronoi", "--sites", "0"], ["number of sites"]),
        (["voronoi", "--sites", "9999,1"], ["9999"]),
        (["voronoi", "--sites", "3", "--points", "p.obj", "-o", "v.vtk"], [".obj"]),
        (["center"], ["--points"]),
        (["center", "--points", "9999"], ["9999"]),
        (["center", "--points", "3", "-o", "p.obj"], [".obj"]),
    ],
)
def test_wrong_usage(arguments: list[str], words: list[str]) -> None:
    """Options that do not fit are refused with exit code 2."""
    answer = run(arguments[0], "mesh.off", *arguments[1:])
    assert answer.exit_code == 2
    for word in words:
        assert not missing(answer.stderr, word)


def test_center_of_components() -> None:
    """No path between the points, one sentence."""
    one_line(run("center", "two.off", "--points", "0,170", "-o", "c.vtp"), "no path", "component")


def test_one_file_for_two_outputs() -> None:
    """The sites and the cells are different files."""
    one_line(run("voronoi", "mesh.off", "--sites", "3", "--points", "v.vtp", "-o", "v.vtp"), "v.vtp")
    assert not Path("v.vtp").exists()
