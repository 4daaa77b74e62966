"""Locks of outputs, and saved states that are damaged: refused in one sentence, and nothing else is touched."""

import json
import os
import subprocess
import sys
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import FormatError
from geomhw.io.artifacts.checkpoints import read_checkpoint
from geomhw.io.artifacts.resumable_file import ResumableFile, Written, write_part
from geomhw.io.locks import locked
from geomhw.mesh.primitives import icosphere
from support.program import contents, files, one_line, run, save_off

SHORT = ("--dt", "0.01", "--steps", "4", "--every", "2", "-o", "r.pvd", "--force", "none", "-q")
HOLD = """
import sys, time
from pathlib import Path
from geomhw.io.locks import locked
with locked([Path(name) for name in sys.argv[1:]]):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(icosphere(1))
    return folder


@pytest.mark.parametrize("target", ["r.pvd", "t.csv", "f.gif", "s.png"])
@pytest.mark.parametrize("command", ["advect", "fluid"])
def test_a_second_run_on_a_target(command: str, target: str, folder: Path) -> None:
    """A second run on a series, table, film or picture is refused by name; a killed run leaves no lock."""
    arguments = [command, "ball.off", "--steps", "1", "-q", "-o", "r.pvd"]
    arguments += {"t.csv": ["--csv"], "f.gif": ["--gif"], "s.png": ["--png"]}.get(target, [])
    arguments += [target] if target != "r.pvd" else []
    with subprocess.Popen([sys.executable, "-c", HOLD, target], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout
        assert other.stdout.readline() == "held\n"
        one_line(run(*arguments), target, "another run")
        other.kill()
    with locked([Path(target)]):
        pass
    assert files(folder) == ["ball.off"]


@pytest.mark.parametrize("target", ["a.vtp", "a.png", "a.pdf"])
@pytest.mark.parametrize("command", ["geodesic ball.off", "path ball.off --from 0 --to 1"])
def test_a_second_run_on_a_result(command: str, target: str, folder: Path) -> None:
    """The data of one run and the picture of another are not mixed."""
    with subprocess.Popen([sys.executable, "-c", HOLD, target], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout
        assert other.stdout.readline() == "held\n"
        one_line(run(*command.split(), "-o", "a.vtp", "--png", "a.png", "--pdf", "a.pdf"), target, "another run")
        other.kill()
    run(*command.split(), "--no-png", "-o", "a.vtp")
    assert "a.vtp" in files(folder)
    assert ".a.vtp.lock" not in files(folder)


@pytest.mark.parametrize(
    "command",
    [
        "voronoi ball.off --sites 4 --points t.csv",
        "bracket ball.off --field rigid:x --field rigid:y --commutator t.mtx",
    ],
)
def test_a_second_run_on_a_file_beside_the_result(command: str, folder: Path) -> None:
    """Other data files of a command are locked with its result."""
    target = command.split()[-1]
    with locked([Path(target)]):
        one_line(run(*command.split(), "--no-png", "-o", "a.vtp"), target, "another run")
    assert files(folder) == ["ball.off"]


def test_a_second_run_on_a_matrix(folder: Path) -> None:
    """Two runs do not write one matrix; the lock is there before the first byte."""
    with ResumableFile("D.npy", {"a": 1}, b"start", 100):
        with pytest.raises(FormatError, match="another run"):
            ResumableFile("D.npy", {"a": 2}, b"start", 100)
        one_line(run("geodesic", "ball.off", "--all-pairs", "-o", "D.npy"), "D.partial.npy", "another run")
    assert files(folder) == ["ball.off"]


def test_a_second_run_leaves_the_first_alone(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A refused run does not remove the file of the other, which may be empty still."""
    former, tried = ResumableFile._save, []

    def second(self: ResumableFile) -> None:
        if not tried:
            tried.append(1)
            with pytest.raises(FormatError, match="another run"):
                ResumableFile("D.npy", {"a": 2}, b"start", 100)
        former(self)

    monkeypatch.setattr(ResumableFile, "_save", second)
    with ResumableFile("D.npy", {"a": 1}, b"start", 13) as first:
        first.append(b"row one.", 1, {})
        first.finish()
    assert tried
    assert contents(folder).pop("D.npy") == b"startrow one."


