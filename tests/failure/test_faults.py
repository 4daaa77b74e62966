"""Full disks, kills, links and concurrent runs: no partial file, no lost input."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result as Answer

from geomhw.io import read, read_series, replacing, write
from geomhw.mesh.primitives import icosphere
from geomhw.results import Field, Result
from support.messages import missing
from support.pictures import needs_opengl
from support.program import contents, files_no_larger_than, run, save_off

BALL = icosphere(1)
LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="made of Linux's own tools")
FLOW = "--dt 0.01 --steps 4 --every 2"
FILM = "--dt 0.01 --steps 1"
#: A command for each writer: every format and every kind of file.
COMMANDS = {
    "geodesic": "geodesic ball.off -o a.vtk -o b.vtp -o c.vtu -o d.ply --png e.png",
    "vecdiffuse": "vecdiffuse ball.off -o a.ply",
    "helmholtz": "helmholtz ball.off --field ball.ply:v -o a.vtu",
    "npz": "operators ball.off --stiffness -o S.npz",
    "mtx": "operators ball.off --gradient -o G.mtx",
    "advect": f"advect ball.off {FLOW} -o s.pvd --tracers 5 --csv t.csv",
    "mp4": f"advect ball.off {FILM} -o s.pvd --mp4 f.mp4",
    "fluid": f"fluid ball.off {FLOW} -o s.pvd --csv t.csv",
    "compare": "compare one.png other.png --diff d.png",
}
DRAWS = ["geodesic", "mp4"]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a sphere, a field on it and two pictures."""
    from PIL import Image

    save_off(BALL)
    write(Result(BALL, [Field("v", "face", np.ones((BALL.n_faces, 3)))]), "ball.ply")
    noise = np.random.default_rng(0).integers(0, 256, (90, 90, 3), dtype=np.uint8)
    Image.fromarray(noise).save("one.png")
    Image.fromarray(noise[::-1]).save("other.png")
    return folder


def trouble(command: str) -> int:
    """Return the exit code of a failure."""
    return 2 if command.startswith("compare") else 1


def assert_refused(answer: Answer, *words: str, code: int = 1) -> None:
    """Check the exit code, and one line with these keywords."""
    assert answer.exit_code == code, answer.output
    lines = answer.stderr.splitlines()
    assert len(lines) == 1, answer.stderr
    assert lines[0].startswith("Error: ")
    for word in words:
        assert not missing(lines[0], word)


# -- full disks and read-only folders ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "share"),
    [(name, share) for name in COMMANDS if name not in DRAWS for share in (0.0, 0.5, 0.99)]
    + [pytest.param(name, share, marks=needs_opengl) for name in DRAWS for share in (0.5, 0.99)],
)
def test_no_room(name: str, share: float, folder: Path) -> None:
    """A file that does not fit is absent; the others are complete, and no temporary file is left."""
    before = contents(folder)
    arguments = COMMANDS[name].split()
    assert run(*arguments).exit_code == (1 if name == "compare" else 0)
    after = contents(folder)
    made = {file: data for file, data in after.items() if file not in before}
    for file in made:
        Path(file).unlink()
    largest = max(map(len, made.values()))
    with files_no_larger_than(int(share * largest)):
        answer = run(*arguments)
    assert_refused(answer, "cannot write ", code=trouble(name))
    left = contents(folder)
    assert left.keys() <= after.keys()
    assert left != after
    for file, data in left.items():
        if file.endswith((".pvd", ".series", ".csv", ".npz")):  # grown frame by frame
            assert file in made
            assert all(Path(frame.file).exists() for frame in read_series("s.pvd"))
        else:
            assert data == after[file]


def test_no_room_for_a_gif(folder: Path) -> None:
    """A film that does not fit is absent."""
    from geomhw.errors import FormatError
    from geomhw.io import write_gif

    before = contents(folder)
    noise = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    with files_no_larger_than(4000), pytest.raises(FormatError, match=r"^cannot write f\.gif.*File too large"):
        write_gif("f.gif", [noise, noise[::-1]])
    assert contents(folder) == before


