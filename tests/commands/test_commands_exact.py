"""``geodesic --method exact``: output, limits, targets, matrices, pairs."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.exact import ExactDistance
from geomhw.io import read
from geomhw.io.artifacts.matrices import read_arrays
from geomhw.io.artifacts.tables import read_csv
from geomhw.mesh.primitives import torus
from geomhw.mesh.surface_points import face_point
from support.meshes import crumpled, two_spheres
from support.messages import missing
from support.program import run, save_off

MESH = crumpled(torus(16, 13))
EXACT = ["geodesic", "mesh.off", "--method", "exact"]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh."""
    save_off(MESH, "mesh.off")
    return folder


def from_vertex(source: int) -> np.ndarray:
    return np.asarray(ExactDistance(MESH).from_vertices([source])["distance"])


def test_exact() -> None:
    """The output has the array of distances only, and the report says how they were computed."""
    answer = run(*EXACT, "--source", "5", "-o", "out.vtu", "--json")
    assert answer.exit_code == 0
    result = read("out.vtu")
    assert [(field.name, field.location) for field in result.fields] == [("distance", "vertex")]
    np.testing.assert_array_equal(result["distance"], from_vertex(5))
    report = json.loads(answer.stdout)
    assert report["method"] == "exact"
    assert report["farthest"] == {"vertex": int(from_vertex(5).argmax()), "distance": from_vertex(5).max()}
    assert report["unreachable_vertices"] == 0
    assert {"read", "connectivity", "compute", "write"} == report["seconds"].keys()


def test_picture() -> None:
    """By default the picture has one panel, the distance."""
    assert run(*EXACT, "--source", "5,face:3").exit_code == 0
    assert Path("mesh.geodesic.vtk").exists()
    assert Path("mesh.geodesic.png").exists()


def test_limit_and_beyond() -> None:
    """Distances beyond the limit are inf, or the value of --beyond."""
    expected = from_vertex(5)
    limit = float(expected.max() / 3)
    answer = run(*EXACT, "--source", "5", "--limit", repr(limit), "-o", "out.vtu")
    np.testing.assert_array_equal(read("out.vtu")["distance"], np.where(expected <= limit, expected, np.inf))
    assert f"{np.count_nonzero(expected > limit)} vertices" in answer.stdout
    assert run(*EXACT, "--source", "5", "--limit", repr(limit), "--beyond", "-1", "-o", "out.vtu").exit_code == 0
    np.testing.assert_array_equal(read("out.vtu")["distance"], np.where(expected <= limit, expected, -1))


def test_beyond_of_heat_method() -> None:
    """--beyond replaces the distances on components without a source, in files of any method."""
    save_off(two_spheres(), "two.off")
    for method in ("heat", "exact"):
        answer = run("geodesic", "two.off", "--source", "0", "--method", method, "--beyond", "-1", "-o", "out.vtu")
        assert "-1" in answer.stdout
        distance = read("out.vtu")["distance"]
        assert (distance[162:] == -1).all()
        assert (distance[:162] >= 0).all()


def test_targets() -> None:
    """Targets have their distances, in the file and in the report; farther vertices are inf."""
    expected = from_vertex(5)
    near = np.argsort(expected)[[3, 10]].tolist()
    answer = run(*EXACT, "--source", "5", "--to", f"{near[0]}", "--to", f"{near[1]}", "-o", "out.vtu", "--json")
    found = read("out.vtu")["distance"]
    np.testing.assert_array_equal(found[near], expected[near])
    assert np.count_nonzero(np.isinf(found)) > len(found) / 2
    assert json.loads(answer.stdout)["targets"] == [{"vertex": v, "distance": expected[v]} for v in near]


def test_sparse_matrix() -> None:
    """--all-pairs with a limit writes a symmetric sparse matrix of the distances within it."""
    expected = np.array([from_vertex(v) for v in range(MESH.n_vertices)])
    limit = float(expected.max() / 3)
    answer = run(*EXACT, "--all-pairs", "--limit", repr(limit), "-o", "D.npz", "--json")
    assert answer.exit_code == 0, answer.output
    (found,) = read_arrays("D.npz").values()
    np.testing.assert_allclose(found.toarray(), np.where(expected <= limit, expected, 0), rtol=1e-12)
    assert json.loads(answer.stdout)["stored"] == found.nnz == np.count_nonzero(expected <= limit)
    first = Path("D.npz").read_bytes()
    assert run(*EXACT, "--all-pairs", "--limit", repr(limit), "-o", "D.npz").exit_code == 0
    assert Path("D.npz").read_bytes() == first


def test_dense_matrix() -> None:
    """--all-pairs writes a dense matrix, with a limit and a value beyond it on request."""
    expected = np.array([from_vertex(v) for v in range(MESH.n_vertices)])
    assert run(*EXACT, "--all-pairs", "-o", "D.npy").exit_code == 0
    np.testing.assert_array_equal(np.load("D.npy"), expected)
    limit = float(expected.max() / 3)
    answer = run(*EXACT, "--all-pairs", "--limit", repr(limit), "--beyond", "-1", "-o", "D.npy")
    assert "beyond the limit" in answer.stdout
    np.testing.assert_allclose(np.load("D.npy"), np.where(expected <= limit, expected, -1), rtol=1e-14)


def test_pairs_and_sets() -> None:
    """--pairs and --sources give exact distances, also from points in faces."""
    Path("pairs.txt").write_text("5 17\n3,4\nface:2 9\n5 5\n")
    assert run(*EXACT, "--pairs", "pairs.txt", "-o", "D.csv").exit_code == 0
    inside = ExactDistance(MESH).from_sources(face_point(MESH, 2))["distance"]
    expected = [from_vertex(5)[17], from_vertex(3)[4], inside[9], 0.0]
    np.testing.assert_allclose(read_csv("D.csv")["distance"], expected, rtol=1e-15)
    Path("sets.txt").write_text("5 17\n3\n")
    assert run(*EXACT, "--sources", "sets.txt", "-o", "D.npy").exit_code == 0
    D = np.load("D.npy")
    np.testing.assert_allclose(D, [np.minimum(from_vertex(5), from_vertex(17)), from_vertex(3)], rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--method", "exact", "--robust"], ["--robust", "--method heat"]),
        (["--method", "exact", "--time", "h2"], ["--time", "--method heat"]),
        (["--method", "exact", "--no-refine"], ["--refine", "--method heat"]),
        (["--method", "exact", "--panel", "heat"], ["--panel distance"]),
        (["--method", "exact", "--limit", "-1"], ["--limit"]),
        (["--method", "fast"], ["heat", "exact"]),
        (["--limit", "3"], ["--limit", "--method exact"]),
        (["--to", "3"], ["--to", "--method exact"]),
        (["--method", "exact", "--to", "3", "--all-pairs"], ["--to", "--all-pairs"]),
        (["--all-pairs", "--method", "exact", "-o", "D.npz"], [".npy"]),
    ],
)
def test_refused_options(options: list[str], words: list[str]) -> None:
    answer = run("geodesic", "mesh.off", *options)
    assert answer.exit_code != 0
    assert all(word in answer.stderr for word in words), answer.stderr
    assert not Path("mesh.geodesic.vtk").exists()


def test_target_in_face() -> None:
    for target, word in (("face:3", "target"), ("999", "999")):
        answer = run(*EXACT, "--to", target, "-o", "out.vtu")
        assert answer.exit_code == 2
        assert not missing(answer.stderr, f"{word} ... vertex")
