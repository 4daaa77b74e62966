"""``geodesic --all-pairs``, ``--pairs``, ``--sources``: what is written, how a run goes on, what is refused."""

import json
import os
import signal
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import crumpled, two_spheres
from test_commands import run, save_off
from test_faults import files_no_larger_than

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.many_sources import block_size
from geomhw.io import read_csv
from geomhw.mesh.primitives import grid, icosphere, torus
from geomhw.mesh.surface_points import face_point, vertex_points

MESH = crumpled(torus(16, 13))  # 208 vertices, four blocks
ALL = "geodesic mesh.off --time h2 --all-pairs -o D.npy"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in a folder of its own, with a mesh, pairs and sources."""
    monkeypatch.chdir(tmp_path)
    save_off(MESH, "mesh.off")
    return tmp_path


def expected(**options: Any) -> np.ndarray:
    """All distances, one source after the other."""
    solver = HeatDistance(MESH, "h2", **options)
    return np.stack([solver.from_vertices([v])["distance"] for v in range(MESH.n_vertices)])


def test_all_pairs(folder: Path) -> None:
    """Row i is the distance from vertex i; the report says how; nothing else is left."""
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
    assert {"time", "refined", "boundary", "solver", "factorization"} <= report.keys()
    assert "largest" in run(*ALL.split()).stdout


@pytest.mark.parametrize("options", [[], ["--robust"], ["--refine"], ["--solver", "multigrid"], ["--solver", "direct"]])
def test_solvers_and_options(options: list[str]) -> None:
    """As the same options have it for one source; all solvers to 1e-6 of the largest distance."""
    assert run(*ALL.split(), *options).exit_code == 0
    D = np.load("D.npy")
    answer = run("geodesic", "mesh.off", "--time", "h2", "--source", "100", *options, "-o", "one.vtp", "--json")
    assert answer.exit_code == 0
    farthest = json.loads(answer.stdout)["farthest"]
    np.testing.assert_allclose(D[100, farthest["vertex"]], farthest["distance"], rtol=1e-9)
    if "--solver" in options:
        np.testing.assert_allclose(D, expected(), rtol=0, atol=1e-6 * D.max())


def test_single_precision() -> None:
    """Half the size; the same to single precision."""
    run(*ALL.split())
    run(*ALL.replace("D.npy", "S.npy").split(), "--single")
    S = np.load("S.npy")
    assert S.dtype == np.float32
    np.testing.assert_array_equal(S, np.load("D.npy").astype(np.float32))


def test_vertices_without_faces() -> None:
    """They reach themselves, and nothing else does; components do not reach each other."""
    mesh = two_spheres()
    save_off(mesh, "two.off")
    answer = run("geodesic", "two.off", "--all-pairs", "-o", "D.npy", "-q")
    assert (answer.exit_code, answer.output) == (0, "")
    D = np.load("D.npy")
    np.testing.assert_array_equal(np.isfinite(D), mesh.components[:, None] == mesh.components)
    assert not np.diag(D).any()


def test_sources_of_a_file() -> None:
    """A line is a set of sources, in the syntax of --source; a row its distances."""
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
    """A distance a line, in their order; each source is solved for once."""
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


# -- interrupted runs -------------------------------------------------------------------------------------------------


def stopping(at: int, stop: Callable[[], object]) -> Callable[..., Any]:
    """`HeatDistance.rows` that comes to an end at one of its calls."""
    rows, calls = HeatDistance.rows, []

    def stopped(self: HeatDistance, queries: Any) -> Any:
        calls.append(1)
        if len(calls) == at:
            stop()
        return rows(self, queries)

    return stopped


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("command", [ALL, "geodesic mesh.off --pairs pairs.txt -o D.csv", f"{ALL} --single --refine"])
def test_a_run_goes_on(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is done is kept under a name that says so, and the same command ends with the same bytes."""
    Path("pairs.txt").write_text("\n".join(f"{v} {(7 * v) % 208}" for v in range(208)))
    before = set(os.listdir())
    assert run(*command.split()).exit_code == 0
    (name,) = set(os.listdir()) - before
    whole = Path(name).read_bytes()
    Path(name).write_text("old")
    with monkeypatch.context() as patched:
        patched.setattr(HeatDistance, "rows", stopping(3, interrupt))
        answer = run(*command.split())
    assert answer.exit_code == 1
    kept = "Error: interrupted; 128 of 208 sources are kept in D.partial.npy, and the same command goes on from there\n"
    assert answer.stderr == kept
    assert Path(name).read_text() == "old"
    assert set(os.listdir()) - before == {name, "D.partial.npy", "D.partial.json"}
    answer = run(*command.split(), "--json")
    assert json.loads(answer.stdout)["resumed_after"] == 128
    assert Path(name).read_bytes() == whole
    assert set(os.listdir()) - before == {name}