def in_namespace(script: str) -> "subprocess.CompletedProcess[str]":
    """Run a shell script in its own mount namespace, or skip the test."""
    options = ["--mount"] if os.geteuid() == 0 else ["--mount", "--map-root-user"]
    try:
        subprocess.run(["unshare", *options, "true"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no mounts of one's own here")
    program = f'geomhw() {{ {sys.executable} -m geomhw_cli "$@"; }}; {script}'
    return subprocess.run(["unshare", *options, "sh", "-c", program], capture_output=True, text=True)


@LINUX
def test_a_disk_that_is_full() -> None:
    """On a full file system of 16 kB: one line, exit code 1, and the former files only."""
    answer = in_namespace(
        "mkdir disk && mount -t tmpfs -o size=16k none disk || exit 99; echo old >disk/a.vtk; cd disk;"
        "geomhw geodesic ../ball.off -o a.vtk -o b.ply; echo $?; ls -A; cat a.vtk"
    )
    assert answer.stdout.split() == ["1", "a.vtk", "old"], answer
    (line,) = answer.stderr.splitlines()
    assert not missing(line, "Error: cannot write a.vtk, b.ply ... No space left on device ... another disk")


@LINUX
@pytest.mark.parametrize("command", ["advect --field rigid:y --dt 0.01", "fluid --force none --dt 0.01"])
@pytest.mark.parametrize("at", [0, 1, 2, 3])
def test_a_disk_that_is_full_after_some_frames(
    command: str, at: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When the disk fills up at a frame: one line, a valid series of the frames before, and no film."""
    flush = os.fsync

    def no_room(handle: int) -> None:
        if Path(os.readlink(f"/proc/self/fd/{handle}")).name.startswith(f".f.{at:05d}."):
            raise OSError(errno.ENOSPC, "No space left on device")
        flush(handle)

    monkeypatch.setattr(os, "fsync", no_room)
    name, *options = command.split()
    outputs = ("-o", "f.pvd", "--csv", "f.csv", "--gif", "f.gif")
    answer = run(name, "ball.off", *options, "--steps", "3", "--every", "1", *outputs)
    assert_refused(answer, f"cannot write f.{at:05d}.vtp", "No space left on device")
    expected = {f"f.{k:05d}.vtp" for k in range(at)} | ({"f.pvd", "f.vtp.series", "f.csv"} if at else set())
    state = {"f.restart.npz"} if at and name == "fluid" else set()
    assert {file for file in contents(folder) if file.lstrip(".").startswith("f.")} == expected | state
    assert at == 0 or len(read_series("f.pvd")) == at


@LINUX
def test_a_folder_that_is_read_only() -> None:
    """A read-only mount gives one line and no file."""
    answer = in_namespace(
        "mkdir disk && mount -t tmpfs none disk && mount -o remount,ro disk || exit 99; cd disk;"
        "geomhw geodesic ../ball.off --no-png; echo $?; ls -A"
    )
    assert answer.stdout.split() == ["1"], answer
    (line,) = answer.stderr.splitlines()
    assert not missing(line, "Error: cannot write ball.geodesic.vtk ... Read-only file system ... folder")


@LINUX
@pytest.mark.parametrize("command", ["info ball.off", "--help", "compare one.png one.png"])
def test_standard_output_that_is_full(command: str) -> None:
    """A full standard output gives one line and a nonzero exit code."""
    with open("/dev/full", "w") as full:
        answer = subprocess.run(
            [sys.executable, "-m", "geomhw_cli", *command.split()], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert answer.returncode == (2 if "compare" in command else 1)
    (line,) = answer.stderr.splitlines()
    assert not missing(line, "Error: ... standard output ... No space left on device")


def test_a_film_that_ffmpeg_does_not_finish(monkeypatch: pytest.MonkeyPatch) -> None:
    """An error of ffmpeg is reported in its own words, and leaves no file."""
    import imageio_ffmpeg

    from geomhw.errors import FormatError
    from geomhw.io import write_mp4

    Path("ffmpeg").write_text("#!/bin/sh\necho 'first' >&2; echo 'codec missing' >&2; exit 3\n")
    Path("ffmpeg").chmod(0o755)
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: os.path.abspath("ffmpeg"))
    with pytest.raises(FormatError, match=r"^cannot write f\.mp4.*codec missing$"):
        write_mp4("f.mp4", [np.zeros((300, 300, 3), np.uint8)] * 9)
    assert not [file for file in os.listdir() if "mp4" in file]


# -- kills and interrupts ---------------------------------------------------------------------------------------------

#: A run that stops at the chosen system call, prints a line, and waits.
STOPPING = """
import os, signal, sys, time
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # which is ignored where the tests run under nohup
calls, at, seconds = 0, int(sys.argv.pop()), float(sys.argv.pop())
def stop(former):
    def stopping(*arguments):
        global calls
        calls += 1
        if calls == at:
            print("there", flush=True)
            time.sleep(seconds)
        return former(*arguments)
    return stopping
os.fsync = stop(os.fsync)
os.replace = stop(os.replace)
from geomhw_cli.main import main
main()
"""


def ended(number: int, at: int, command: str, seconds: float = 60) -> "subprocess.CompletedProcess[str]":
    """Run the command, and send a signal at the given call of fsync or rename."""
    words = [sys.executable, "-c", STOPPING, *command.split(), str(seconds), str(at)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout
        assert process.stdout.readline() == "there\n"
        process.send_signal(number)
        out, err = process.communicate(timeout=30)
    return subprocess.CompletedProcess(words, process.returncode, out, err)


TWO = "geodesic ball.off -o a.vtk -o b.ply"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("at", [2, 4])
def test_interrupted(number: int, at: int, folder: Path) -> None:
    """SIGINT, SIGTERM and SIGHUP restore the former files and leave nothing else."""
    Path("a.vtk").write_text("old")
    before = contents(folder)
    answer = ended(number, at, TWO)
    assert answer.returncode == 128 + number
    assert answer.stderr.strip() == "Error: interrupted"
    assert contents(folder) == before


@pytest.mark.parametrize("at", [1, 2, 3, 4])
def test_killed(at: int, folder: Path) -> None:
    """After SIGKILL each file is the old or the new one; leftovers have telling names; the next run works."""
    run(*TWO.split())
    new = {file: Path(file).read_bytes() for file in ("a.vtk", "b.ply")}
    Path("a.vtk").write_text("old")
    Path("b.ply").unlink()
    before = contents(folder)
    assert ended(signal.SIGKILL, at, TWO).returncode == -signal.SIGKILL
    after = contents(folder)
    for file in new:
        assert after.get(file) in (before.get(file), new[file])
    left = after.keys() - before.keys() - new.keys()
    assert left
    locks = {".a.vtk.lock", ".b.ply.lock"}
    assert all(file.startswith((".a.unfinished-", ".a.former-", ".b.unfinished-")) for file in left - locks)
    run(*TWO.split())
    assert not locks & contents(folder).keys()  # those of a dead process are taken over
    assert {file: Path(file).read_bytes() for file in new} == new
    assert contents(folder).keys() - left == before.keys() | new.keys()


def test_an_interrupt_in_a_series_is_held_back(folder: Path) -> None:
    """A signal during a frame takes effect after it: frame, index and state are written, then the run ends."""
    answer = ended(signal.SIGTERM, 5, f"fluid ball.off {FLOW} --force none -o s.pvd", seconds=1)
    assert answer.returncode == 128 + signal.SIGTERM
    assert "--restart s.restart.npz" in answer.stderr
    assert not [file for file in os.listdir() if file.startswith(".")]
    done = run("fluid", "ball.off", *FLOW.split(), "--force", "none", "-o", "s.pvd", "--restart", "s.restart.npz")
    assert done.exit_code == 0
    assert len(read_series("s.pvd")) == 3


# -- concurrent runs --------------------------------------------------------------------------------------------------

RIVAL = """
import sys
from geomhw.io import replacing
for _ in range(200):
    with replacing(["a.txt", "b.txt"]) as temporaries:
        for temporary in temporaries:
            temporary.write_text(sys.argv[1] * 100_000)
"""


def test_two_runs_at_once(folder: Path) -> None:
    """While two processes write the same files, a reader always finds a complete file."""
    whole = {letter * 100_000 for letter in "xy"}
    rivals = [subprocess.Popen([sys.executable, "-c", RIVAL, letter]) for letter in "xy"]
    seen = set()
    while any(rival.poll() is None for rival in rivals):
        seen |= {path.read_text() for path in (Path("a.txt"), Path("b.txt")) if path.exists()}
        time.sleep(0.001)
    assert [rival.returncode for rival in rivals] == [0, 0]
    assert seen <= whole
    assert not [file for file in os.listdir() if file.startswith(".")]


# -- special targets --------------------------------------------------------------------------------------------------

#: Commands with one output named out.*, and their inputs.
TARGETS = {
    "geodesic ball.off -o out.vtk": ["ball.off"],
    "geodesic ball.off -o x.vtk --png out.png": ["ball.off"],
    "vecdiffuse ball.off -o out.ply": ["ball.off"],
    "helmholtz ball.off --field ball.ply:v -o out.vtu": ["ball.off", "ball.ply"],
    "operators ball.off --mass -o out.npz": ["ball.off"],
    f"advect ball.off {FLOW} --field ball.ply:v -o out.pvd": ["ball.off", "ball.ply"],
    f"advect ball.off {FLOW} -o s.pvd --csv out.csv": ["ball.off"],
    f"fluid ball.off {FLOW} -o s.pvd --gif out.gif": ["ball.off"],
    f"fluid ball.off {FLOW} --init ball.ply:v -o s.pvd --mp4 out.mp4": ["ball.off", "ball.ply"],
    "compare one.png other.png --diff out.png": ["one.png", "other.png"],
}


def target_of(command: str) -> Path:
    return Path(next(word for word in command.split() if word.startswith("out.")))


def refused(command: str, folder: Path, *words: str) -> None:
    """Check that the command is refused with these keywords, and changes no file."""
    before = contents_and_links(folder)
    answer = run(*command.split())
    assert_refused(answer, f"cannot write {target_of(command)}: ", *words, code=trouble(command))
    assert contents_and_links(folder) == before


def contents_and_links(folder: Path) -> dict[str, object]:
    return {
        path.name: os.readlink(path) if path.is_symlink() else path.is_dir() or path.read_bytes()
        for path in folder.iterdir()
    }


@pytest.mark.parametrize("command", TARGETS)
@pytest.mark.parametrize("link", ["symbolic", "hard", "chain"])
def test_an_input_under_another_name(command: str, link: str, folder: Path) -> None:
    """No input is overwritten through symbolic links, hard links or chains of links."""
    target = target_of(command)
    for source in TARGETS[command]:
        if link == "hard":
            os.link(source, target)
        else:
            target.symlink_to("between" if link == "chain" else source)
            if link == "chain":
                Path("between").symlink_to(source)
        refused(command, folder, f"input {source}")
        target.unlink()
        Path("between").unlink(missing_ok=True)


@pytest.mark.parametrize("command", TARGETS)
def test_what_is_no_file(command: str, folder: Path) -> None:
    """Folders, dangling links, loops of links and devices are refused before the computation."""
    target = target_of(command)
    target.mkdir()
    refused(command, folder, "it is a folder")
    target.rmdir()
    target.symlink_to("nowhere/out")
    refused(command, folder, "there is no folder")
    target.unlink()
    target.symlink_to(target.name)
    refused(command, folder, "link ... to itself")
    target.unlink()
    target.symlink_to("/dev/null")
    refused(command, folder, "a device or a pipe")
    assert Path("/dev/null").is_char_device()


def test_a_link_into_nowhere_is_filled(folder: Path) -> None:
    """A link to a missing file in an existing folder is written through."""
    (folder / "far").mkdir()
    Path("out.vtk").symlink_to("far/real.vtk")
    assert run("geodesic", "ball.off", "-o", "out.vtk").exit_code == 0
    assert Path("out.vtk").is_symlink()
    assert read("far/real.vtk").mesh.n_faces == BALL.n_faces


@pytest.mark.parametrize("name", ["s.00001.vtp", "s.vtp.series", "s.tracers.00000.vtp", "s.restart.npz"])
@pytest.mark.parametrize("link", ["symbolic", "hard"])
def test_an_input_that_a_frame_would_replace(name: str, link: str, folder: Path) -> None:
    """A series is refused if one of its files is a link to an input."""
    (os.link if link == "hard" else os.symlink)("ball.ply", name)
    before = contents_and_links(folder)
    answer = run(*f"advect ball.off {FLOW} --field ball.ply:v -o s.pvd".split())
    assert_refused(answer, "cannot write s.pvd", "input ball.ply")
    assert contents_and_links(folder) == before


def test_a_field_of_a_state_is_not_replaced_by_one(folder: Path) -> None:
    """A series is refused if its state would overwrite an input array."""
    run(*f"fluid ball.off {FLOW} --force none -o s.pvd".split())
    before = contents(folder)
    answer = run(*f"fluid ball.off {FLOW} --force none --color s.restart.npz:color -o s.pvd".split())
    assert_refused(answer, "input s.restart.npz")
    assert contents(folder) == before


@pytest.mark.parametrize(
    "command", ["geodesic ball.off -o a.vtk --png a.png", f"advect ball.off {FLOW} -o a.pvd --csv a.csv"]
)
def test_two_outputs_that_are_one_file(command: str, folder: Path) -> None:
    """Two outputs that are links to one file are refused."""
    words = command.split()
    Path(words[-1]).symlink_to(words[-3])
    before = contents_and_links(folder)
    assert_refused(run(*words), "two of the outputs")
    assert contents_and_links(folder) == before


def test_names_that_are_no_letters() -> None:
    """A file name that is not UTF-8 is printed escaped, and refused for a series."""
    name = os.fsdecode(b"b\xffll.off")
    os.rename("ball.off", name)
    command = [sys.executable, "-m", "geomhw_cli", "advect", name, *FLOW.split()]
    answer = subprocess.run(command, capture_output=True, text=True)
    assert answer.returncode == 1
    (line,) = answer.stderr.splitlines()
    assert not missing(
        line, "Error: cannot write b\\udcffll.advect/b\\udcffll.advect.pvd ... name of a series ... index"
    )
    assert subprocess.run([*command[:3], "geodesic", name, "--no-png"], capture_output=True).returncode == 0


def test_an_error_without_a_name(folder: Path) -> None:
    """An error without a file name lists all targets and the remedy."""
    from geomhw.errors import FormatError

    def fail() -> None:
        with replacing(["a.txt", "b.txt"]):
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(FormatError, match=r"^cannot write a\.txt, b\.txt.*No space left on device"):
        fail()
