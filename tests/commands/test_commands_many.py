"""``geodesic --all-pairs``, ``--pairs``, ``--sources``: output, interruption and resumption, memory."""

import json
import os
import signal
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic import ExactDistance
from geomhw.geodesic.heat_method import BLOCK, HeatDistance
from geomhw.io.artifacts.tables import read_csv
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.matrix_runs import ALL, MESH, expected, interrupt, stopping
from support.meshes import two_spheres
from support.messages import missing
from support.program import run, save_off


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh, pairs and sources."""
    save_off(MESH, "mesh.off")
    return folder


def test_all_pairs(folder: Path) -> None:
    """Row i holds the distances from vertex i; the report describes the run; no other file is left."""
    answer = run(*ALL.split(), "--json")
    assert answer.exit_code == 0, answer.output
    assert answer.stderr == ""
    D = np.load("D.npy")
    assert D.dtype == np.float64
    np.testing.assert_allclose(D, expected(), rtol=0, atol=1e-12 * D.max())
    assert sorted(os.listdir()) == ["D.npy", "mesh.off"]
    report = json.loads(answer.stdout)
    assert (report["question"], report["queries"], report["shape"]) == ("all-pairs", 208, [208, 208])
    assert report["largest_distance"] == D.max()
    assert report["seconds"].keys() == {"read", "set up", "compute", "write"}
    assert {"time", "refined", "boundary", "solver"} <= report.keys()
    assert "largest" in run(*ALL.split()).stdout


@pytest.mark.parametrize("options", [[], ["--robust"], ["--refine"], ["--solver", "multigrid"], ["--solver", "direct"]])
def test_solvers_and_options(options: list[str]) -> None:
    """Each option gives the row of a single source with that option; solvers agree to 1e-6 of the largest distance."""
    assert run(*ALL.split(), *options).exit_code == 0
    D = np.load("D.npy")
    answer = run("geodesic", "mesh.off", "--time", "h2", "--source", "100", *options, "-o", "one.vtp", "--json")
    assert answer.exit_code == 0
    farthest = json.loads(answer.stdout)["farthest"]
    np.testing.assert_allclose(D[100, farthest["vertex"]], farthest["distance"], rtol=1e-9)
    if "--solver" in options:
        np.testing.assert_allclose(D, expected(), rtol=0, atol=1e-6 * D.max())


def test_single_precision() -> None:
    """``--single`` writes the same matrix rounded to single precision."""
    run(*ALL.split())
    run(*ALL.replace("D.npy", "S.npy").split(), "--single")
    S = np.load("S.npy")
    assert S.dtype == np.float32
    np.testing.assert_array_equal(S, np.load("D.npy").astype(np.float32))


def test_vertices_without_faces() -> None:
    """Vertices without faces have distance 0 to themselves only; components are at distance inf."""
    mesh = two_spheres()
    save_off(mesh, "two.off")
    answer = run("geodesic", "two.off", "--all-pairs", "-o", "D.npy", "-q")
    assert (answer.exit_code, answer.output) == (0, "")
    D = np.load("D.npy")
    np.testing.assert_array_equal(np.isfinite(D), mesh.components[:, None] == mesh.components)
    assert not np.diag(D).any()


def test_sources_of_a_file() -> None:
    """Each line of a file is a set of sources in the syntax of ``--source``, and gives one row."""
    Path("sources.txt").write_text("0\n# nothing\n5 6-9\nface:17:0.2,0.3,0.5, 3\n\n max-y \n")
    assert run("geodesic", "mesh.off", "--time", "h2", "--sources", "sources.txt", "-o", "S.npy").exit_code == 0
    S = np.load("S.npy")
    for row, specs in zip(S, (["0"], ["5", "6-9"], ["face:17:0.2,0.3,0.5", "3"], ["max-y"]), strict=True):
        words = [word for spec in specs for word in ("--source", spec)]
        answer = run("geodesic", "mesh.off", "--time", "h2", *words, "-o", "one.vtp", "--json")
        assert row.max() == pytest.approx(json.loads(answer.stdout)["farthest"]["distance"], rel=1e-9)


PAIRS = "0 17\n5,3\n0 100   # again from 0\nface:17 5\n3 5\n5\t3\n"


@pytest.mark.parametrize("name", ["P.npy", "P.csv"])
def test_pairs(name: str) -> None:
    """``--pairs`` writes one distance per line, in order, and solves once per source."""
    Path("pairs.txt").write_text(PAIRS)
    answer = run("geodesic", "mesh.off", "--time", "h2", "--pairs", "pairs.txt", "-o", name, "--json")
    assert answer.exit_code == 0, answer.output
    assert json.loads(answer.stdout)["queries"] == 4
    solver = HeatDistance(MESH, "h2")
    wanted = [
        solver.from_sources(face_point(MESH, a) if b < 0 else vertex_points(MESH, [a]))["distance"][abs(b)]
        for a, b in ((0, 17), (5, 3), (0, 100), (17, -5), (3, 5), (5, 3))
    ]
    found = np.load(name) if name == "P.npy" else np.asarray(read_csv(name)["distance"])
    np.testing.assert_allclose(found, wanted, rtol=1e-11)
    assert sorted(os.listdir()) == [name, "mesh.off", "pairs.txt"]


@pytest.mark.parametrize("command", [ALL, "geodesic mesh.off --pairs pairs.txt -o D.csv", f"{ALL} --single --refine"])
def test_a_run_goes_on(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupted run keeps its rows; rerunning the same command ends in the same bytes."""
    Path("pairs.txt").write_text("\n".join(f"{v} {(7 * v) % 208}" for v in range(208)))
    before = set(os.listdir())
    assert run(*command.split()).exit_code == 0
    (name,) = set(os.listdir()) - before
    whole = Path(name).read_bytes()
    Path(name).write_text("old")
    with monkeypatch.context() as patched:
        patched.setattr(HeatDistance, "rows", stopping(3, interrupt))
        answer = run(*command.split())
    assert answer.exit_code == 130
    (line,) = answer.stderr.splitlines()
    assert not missing(line, f"Error: interrupted ... {2 * BLOCK} of 208 ... D.partial.npy ... same command")
    assert Path(name).read_text() == "old"
    assert set(os.listdir()) - before == {name, "D.partial.npy", "D.partial.json"}
    answer = run(*command.split(), "--json")
    assert json.loads(answer.stdout)["resumed_after"] == 2 * BLOCK
    assert Path(name).read_bytes() == whole
    assert set(os.listdir()) - before == {name}


