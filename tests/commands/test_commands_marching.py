"""``geodesic --method fast-marching``: files, reports, matrices and shards, and the options that it takes."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic import ExactDistance, FastMarchingDistance
from geomhw.io import read, read_arrays
from support.meshes import zoo_mesh
from support.messages import missing
from support.program import run, save_off

MESH = zoo_mesh("crumpled_torus")
MARCH = ["geodesic", "mesh.off", "--method", "fast-marching"]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh."""
    save_off(MESH, "mesh.off")
    return folder


def test_report_and_files() -> None:
    """The distances of the library are written; the report gives their errors against exact ones, except with -q."""
    answer = run(*MARCH, "--source", "3", "-o", "d.vtp", "--json")
    assert answer.exit_code == 0, answer.output
    expected = np.asarray(FastMarchingDistance(MESH).from_vertices([3])["distance"])
    np.testing.assert_array_equal(read("d.vtp")["distance"], expected)
    exact = np.asarray(ExactDistance(MESH).from_vertices([3])["distance"])
    others = exact > 0
    report = json.loads(answer.stdout)
    assert report["method"] == "fast-marching"
    found = report["accuracy"]
    assert (found["exact"], found["vertices"]) == (False, others.sum())
    np.testing.assert_allclose(found["mean"], abs(expected[others] / exact[others] - 1).mean(), rtol=1e-9)
    assert "accuracy" in run(*MARCH, "--source", "3", "-o", "d.vtp").stdout
    assert run(*MARCH, "--source", "3", "-o", "d.vtp", "-q").stdout == ""


def test_limit_and_target() -> None:
    """``--limit`` and ``--to`` cut; errors are those of the vertices within."""
    whole = np.asarray(FastMarchingDistance(MESH).from_vertices([3])["distance"])
    answer = run(*MARCH, "--source", "3", "--limit", "1", "--beyond", "-1", "-o", "d.vtp", "--json")
    np.testing.assert_array_equal(read("d.vtp")["distance"], np.where(whole <= 1, whole, -1))
    report = json.loads(answer.stdout)
    assert (report["limit"], report["vertices_beyond"]) == (1, (whole > 1).sum())
    assert report["accuracy"]["vertices"] == (whole <= 1).sum() - 1
    answer = run(*MARCH, "--source", "3", "--to", "40", "-o", "d.vtp", "--json")
    assert json.loads(answer.stdout)["targets"] == [{"vertex": 40, "distance": whole[40]}]


def test_matrices() -> None:
    """A dense matrix has the rows of single sources; a sparse one is that of the library, in shards too."""
    assert run(*MARCH, "--all-pairs", "-o", "D.npy", "-q").exit_code == 0
    D = np.load("D.npy")
    for v in (0, 77):
        np.testing.assert_array_equal(D[v], FastMarchingDistance(MESH).from_vertices([v])["distance"])
    assert run(*MARCH, "--all-pairs", "--limit", "1", "-o", "D.npz", "-q").exit_code == 0
    sparse = read_arrays("D.npz")["values"].toarray()
    np.testing.assert_array_equal(sparse, FastMarchingDistance(MESH).matrix(1.0).toarray())
    for k in (1, 2):
        assert run(*MARCH, "--all-pairs", "--limit", "1", "--shard", f"{k}/2", "-o", f"{k}.shard").exit_code == 0
    assert run("merge", "-o", "M.npz", "1.shard", "2.shard").exit_code == 0
    assert Path("M.npz").read_bytes() == Path("D.npz").read_bytes()
    exact = ["geodesic", "mesh.off", "--method", "exact", "--all-pairs", "--limit", "1", "--shard", "2/2"]
    assert run(*exact, "-o", "exact.shard").exit_code == 0
    answer = run("merge", "-o", "N.npz", "1.shard", "exact.shard")
    assert answer.exit_code == 1, answer.output


def test_inaccurate_distances_are_warned_of() -> None:
    """Where single distances are far off, the report warns and names the exact method."""
    vertices = MESH.vertices * [1, 1, 1e-2] + 0.02 * np.random.default_rng(0).normal(size=MESH.vertices.shape)
    save_off(type(MESH)(vertices, MESH.faces), "rough.off")
    lines = [
        run("geodesic", "rough.off", *MARCH[2:], "--source", f"{v}", "-o", "d.vtp").stdout for v in range(0, 240, 12)
    ]
    warned = [text for text in lines if "warning" in text]
    assert warned
    assert not missing(warned[0], "off on average ... --method exact computes them exactly")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--robust"], "--robust ... --method heat"),
        (["--time", "h2"], "--time ... --method heat"),
        (["--panel", "heat"], "--method fast-marching ... --panel distance"),
        (["--all-pairs", "-o", "D.npz"], ".npy"),
    ],
)
def test_refused_options(options: list[str], words: str) -> None:
    """Options of the heat method are refused."""
    answer = run(*MARCH, *options)
    assert answer.exit_code == 2
    assert not missing(answer.stderr, words)