def test_a_second_run_while_the_first_finishes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that starts while another gives its file the final name is refused, and cuts nothing off."""
    former, tried = os.replace, []

    def second(*names: object) -> None:
        tried.append(1)
        with pytest.raises(FormatError, match="another run"):
            ResumableFile("D.npy", {"a": 1}, b"start", 13)
        former(*names)  # type: ignore[arg-type]

    with ResumableFile("D.npy", {"a": 1}, b"start", 13) as first:
        first.append(b"row one.", 1, {})
        monkeypatch.setattr(os, "replace", second)
        first.finish()
    assert tried
    assert contents(folder).pop("D.npy") == b"startrow one."


def stopped_matrix() -> None:
    """Leave an unfinished matrix of two rows."""
    with ResumableFile("D.npy", {"a": 1}, b"start", 21) as partial:
        partial.append(b"row one.", 1, {})
        partial.append(b"row two.", 2, {})


@pytest.mark.parametrize(
    "change",
    [
        lambda state: state.update(done=1),
        lambda state: state.update(bytes=13),
        lambda state: state.update(done="2"),
        lambda state: state.update(note={"largest_distance": 3}),
        lambda state: state.update(checksum=0),
        lambda state: state.pop("checksum"),
        lambda state: state.update(bytes=-1),
        lambda state: state.update(bytes=1e300),
    ],
)
def test_damaged_progress(change: object, folder: Path) -> None:
    """Progress that is not as it was written is refused, and the rows stay."""
    stopped_matrix()
    state = json.loads(Path("D.partial.json").read_text())
    change(state)  # type: ignore[operator]
    Path("D.partial.json").write_text(json.dumps(state))
    before = contents(folder)
    with pytest.raises(FormatError, match=r"D\.partial\.json"):
        ResumableFile("D.npy", {"a": 1}, b"start", 21)
    assert contents(folder) == before


@pytest.mark.parametrize("at", [0, 4, 5, 12, 20])
def test_damaged_rows(at: int, folder: Path) -> None:
    """A changed byte in the rows or their header is refused."""
    stopped_matrix()
    data = bytearray(Path("D.partial.npy").read_bytes())
    data[at] ^= 1
    Path("D.partial.npy").write_bytes(data)
    with pytest.raises(FormatError, match=r"D\.partial\.npy is damaged"):
        ResumableFile("D.npy", {"a": 1}, b"start", 21)
    assert Path("D.partial.npy").read_bytes() == data


@pytest.mark.parametrize("sizes", [(8, 8), (0, 16), (1, 15), (100_000, 7)])
def test_parts_that_other_processes_write(sizes: tuple[int, int], folder: Path) -> None:
    """Parts in any order, some through this process: the file of one run, also after an interrupt between them."""
    one, two = (bytes(k % 251 for k in range(size)) for size in sizes)
    size = 5 + sum(sizes)
    with ResumableFile("D.npy", {"a": 1}, b"start", size) as partial:
        write_part(partial.place(), 5 + sizes[0], two)
        written = write_part(partial.place(), 5, one)
        assert written == Written(sizes[0], zlib.crc32(one))
        partial.append(written, 1, {})
    with ResumableFile("D.npy", {"a": 1}, b"start", size) as partial:
        assert partial.done == 1
        partial.append(two, 2, {})
    with ResumableFile("D.npy", {"a": 1}, b"start", size) as partial:
        assert partial.done == 2
        partial.finish()
    assert Path("D.npy").read_bytes() == b"start" + one + two


def test_parts_go_to_no_other_file(folder: Path) -> None:
    """On a machine without the file, or with that of another run, nothing is written."""
    with ResumableFile("D.npy", {"a": 1}, b"start", 21) as partial:
        place, before = partial.place(), Path("D.partial.npy").read_bytes()
        assert write_part(replace(place, inode=place.inode + 1), 5, b"row one.") is None
        assert write_part(replace(place, run={"a": 2}), 5, b"row one.") is None
        for name in ("path", "state"):
            assert write_part(replace(place, **{name: Path("nowhere")}), 5, b"row one.") is None
        assert Path("D.partial.npy").read_bytes() == before
    assert files(folder) == ["ball.off"]


def test_files_of_others(folder: Path) -> None:
    """A user's own file under the name of the unfinished one is not replaced, and a link is not followed."""
    Path("D.partial.npy").write_text("mine")
    one_line(run("geodesic", "ball.off", "--all-pairs", "-o", "D.npy"), "D.partial.npy", "not of an interrupted run")
    assert Path("D.partial.npy").read_text() == "mine"
    Path("D.partial.npy").rename("mine.npy")
    os.symlink("mine.npy", "D.partial.npy")
    one_line(run("geodesic", "ball.off", "--all-pairs", "-o", "D.npy"), "D.partial.npy", "link")
    assert Path("mine.npy").read_text() == "mine"
    Path("E.partial.json").write_text("mine")
    one_line(run("geodesic", "ball.off", "--all-pairs", "-o", "E.npy"), "E.partial.json", "not the state of a run")
    assert Path("E.partial.json").read_text() == "mine"
    assert not Path("E.partial.npy").exists()