def test_interrupted_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run interrupted before its first rows leaves no file."""
    from click import Abort

    from geomhw_cli.main import program

    monkeypatch.setattr(HeatDistance, "rows", stopping(1, interrupt))
    with pytest.raises((KeyboardInterrupt, Abort)):
        program.main(ALL.split(), standalone_mode=False)
    assert os.listdir() == ["mesh.off"]


KILLED = """
import os, signal, sys
import geomhw.io.artifacts.resumable_file as partial
partial.INTERVAL = -1.0
from support.matrix_runs import stopping
from geomhw.geodesic.heat_method import HeatDistance
HeatDistance.rows = stopping(4, lambda: os.kill(os.getpid(), signal.SIGKILL))
from geomhw_cli.main import main
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
def test_killed(folder: Path) -> None:
    """After ``kill -9`` the saved rows are kept, and the resumed run ends in the same bytes."""
    run(*ALL.split())
    whole = Path("D.npy").read_bytes()
    Path("D.npy").unlink()
    path = os.pathsep.join(filter(None, sys.path))
    killed = subprocess.run([sys.executable, "-c", KILLED, *ALL.split()], env=os.environ | {"PYTHONPATH": path})
    assert killed.returncode == -signal.SIGKILL
    assert sorted(os.listdir()) == ["D.partial.json", "D.partial.npy", "mesh.off"]
    answer = run(*ALL.split(), "--json")
    assert json.loads(answer.stdout)["resumed_after"] == 3 * BLOCK
    assert Path("D.npy").read_bytes() == whole


def test_memory_does_not_grow_with_the_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four times as many rows take at most 5 % more memory."""
    from geomhw_cli.specs.queries import DistanceQueries, ResolvedQueries

    save_off(icosphere(4), "large.off")
    peaks = []
    for count in (640, 640, 2560):  # the first for all that is imported
        monkeypatch.setattr(DistanceQueries, "resolve", lambda self, mesh, count=count: ResolvedQueries(count))
        tracemalloc.start()
        try:
            assert run("geodesic", "large.off", "--all-pairs", "-o", "D.npy").exit_code == 0
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    assert np.load("D.npy").shape == (2560, 2562)
    assert peaks[2] < 1.05 * peaks[1]


def test_pairs_with_commas() -> None:
    """Words with commas are quoted in the table of ``--pairs``."""
    Path("pairs.txt").write_text("face:17:0.2,0.3,0.5 5\n3 7\n")
    assert run("geodesic", "mesh.off", "--pairs", "pairs.txt", "-o", "P.csv", "-q").exit_code == 0
    table = read_csv("P.csv")
    assert table["source"].tolist() == ["face:17:0.2,0.3,0.5", "3"]
    assert table["target"].tolist() == [5, 7]
    assert Path("P.csv").read_text().startswith('source,target,distance\n"face:17:0.2,0.3,0.5",5,')


def test_accuracy_is_that_of_several_sources() -> None:
    """The errors in the report are those of a few sets of sources spread over all, not of the first alone."""
    fine, coarse = icosphere(3), icosphere(1)
    faces = np.concatenate([fine.faces, coarse.faces + fine.n_vertices])
    mesh = TriangleMesh(np.concatenate([fine.vertices, coarse.vertices + 5]), faces)
    save_off(mesh, "two.off")
    sources = [0, 0, 5, fine.n_vertices]
    Path("sources.txt").write_text("".join(f"{v}\n" for v in sources))
    answer = run("geodesic", "two.off", "--sources", "sources.txt", "--json", "-o", "D.npy")
    assert answer.exit_code == 0, answer.output
    accuracy = json.loads(answer.stdout)["accuracy"]
    exact = ExactDistance(mesh).rows([vertex_points(mesh, [v]) for v in sources])
    compared = np.isfinite(exact) & (exact > 0)
    errors = np.where(compared, np.abs(np.load("D.npy") / np.where(compared, exact, 1) - 1), 0)
    assert accuracy["sets"] == 4
    assert accuracy["largest"] == pytest.approx(errors.max())
    assert accuracy["mean"] == pytest.approx(errors[compared].mean())
    assert accuracy["of_sources"] == [sources[int(errors.max(axis=1).argmax())]]
    assert errors[0].max() < errors.max()
