"""``geodesic --all-pairs``, ``--pairs``, ``--sources``: refusals, full disks, states of other runs."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.many_sources import block_size
from geomhw.mesh.primitives import grid
from support.matrix_runs import ALL, MESH, expected, interrupt, stopping
from support.program import files_no_larger_than, run, save_off


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has an own working folder with a mesh, pairs and sources."""
    save_off(MESH, "mesh.off")
    return folder


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
    sentence = "it takes 346 kB, and there is room for 300 kB; make room, or write to another disk\n"
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
