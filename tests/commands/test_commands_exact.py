"""``geodesic --method exact``: output, limits, targets, matrices, pairs."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.exact import ExactDistance
from geomhw.io import read
from geomhw.io.artifacts.matrices import read_arrays
from geomhw.io.artifacts.tables import read_csv
from geomhw.mesh.named_points import face_point
from geomhw.mesh.primitives import torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.meshes import ZOO, crumpled, two_spheres, zoo_mesh
from support.messages import missing
from support.program import one_line, run, save_off

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


# -- masks and regions ------------------------------------------------------------------------------------------------

#: Faces of the mask: most of the mesh, in pieces.
KEPT = np.random.default_rng(2).random(MESH.n_faces) < 0.8


@pytest.mark.parametrize("method", [["--method", "exact"], ["--time", "h2"], ["--robust"]])
@pytest.mark.parametrize("source", ["5", "face:40", "40,face:7:0.2,0.3,0.5"])
def test_mask_is_mesh_cut_out(method: list[str], source: str) -> None:
    """Distances within a mask are those on the mesh cut out; the output has the whole mesh, zero in other faces."""
    kept = KEPT.copy()
    kept[[7, 40]] = True
    np.save("kept.npy", kept)
    cut = TriangleMesh(MESH.vertices, MESH.faces[kept])
    save_off(cut, "cut.off")
    number = np.cumsum(kept) - 1
    moved = source.replace("face:40", f"face:{number[40]}").replace("face:7", f"face:{number[7]}")
    answer = run("geodesic", "mesh.off", *method, "--mask", "kept.npy", "--source", source, "-o", "a.vtu", "--json")
    assert answer.exit_code == 0, answer.output
    other = run("geodesic", "cut.off", *method, "--source", moved, "-o", "b.vtu", "--json")
    found, expected = read("a.vtu"), read("b.vtu")
    np.testing.assert_array_equal(found["distance"], expected["distance"])
    assert found.mesh.n_faces == MESH.n_faces
    if "exact" not in method:
        np.testing.assert_array_equal(found["direction"][kept], expected["direction"])
        assert not found["direction"][~kept].any()
    reports = [json.loads(text.stdout) for text in (answer, other)]
    assert reports[0]["farthest"] == reports[1]["farthest"]
    assert [s["face"] for s in reports[0]["sources"] if isinstance(s, dict)] in ([], [40], [7])


@pytest.mark.parametrize("name", sorted(ZOO))
def test_random_masks(name: str) -> None:
    """Distances within random masks are those on the mesh cut out and renumbered; outside they are inf."""
    mesh, rng = zoo_mesh(name), np.random.default_rng(7)
    save_off(mesh, "zoo.off")
    for share in (0.5, 0.8, 0.95):
        kept = rng.random(mesh.n_faces) < share
        kept[0] = True
        np.save("kept.npy", kept)
        used = rng.permutation(np.unique(mesh.faces[kept]))
        places = np.full(mesh.n_vertices, -1)
        places[used] = np.arange(len(used))
        cut = TriangleMesh(mesh.vertices[used], rng.permutation(places[mesh.faces[kept]]))
        command = ["geodesic", "zoo.off", "--method", "exact", "--mask", "kept.npy", "-o", "out.vtu", "-q"]
        assert run(*command, "--source", str(used[0])).exit_code == 0
        found = read("out.vtu")["distance"]
        expected = ExactDistance(cut).from_vertices([0])["distance"]
        np.testing.assert_allclose(found[used], expected, rtol=1e-11, atol=1e-14)
        assert np.isinf(found[places < 0]).all()


def test_mask_of_vertices() -> None:
    """A mask of vertices contains the faces with all corners in it; it may be an array or a text file."""
    inside = from_vertex(5) < 1.5
    np.save("inside.npy", inside)
    Path("inside.txt").write_text("\n".join(map(str, np.flatnonzero(inside))))
    cut = TriangleMesh(MESH.vertices, MESH.faces[inside[MESH.faces].all(axis=1)])
    expected = ExactDistance(cut).from_vertices([5])["distance"]
    for mask in ("inside.npy", "@inside.txt"):
        assert run(*EXACT, "--mask", mask, "--source", "5", "-o", "out.vtu").exit_code == 0
        np.testing.assert_array_equal(read("out.vtu")["distance"], expected)


def test_mask_of_matrices() -> None:
    """Matrices and pairs within a mask are those of the mesh cut out."""
    np.save("kept.npy", KEPT)
    save_off(TriangleMesh(MESH.vertices, MESH.faces[KEPT]), "cut.off")
    for options in (["--all-pairs", "-o", "D.npy"], ["--all-pairs", "--limit", "1", "-o", "D.npz"]):
        assert run(*EXACT, "--mask", "kept.npy", *options).exit_code == 0
        first = Path(options[-1]).read_bytes()
        assert run("geodesic", "cut.off", "--method", "exact", *options).exit_code == 0
        assert Path(options[-1]).read_bytes() == first


@pytest.mark.parametrize("options", [["--source", "5"], ["--source", "face:0"], ["--all-pairs", "-o", "kept.npy"]])
def test_mask_refuses(options: list[str]) -> None:
    """Sources outside of the mask, and outputs over it, are refused."""
    kept = np.ones(MESH.n_faces, dtype=bool)
    kept[(MESH.faces == 5).any(axis=1)] = kept[0] = False
    np.save("kept.npy", kept)
    one_line(run(*EXACT, "--mask", "kept.npy", *options), "kept.npy" if "-o" in options else "outside of the mask")
    np.save("kept.npy", 0 * kept)
    one_line(run(*EXACT, "--mask", "kept.npy"), "kept.npy", "no face")
    one_line(run(*EXACT, "--mask", "none.npy"), "none.npy")


@pytest.mark.parametrize("method", ["exact", "heat"])
def test_region(method: str) -> None:
    """A region is 0 inside; outside, exact distances are from its edges, others from its vertices, as by a file."""
    labels = np.where(from_vertex(5) < 0.8, 3, 1)
    np.save("labels.npy", labels)
    vertices = np.flatnonzero(labels == 3)
    command = ["geodesic", "mesh.off", "--method", method, "-o", "out.vtu"]
    assert run(*command, "--source", "labels.npy=3").exit_code == 0
    found = read("out.vtu")["distance"]
    np.testing.assert_array_equal(np.flatnonzero(found == 0), vertices)
    Path("region.txt").write_text("\n".join(map(str, vertices)))
    assert run(*command, "--source", "@region.txt").exit_code == 0
    np.testing.assert_array_equal(read("out.vtu")["distance"], found)
    assert run(*command, "--source", ",".join(map(str, vertices))).exit_code == 0
    from_vertices = read("out.vtu")["distance"]
    assert (found <= from_vertices * (1 + 1e-12)).all()
    assert np.array_equal(found, from_vertices) == (method == "heat")


def test_region_of_faces_and_name() -> None:
    """Labels may belong to faces, have a name in their file, and stand beside other sources."""
    labels = np.zeros(MESH.n_faces)
    labels[[3, 4]] = 2.5
    np.savez("labels.npz", part=labels)
    assert run(*EXACT, "--source", "labels.npz:part=2.5", "--source", "100", "-o", "out.vtu").exit_code == 0
    sources = {*MESH.faces[[3, 4]].ravel().tolist(), 100}
    assert set(np.flatnonzero(read("out.vtu")["distance"] == 0)) == sources


@pytest.mark.parametrize(
    ("spec", "words"),
    [("labels.npy=7", ["labels.npy", "7"]), ("none.npy=1", ["none.npy"]), ("labels.npy=", ["NUMBER"])],
)
def test_region_refuses(spec: str, words: list[str]) -> None:
    np.save("labels.npy", np.zeros(MESH.n_vertices))
    answer = run(*EXACT, "--source", spec, "-o", "out.vtu")
    assert answer.exit_code != 0
    assert all(word in answer.stderr for word in words), answer.stderr
