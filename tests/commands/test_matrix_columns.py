"""``geodesic --to`` with ``--all-pairs`` and ``--sources``: a matrix of some columns only."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from support.matrix_runs import MESH, interrupt, stopping
from support.messages import missing
from support.program import run, save_off

COLUMNS = [150, 7, 7, 3]
TO = "--to 150,7,7 --to 3"


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh and a list of sources."""
    save_off(MESH, "mesh.off")
    Path("sources.txt").write_text("5\nface:3 8\n150\n")
    return folder


def written(options: str) -> np.ndarray:
    """The matrix that a run writes."""
    answer = run("geodesic", "mesh.off", *options.split(), "-o", "D.npy", "--json")
    assert answer.exit_code == 0, answer.output
    D: np.ndarray = np.load("D.npy")
    assert json.loads(answer.stdout)["shape"] == list(D.shape)
    return D


@pytest.mark.parametrize(
    "method", ["exact", "heat", "heat --refine", "exact --limit 0.3", "heat --single", "fast-marching"]
)
@pytest.mark.parametrize("rows", ["--all-pairs", "--sources sources.txt"])
def test_columns_of_the_whole_matrix(method: str, rows: str) -> None:
    """The columns are those of the matrix to all vertices, in the order of --to, repeated ones too."""
    whole = written(f"{rows} --method {method}")
    np.testing.assert_array_equal(written(f"{rows} --method {method} {TO}"), whole[:, COLUMNS])


def test_region() -> None:
    """A text file or an array selects rows and columns of one region: a symmetric matrix, zero on its diagonal."""
    inside = np.flatnonzero(MESH.vertices[:, 2] > 0.2)
    np.save("inside.npy", (MESH.vertices[:, 2] > 0.2).astype(float))
    np.savetxt("roi.txt", inside, fmt="%d")
    D = written("--method exact --sources roi.txt --to @roi.txt")
    assert D.shape == (len(inside), len(inside))
    assert not np.diag(D).any()
    np.testing.assert_allclose(D, D.T, atol=1e-12)
    np.testing.assert_array_equal(written("--method exact --sources roi.txt --to inside.npy=1"), D)


@pytest.mark.parametrize("method", ["exact", "heat"])
def test_outside_of_the_mask(method: str) -> None:
    """A vertex outside of the mask is at distance inf, as it is among all vertices, and as a single target."""
    faces = MESH.faces[np.isin(MESH.faces, [0]).any(axis=1)]
    np.savetxt("near.txt", np.unique(faces), fmt="%d")
    Path("sources.txt").write_text("0\n")
    far = int(MESH.vertices[:, 2].argmin())
    columns = [0, int(faces.max()), far]
    mask = f"--method {method} --mask @near.txt"
    whole = written(f"--sources sources.txt {mask}")
    assert np.isinf(whole[0, far])
    D = written(f"--sources sources.txt {mask} --to {','.join(map(str, columns))}")
    np.testing.assert_array_equal(D, whole[:, columns])
    Path("pairs.txt").write_text("".join(f"0 {v}\n" for v in columns))
    assert run(*f"geodesic mesh.off --pairs pairs.txt {mask} -o d.npy".split()).exit_code == 0
    np.testing.assert_array_equal(np.load("d.npy"), D[0])
    if method == "exact":
        answer = run(*f"geodesic mesh.off --source 0 --to {far} {mask} -o d.vtp --json".split())
        assert json.loads(answer.stdout)["targets"] == [{"vertex": far, "distance": None}]


def test_shards() -> None:
    """Merged shards are the bytes of one run; shards to other vertices are of another run."""
    common = f"geodesic mesh.off --method exact --all-pairs {TO}".split()
    assert run(*common, "-o", "D.npy").exit_code == 0
    for k in (1, 2):
        assert run(*common, "--shard", f"{k}/2", "-o", f"{k}.shard").exit_code == 0
    assert run("merge", "-o", "M.npy", "1.shard", "2.shard").exit_code == 0
    assert Path("M.npy").read_bytes() == Path("D.npy").read_bytes()
    assert run(*common, "--to", "9", "--shard", "2/2", "-o", "other.shard").exit_code == 0
    answer = run("merge", "-o", "N.npy", "1.shard", "other.shard")
    assert answer.exit_code
    assert not Path("N.npy").exists()


def test_a_run_to_other_vertices_does_not_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupted run resumes with the same columns, and starts anew with others."""
    common = f"geodesic mesh.off --all-pairs --time h2 {TO}".split()
    whole = run(*common, "-o", "W.npy")
    assert whole.exit_code == 0
    with monkeypatch.context() as patch:
        patch.setattr(HeatDistance, "rows", stopping(3, interrupt))
        assert run(*common, "-o", "D.npy").exit_code == 130
    answer = run(*common, "-o", "D.npy", "--json")
    assert json.loads(answer.stdout)["resumed_after"] > 0
    assert Path("D.npy").read_bytes() == Path("W.npy").read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(HeatDistance, "rows", stopping(3, interrupt))
        assert run(*common, "-o", "D.npy").exit_code == 130
    answer = run(*common, "--to", "9", "-o", "D.npy", "--json")
    assert answer.exit_code or json.loads(answer.stdout)["resumed_after"] == 0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--source 0 --to 3 -o d.vtp", "--method exact"),
        ("--pairs sources.txt --to 3 -o d.npy", "exclude each other"),
        ("--all-pairs --labels sources.txt --to 3 -o d.csv", "exclude each other"),
        ("--all-pairs --method exact --limit 1 --to 3 -o d.npz", "-o D.npy"),
        ("--all-pairs --to 99999 -o d.npy", "99999"),
        ("--all-pairs --to face:3 -o d.npy", "must be a vertex"),
    ],
)
def test_errors(options: str, words: str) -> None:
    """Options that exclude each other, and points that are no vertices."""
    answer = run("geodesic", "mesh.off", *options.split())
    assert answer.exit_code in (1, 2)
    assert not missing(answer.output, words)
