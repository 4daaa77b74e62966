"""``geodesic --all-pairs``, ``--pairs``, ``--sources``: refusals, full disks, states of other runs."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance, block_size
from geomhw.mesh.primitives import grid
from support.matrix_runs import ALL, MESH, expected, interrupt, stopping
from support.messages import missing
from support.program import files_no_larger_than, run, save_off


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh, pairs and sources."""
    save_off(MESH, "mesh.off")
    return folder


def test_another_run_is_not_gone_on_with(monkeypatch: pytest.MonkeyPatch) -> None:
    """Partial results of other options or another mesh, and damaged ones, are refused and kept."""
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
        (line,) = answer.stderr.splitlines()
        assert not missing(line, f"Error: D.partial.json ... another {word} ... D.partial.npy")
    assert Path("D.partial.npy").read_bytes() == kept
    Path("D.partial.npy").write_bytes(kept[:5000])
    assert not missing(run(*ALL.split()).stderr, "D.partial.npy ... shorter ... D.partial.json")
    Path("D.partial.json").write_text("{}")
    assert not missing(run(*ALL.split()).stderr, "D.partial.json ... not ... state of a run")
    Path("D.partial.npy").unlink()
    assert run(*ALL.split()).exit_code == 1  # a file of this name that is no state is somebody's own
    assert Path("D.partial.json").read_text() == "{}"
    Path("D.partial.json").unlink()
    assert run(*ALL.split()).exit_code == 0
    assert sorted(os.listdir()) == ["D.npy", "mesh.off", "other.off"]


# -- disks and memory -------------------------------------------------------------------------------------------------


def test_no_room_beforehand(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that is too small is reported before the computation starts."""
    from shutil import disk_usage

    monkeypatch.setattr("shutil.disk_usage", lambda path: disk_usage(path)._replace(free=300_000))
    monkeypatch.setattr(HeatDistance, "rows", None)
    answer = run(*ALL.split())
    assert answer.exit_code == 1
    (line,) = answer.stderr.splitlines()
    assert not missing(line, "Error: cannot write D.npy ... 0.346 MB ... 0.300 MB ... another disk")
    assert os.listdir() == ["mesh.off"]


def test_no_room_in_the_middle() -> None:
    """When the disk fills up, the rows so far are kept, and the run resumes when there is room."""
    Path("D.npy").write_text("old")
    with files_no_larger_than(200_000):
        answer = run(*ALL.split())
    assert answer.exit_code == 1
    assert not missing(answer.stderr, "Error: cannot write D.partial.npy ... File too large ... limit")
    assert Path("D.npy").read_text() == "old"
    answer = run(*ALL.split(), "--json")
    assert answer.exit_code == 0, answer.stderr
    assert json.loads(answer.stdout)["resumed_after"] == 3 * block_size(MESH.n_vertices)
    np.testing.assert_allclose(np.load("D.npy"), expected(), rtol=0, atol=1e-11)


# -- refusals ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "code", "keywords"),
    [
        ("--all-pairs", 2, "--all-pairs ... one file ... -o D.npy"),
        ("--all-pairs -o a.npy -o b.npy", 2, "--all-pairs ... one file"),
        ("--all-pairs --pairs mesh.off -o a.npy", 2, "--all-pairs ... --pairs ... exclude"),
        ("--all-pairs --source 3 -o a.npy", 2, "--source ... --all-pairs ... exclude"),
        ("--all-pairs --png a.png -o a.npy", 2, "--png ... --all-pairs ... exclude"),
        ("--single -o a.vtp", 2, "--single ... --all-pairs ... --pairs ... --sources"),
        ("--all-pairs -o a.csv", 2, "cannot write a.csv ... '.csv' ... known are .npy"),
        ("--all-pairs -o no/a.npy", 1, "cannot write no/a.npy ... no folder no"),
        ("--sources bad.npy -o bad.npy", 1, "bad.npy, line 1 ... 'x' is no source"),
        ("--sources empty -o a.npy", 1, "empty ... empty file"),
        ("--sources far -o a.npy", 1, "far, line 2 ... source 208 ... 0 to 207"),
        ("--pairs three -o a.csv", 1, "three, line 1 ... '1 2 3' is no pair"),
        ("--pairs within -o a.csv", 1, "within, line 2 ... second of a pair"),
        ("--pairs within -o within", 2, "cannot write within ... no extension"),
        ("--pairs far.csv -o far.csv", 1, "cannot write far.csv ... input far.csv"),
        ("--pairs none -o a.csv", 1, "none ... no such file"),
    ],
)
def test_refused(words: str, code: int, keywords: str, folder: Path) -> None:
    """Wrong options, outputs and files give one line, and no file is written."""
    for name, text in {
        "bad.npy": "x", "empty": "", "far": "3\n208", "three": "1 2 3", "within": "1 2\n3 face:4", "far.csv": "1 2",
    }.items():  # fmt: skip
        Path(name).write_text(text)
    before = sorted(os.listdir())
    answer = run("geodesic", "mesh.off", *words.split())
    assert answer.exit_code == code
    assert not missing(answer.stderr.splitlines()[-1], f"Error: ... {keywords}")
    assert sorted(os.listdir()) == before