def saved() -> tuple[dict[str, object], dict[str, np.ndarray]]:
    """The description and the arrays of a checkpoint."""
    run("fluid", "ball.off", *SHORT)
    return read_checkpoint("r.restart.npz")


@pytest.mark.parametrize(
    "change",
    [
        lambda text, arrays: arrays["color"].fill(np.nan),
        lambda text, arrays: arrays["rows"].fill(0),
        lambda text, arrays: arrays.pop("rows"),
        lambda text, arrays: arrays.update(color=arrays["color"][:5]),
        lambda text, arrays: arrays.update(color=arrays["color"].astype(complex)),
        lambda text, arrays: text.update(step=-5),
        lambda text, arrays: text.update(step=True),
        lambda text, arrays: text.update(time=float("nan")),
        lambda text, arrays: text.update(columns=[]),
        lambda text, arrays: text.update(run={}),
    ],
)
@pytest.mark.parametrize("is_signed", [False, True])
def test_changed_states(change: object, is_signed: bool, folder: Path) -> None:
    """A state with other values is refused, also with the right digest if it is impossible."""
    from geomhw.io import write_checkpoint

    text, arrays = saved()
    change(text, arrays)  # type: ignore[operator]
    if is_signed:
        write_checkpoint("r.restart.npz", text, arrays)
        if "rows" in arrays and not arrays["rows"].any():
            return
    else:
        np.savez("r.restart.npz", description=np.array(json.dumps(text)), **arrays)
    before = contents(folder)
    one_line(run("fluid", "ball.off", *SHORT, "--restart", "r.restart.npz"), "r.restart.npz")
    assert contents(folder) == before


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.update(run=[1]),
        lambda text: text.update(end="end"),
        lambda text: text["run"].update(viscosity="thick"),
        lambda text: text["run"].update(viscosity=-1.0),
        lambda text: text["run"].update(dt=[0.1]),
        lambda text: text["run"].update(dt=float("nan")),
        lambda text: text["run"].update(smooth=3),
        lambda text: text["run"].update(scheme="none"),
        lambda text: text["run"].update(every=0),
        lambda text: text["run"].update(init=["a"]),
        lambda text: text["run"].update(tracers="many"),
        lambda text: text["end"].update(steps="all"),
        lambda text: text["end"].update(steps=-5),
    ],
)
def test_options_of_a_state(change: object, folder: Path) -> None:
    """Options that a state brings are checked as those of the command line."""
    from geomhw.io import write_checkpoint

    text, arrays = saved()
    change(text)  # type: ignore[operator]
    write_checkpoint("r.restart.npz", text, arrays)
    before = contents(folder)
    one_line(run("fluid", "ball.off", "--restart", "r.restart.npz", "--no-png"), "r.restart.npz")
    assert contents(folder) == before


def test_files_of_a_state() -> None:
    """Files that an option of a state names are inputs."""
    Path("points.csv").write_text("0\n")
    assert run("fluid", "ball.off", *SHORT, "--color", "blob:@points.csv").exit_code == 0
    answer = run("fluid", "ball.off", "--restart", "r.restart.npz", "--steps", "6", "--no-png", "--csv", "points.csv")
    one_line(answer, "points.csv", "input")


@pytest.mark.parametrize("seed", range(40))
def test_damaged_states(seed: int, folder: Path) -> None:
    """Damaged bytes are refused in one sentence, or hit nothing that is read."""
    saved()
    rng = np.random.default_rng(seed)
    data = bytearray(Path("r.restart.npz").read_bytes())
    kind = seed % 4
    if kind == 0:
        data = data[: rng.integers(len(data))]
    elif kind == 1:
        data[rng.integers(len(data))] ^= 1 << rng.integers(8)
    elif kind == 2:
        start = rng.integers(len(data))
        data[start : start + 64] = rng.bytes(64)
    else:
        data = bytearray(rng.bytes(int(rng.integers(1, 300))))
    Path("r.restart.npz").write_bytes(data)
    before = contents(folder)
    answer = run("fluid", "ball.off", *SHORT, "--restart", "r.restart.npz")
    assert answer.exit_code in (0, 1)
    if answer.exit_code:
        assert len(answer.stderr.strip().splitlines()) == 1
        assert contents(folder) == before
    else:
        assert zipfile.is_zipfile("r.restart.npz")