def test_interrupted_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing done, nothing left."""
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
from test_commands_many import stopping
from geomhw.geodesic.heat_method import HeatDistance
HeatDistance.rows = stopping(4, lambda: os.kill(os.getpid(), signal.SIGKILL))
from geomhw_cli.main import main
main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
def test_killed(folder: Path) -> None:
    """kill -9 leaves what was written down last; the run goes on from there to the same bytes."""
    run(*ALL.split())
    whole = Path("D.npy").read_bytes()
    Path("D.npy").unlink()
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    killed = subprocess.run([sys.executable, "-c", KILLED, *ALL.split()], env=os.environ | {"PYTHONPATH": path})
    assert killed.returncode == -signal.SIGKILL
    assert sorted(os.listdir()) == ["D.partial.json", "D.partial.npy", "mesh.off"]
    answer = run(*ALL.split(), "--json")
    assert json.loads(answer.stdout)["resumed_after"] == 192
    assert Path("D.npy").read_bytes() == whole


def test_another_run_is_not_gone_on_with(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other options, another mesh, or a state that is damaged, are refused in a sentence, and nothing is lost."""
    with monkeypatch.context() as patched:
        patched.setattr(HeatDistance, "rows", stopping(3, interrupt))
        run(*ALL.split())
    kept = Path("D.partial.npy").read_bytes()
    save_off(grid(5, 5), "other.off")
    for change, word in (
        (("--time h2", "--time 2*h2"), "time"),
        (("--all-pairs", "--all-pairs --robust"), "robust"),
        (("--all-pairs", "--all-pairs --single"), "precision"),
        (("mesh.off", "other.off"), "mesh"),
    ):
        answer = run(*ALL.replace(*change).split())
        assert answer.exit_code == 1
        assert answer.stderr == (
            f"Error: D.partial.json is of a run with another {word}; "
            "remove D.partial.json and D.partial.npy to start anew, or take another name\n"
        )
    assert Path("D.partial.npy").read_bytes() == kept
    Path("D.partial.npy").write_bytes(kept[:5000])
    assert "is shorter than D.partial.json says" in run(*ALL.split()).stderr
    Path("D.partial.json").write_text("{}")
    assert "is not the state of a run" in run(*ALL.split()).stderr
    Path("D.partial.npy").unlink()
    assert run(*ALL.split()).exit_code == 0
    assert sorted(os.listdir()) == ["D.npy", "mesh.off", "other.off"]


# -- disks and memory -------------------------------------------------------------------------------------------------


