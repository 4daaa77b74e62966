"""``geodesic --all-pairs --labels``: tables of distances between labels."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.exact import ExactDistance
from geomhw.io.artifacts.tables import read_csv
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.matrix_runs import ALL, MESH, expected, interrupt, stopping
from support.meshes import two_spheres
from support.program import one_line, run, save_off

LABELS = np.random.default_rng(4).choice([-1, 2, 5, 2.5], MESH.n_vertices)
OF_FACES = np.random.default_rng(5).choice([0, 7], MESH.n_faces)
TABLE = ALL.replace("D.npy", "D.csv").split()


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh and labels."""
    save_off(MESH, "mesh.off")
    np.savez("labels.npz", part=LABELS, side=OF_FACES)
    return folder


def statistics(distances: np.ndarray, members: list[np.ndarray]) -> dict[str, list[float]]:
    """Return mean, min and max of the distances between all pairs of groups."""
    blocks = [distances[np.ix_(a, b)] for a in members for b in members]
    return {name: [getattr(block, name)() for block in blocks] for name in ("mean", "min", "max")}


@pytest.mark.parametrize("array", ["part", "side"])
@pytest.mark.parametrize("method", ["heat", "exact"])
def test_table(array: str, method: str) -> None:
    """A row holds the mean, least and largest distance between the vertices of two labels."""
    command = (
        TABLE if method == "heat" else [*[word for word in TABLE if word not in ("--time", "h2")], "--method=exact"]
    )
    answer = run(*command, "--labels", f"labels.npz:{array}", "--json")
    assert answer.exit_code == 0, answer.output
    distances = expected()
    if method == "exact":
        distances = np.array([ExactDistance(MESH).from_vertices([v])["distance"] for v in range(MESH.n_vertices)])
    labels = LABELS if array == "part" else OF_FACES
    values = np.unique(labels)
    members = [np.flatnonzero(labels == x) if array == "part" else np.unique(MESH.faces[labels == x]) for x in values]
    found = read_csv("D.csv")
    np.testing.assert_array_equal(found["source"], np.repeat(values, len(values)))
    np.testing.assert_array_equal(found["target"], np.tile(values, len(values)))
    for name, column in statistics(distances, members).items():
        np.testing.assert_allclose(found[name], column, rtol=1e-9, atol=1e-12)
    assert sorted(os.listdir()) == ["D.csv", "labels.npz", "mesh.off"]
    report = json.loads(answer.stdout)
    assert report["shape"] == [208, 3, len(values)]
    assert report["largest_distance"] == max(found["max"])


def test_statistics_in_order() -> None:
    """--table chooses the columns and their order; labels without a fraction are written as whole numbers."""
    assert run(*TABLE, "--labels", "labels.npz:part", "--table", "max,mean").exit_code == 0
    lines = Path("D.csv").read_text().splitlines()
    assert lines[0] == "source,target,max,mean"
    assert [line.split(",")[1] for line in lines[1:5]] == ["-1", "2", "2.5", "5"]


def test_resumed(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupted run resumes to the same bytes; another table or other labels are refused."""
    from geomhw.geodesic.heat_method import HeatDistance

    command = [*TABLE, "--labels", "labels.npz:part"]
    assert run(*command).exit_code == 0
    whole = Path("D.csv").read_bytes()
    Path("D.csv").unlink()
    with monkeypatch.context() as patched:
        patched.setattr(HeatDistance, "rows", stopping(3, interrupt))
        assert run(*command).exit_code == 130
    assert "another table" in run(*command, "--table", "min").stderr
    np.savez("labels.npz", part=LABELS + 1, side=OF_FACES)
    assert "another labels" in run(*command).stderr
    np.savez("labels.npz", part=LABELS, side=OF_FACES)
    assert json.loads(run(*command, "--json").stdout)["resumed_after"] > 0
    assert Path("D.csv").read_bytes() == whole
    assert sorted(os.listdir()) == ["D.csv", "labels.npz", "mesh.off"]


def test_components_and_masks() -> None:
    """Labels on different components are at infinite distance, or --beyond; vertices without faces have no label."""
    mesh = two_spheres()
    save_off(mesh, "two.off")
    labels = np.repeat([1.0, 9.0, 2.0], [162, 1, 162])
    np.save("two.npy", labels)
    command = ["geodesic", "two.off", "--method", "exact", "--all-pairs", "--labels", "two.npy", "-o", "D.csv"]
    assert run(*command, "--beyond", "-1").exit_code == 0
    found = read_csv("D.csv")
    np.testing.assert_array_equal(found["source"], [1, 1, 2, 2])
    np.testing.assert_array_equal(found["min"], [0, -1, -1, 0])
    kept = mesh.components[mesh.faces[:, 0]] == mesh.components[0]
    np.save("kept.npy", kept)
    np.save("faces.npy", np.arange(mesh.n_faces) % 3)
    assert run(*command[:-4], "--mask", "kept.npy", "--labels", "faces.npy", "-o", "D.csv").exit_code == 0
    first = Path("D.csv").read_bytes()
    save_off(TriangleMesh(mesh.vertices, mesh.faces[kept]), "two.off")
    np.save("faces.npy", (np.arange(mesh.n_faces) % 3)[kept])
    assert run(*command[:-4], "--labels", "faces.npy", "-o", "D.csv").exit_code == 0
    assert Path("D.csv").read_bytes() == first


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--labels", "labels.npz:part"], ["--labels", "--all-pairs"]),
        (["--all-pairs", "--table", "min"], ["--table", "--labels"]),
        (["--all-pairs", "--labels", "labels.npz:part", "--table", "median"], ["median", "mean", "min", "max"]),
        (["--all-pairs", "--labels", "labels.npz:part", "--table", "min,min"], ["min,min"]),
        (["--all-pairs", "--labels", "labels.npz:part", "--single", "-o", "D.csv"], ["--single"]),
        (["--all-pairs", "--labels", "labels.npz:part", "-o", "D.npy"], [".csv"]),
        (["--all-pairs", "--labels", "labels.npz:part", "--method=exact", "--limit=1", "-o", "D.npz"], [".csv"]),
    ],
)
def test_refused_options(options: list[str], words: list[str]) -> None:
    answer = run("geodesic", "mesh.off", *options)
    assert answer.exit_code != 0
    assert all(word in answer.stderr for word in words), answer.stderr


def test_refused_labels() -> None:
    np.save("colors.npy", np.zeros((MESH.n_vertices, 3)))
    one_line(run(*TABLE, "--labels", "colors.npy"), "colors.npy", "one number per vertex or face")
    one_line(run(*TABLE, "--labels", "none.npy"), "none.npy")