def test_no_room_beforehand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Found out before anything is computed."""
    from shutil import disk_usage

    monkeypatch.setattr("shutil.disk_usage", lambda path: disk_usage(path)._replace(free=300_000))
    monkeypatch.setattr(HeatDistance, "rows", None)
    answer = run(*ALL.split())
    assert answer.exit_code == 1
    sentence = "it takes 0.346 MB, and there is room for 0.300 MB; make room, or write to another disk\n"
    assert answer.stderr == f"Error: cannot write D.npy: {sentence}"
    assert os.listdir() == ["mesh.off"]


def test_no_room_in_the_middle() -> None:
    """A disk that fills up is one sentence; what fits is kept, and the run goes on when there is room."""
    Path("D.npy").write_text("old")
    with files_no_larger_than(200_000):
        answer = run(*ALL.split())
    assert answer.exit_code == 1
    assert answer.stderr.startswith("Error: cannot write D.partial.npy: File too large; raise the limit")
    assert Path("D.npy").read_text() == "old"
    answer = run(*ALL.split(), "--json")
    assert answer.exit_code == 0, answer.stderr
    assert json.loads(answer.stdout)["resumed_after"] == block_size(MESH.n_vertices)
    np.testing.assert_allclose(np.load("D.npy"), expected(), rtol=0, atol=1e-11)


def test_memory_does_not_grow_with_the_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four times as many rows of a matrix, of 2,562 numbers each, in a twentieth more memory at most."""
    from geomhw_cli.specs.queries import Asked, DistanceQueries

    save_off(icosphere(4), "large.off")
    peaks = []
    for count in (640, 640, 2560):  # the first for all that is imported
        monkeypatch.setattr(DistanceQueries, "on", lambda self, mesh, count=count: Asked(count))
        tracemalloc.start()
        try:
            assert run("geodesic", "large.off", "--all-pairs", "-o", "D.npy").exit_code == 0
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    assert np.load("D.npy").shape == (2560, 2562)
    assert peaks[2] < 1.05 * peaks[1]


# -- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        ("--all-pairs", 2, "--all-pairs writes one file; give -o D.npy."),
        ("--all-pairs -o a.npy -o b.npy", 2, "--all-pairs writes one file"),
        ("--all-pairs --pairs mesh.off -o a.npy", 2, "--all-pairs and --pairs exclude each other."),
        ("--all-pairs --source 3 -o a.npy", 2, "--source and --all-pairs exclude each other."),
        ("--all-pairs --png a.png -o a.npy", 2, "--png and --all-pairs exclude each other."),
        ("--single -o a.vtp", 2, "--single is for --all-pairs, --pairs and --sources."),
        ("--all-pairs -o a.csv", 1, "cannot write a.csv: '.csv' is not a format that is written here; known are .npy"),
        ("--all-pairs -o no/a.npy", 1, "cannot write no/a.npy: there is no folder no"),
        ("--sources bad.npy -o bad.npy", 1, "bad.npy, line 1: 'x' is no source"),
        ("--sources empty -o a.npy", 1, "empty is an empty file"),
        ("--sources far -o a.npy", 1, "far, line 2: source 208 is not a vertex: the mesh has 208 (0 to 207)"),
        ("--pairs three -o a.csv", 1, "three, line 1: '1 2 3' is no pair; give two sources, as in: 0 17"),
        ("--pairs within -o a.csv", 1, "within, line 2: the second of a pair is one vertex"),
        ("--pairs within -o within", 1, "cannot write within: the name has no extension"),
        ("--pairs far.csv -o far.csv", 1, "cannot write far.csv: it is the input far.csv, which would be lost"),
        ("--pairs none -o a.csv", 1, "none: there is no such file"),
    ],
)
def test_refused(words: str, code: int, sentence: str, folder: Path) -> None:
    """In one sentence, before anything is written."""
    for name, text in {
        "bad.npy": "x", "empty": "", "far": "3\n208", "three": "1 2 3", "within": "1 2\n3 face:4", "far.csv": "1 2",
    }.items():  # fmt: skip
        Path(name).write_text(text)
    before = sorted(os.listdir())
    answer = run("geodesic", "mesh.off", *words.split())
    assert answer.exit_code == code
    assert f"Error: {sentence}" in answer.stderr
    assert sorted(os.listdir()) == before
