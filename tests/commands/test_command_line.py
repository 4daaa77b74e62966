"""The command line itself: version, defaults from the environment, log, suggestions, restarts, files of former runs."""

import json
from pathlib import Path

import pytest

from geomhw.io.artifacts.series import read_series
from geomhw.mesh.primitives import icosphere
from support.program import contents, files, run, save_off

SHORT = ("--dt", "0.01", "--steps", "4", "--every", "2", "-q")


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(icosphere(1))
    return folder


def test_version() -> None:
    """``-V`` prints the version."""
    assert run("-V").stdout == run("--version").stdout


def test_defaults_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """GEOMHW_COMMAND_OPTION is a default, which the command line overrides; a wrong one is refused."""
    monkeypatch.setenv("GEOMHW_GEODESIC_TIME", "3*h2")
    monkeypatch.setenv("GEOMHW_GEODESIC_ROBUST", "1")
    arguments = ("geodesic", "ball.off", "-o", "r.vtp", "--json")
    report = json.loads(run(*arguments).stdout)
    assert report["time"]["asked"] == "3*h2"
    assert "robust" in report
    assert json.loads(run(*arguments, "--time", "h2").stdout)["time"]["asked"] == "h2"
    monkeypatch.setenv("GEOMHW_FLUID_STEPS", "soon")
    assert run("fluid", "ball.off").exit_code == 2
    monkeypatch.setenv("GEOMHW_FLUID_STEPS", "7")
    assert run("fluid", "ball.off", "--dt", "0.01", "--until", "0.02", "--no-png", "-q").exit_code == 0


def test_log() -> None:
    """``-v`` logs on stderr what is done; stdout stays as it is."""
    plain = run("geodesic", "ball.off", "-o", "r.vtp")
    answer = run("geodesic", "ball.off", "-o", "r.vtp", "-v")
    assert answer.stdout == plain.stdout
    assert plain.stderr == ""
    for word in ("reading ball.off", "42 vertices", "compute", "write", " s\n"):
        assert word in answer.stderr


def test_quiet_wins_over_json() -> None:
    """``-q`` prints nothing, also with ``--json``."""
    assert run("geodesic", "ball.off", "-o", "r.vtp", "-q", "--json").output == ""


@pytest.mark.parametrize(
    ("command", "wrong", "meant"),
    [
        ("operators", "--laplacian", "--stiffness"),
        ("geodesic", "--intrinsic", "--robust"),
        ("fluid", "--iterations", "--steps"),
        ("advect", "--particles", "--tracers"),
        ("geodesic", "--sorce", "--source"),
        ("vecdiffuse", "--time-step", "--dt"),
    ],
)
def test_suggestions(command: str, wrong: str, meant: str) -> None:
    """An unknown option is answered by one of the same meaning."""
    answer = run(command, "ball.off", wrong)
    assert answer.exit_code == 2
    assert meant in answer.stderr.splitlines()[-1]


def test_every_init_is_listed() -> None:
    """An unknown initial velocity is answered by all that there are."""
    answer = run("fluid", "ball.off", "--init", "swirl")
    for word in ("rotation", "rigid", "random", "rossby-haurwitz", "vortices", "harmonic", "FILE:ARRAY"):
        assert word in answer.stderr


def test_a_folder_for_a_file(folder: Path) -> None:
    """A folder in the place of a file is named as such."""
    (folder / "sub").mkdir()
    for arguments in (["info", "sub"], ["geodesic", "ball.off", "-o", "sub"], ["geodesic", "ball.off", "--png", "sub"]):
        assert "is a folder" in run(*arguments).stderr


def test_restart_alone(folder: Path) -> None:
    """``--restart`` alone goes on with the options and the series of its file."""
    options = ("--scheme", "rk4", "--color", "z", "--cfl", "0.3", "--force", "none", "--every", "2", "-q")
    run("fluid", "ball.off", *options, "--steps", "8", "-o", "whole.pvd")
    run("fluid", "ball.off", *options, "--steps", "4", "-o", "part.pvd")
    assert run("fluid", "ball.off", "--restart", "part.restart.npz", "--steps", "8", "-q").exit_code == 0
    whole, part = (sorted(p.read_bytes() for p in folder.glob(f"{name}.0*.vtp")) for name in ("whole", "part"))
    assert len(whole) == 5
    assert whole == part
    assert "part.pvd" in files(folder)


def test_restart_keeps_tracers() -> None:
    """A restart without --tracers goes on with those of the earlier run."""
    run("fluid", "ball.off", *SHORT, "--tracers", "5", "-o", "r.pvd")
    arguments = ("--restart", "r.restart.npz", "--steps", "8", "-q")
    assert run("fluid", "ball.off", *arguments, "--no-png").exit_code == 0
    assert len([frame for frame in read_series("r.pvd") if frame.tracers]) == 5


def test_frames_of_a_longer_run(folder: Path) -> None:
    """Frames and tracers of a longer run of the same name are removed, and named; other files stay."""
    run("advect", "ball.off", *SHORT, "--tracers", "5", "-o", "r.pvd")
    Path("r.99999.vtp").write_text("mine")
    answer = run("advect", "ball.off", "--dt", "0.01", "--steps", "1", "--every", "1", "-o", "r.pvd")
    assert "note" in answer.stdout
    assert "r.00002.vtp" in answer.stdout
    assert {name for name in files(folder) if name.startswith("r.0")} == {frame.file for frame in read_series("r.pvd")}
    assert not Path("r.tracers.vtp.series").exists()
    assert contents(folder)["r.99999.vtp"] == b"mine"


def test_standard_input_and_output() -> None:
    """``-`` is a stream whose format ``--format`` names; the report goes to stderr; default names start with stdin."""
    mesh = Path("ball.off").read_bytes()
    assert json.loads(run("info", "-", "--format", "off", "--json", stdin=mesh).stdout)["mesh"]["vertices"] == 42
    run("geodesic", "ball.off", "-o", "file.ply", "-q")
    answer = run("geodesic", "-", "--format", "off", "-o", "-", "--output-format", "ply", "-o", "both.ply", stdin=mesh)
    assert answer.stdout_bytes == Path("file.ply").read_bytes() == Path("both.ply").read_bytes()
    assert "wrote     -\n" in answer.stderr
    answer = run("repair", "ball.off", "-o", "-", "--format", "vtu", "--json")
    assert answer.stdout_bytes.startswith(b"<?xml")
    assert json.loads(answer.stderr)["files"] == ["-"]
    assert run("vecdiffuse", "-", "--format", "OFF", "--no-png", "-q", stdin=mesh).exit_code == 0
    assert Path("stdin.vecdiffuse.vtk").exists()
    Path("ball.off").rename("ball.dat")
    assert run("operators", "ball.dat", "--format", ".off", "--gradient", "-o", "G.npz").exit_code == 0
    with_meshio = (
        b"MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n0 1 0 0\nTriangles\n1\n1 2 3 0\nEnd\n"
    )
    assert run("info", "-", "--format", "mesh", stdin=with_meshio).exit_code == 0


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("info -", "--format"),
        ("info - --format docx", "docx"),
        ("info - --format ply", "standard input"),
        ("info ball.off --format ply", "ball.off"),
        ("geodesic ball.off -o -", "--output-format"),
        ("geodesic ball.off -o - --format off", "'off'"),
        ("geodesic ball.off -o - -o - --format ply", "two"),
        ("geodesic ball.off -o a.ply --png -", ".png"),
        ("geodesic ball.off --all-pairs -o - --format ply", ".npy"),
        ("operators ball.off --gradient -o -", ".npz"),
        ("fluid ball.off -o -", ".pvd"),
    ],
)
def test_streams_that_are_refused(line: str, words: str) -> None:
    """A stream without a format, or one that cannot be read or written, is refused, and nothing is written."""
    answer = run(*line.split(), stdin=b"")
    assert answer.exit_code == (1 if words == "standard input" else 2)
    assert words in answer.stderr
    assert answer.stdout == ""
    assert [path.name for path in Path().iterdir()] == ["ball.off"]


def test_info_on_several_meshes() -> None:
    """Each mesh that can be read is shown, and the exit code is that of the worst."""
    save_off(icosphere(2), "next.off")
    answer = run("info", "ball.off", "none.off", "next.off", "--json")
    assert [document["mesh"]["vertices"] for document in json.loads(answer.stdout)] == [42, 162]
    assert "none.off" in answer.stderr
    assert answer.exit_code == 1
    assert run("info", "ball.off", "none.off", "--check").exit_code == 2
    assert run("info", "ball.off", "next.off").stdout.count("genus") == 2


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("geodesic ball.off -source 3", "'--source'"),
        ("info ball.off -check", "'--check'"),
        ("geodesic ball.off out.vtp", "-o"),
        ("advect ball.off -o film.mp4", "--mp4"),
        ("advect ball.off --gif film.mp4", "--mp4"),
        ("geodesic ball.off -o picture.png", "--png"),
        ("geodesic moo.offf", "no such file"),
        ("ball.off", "geomhw info ball.off"),
        ("advect ball.off --until 3", "--steps"),
        ("geodesic moo", "no such file"),
        ("geodesic wrong.stl", "extension .off"),
    ],
)
def test_messages_name_what_was_meant(line: str, words: str) -> None:
    """The message for a slip names the option, the argument or the extension that was meant."""
    Path("wrong.stl").write_bytes(Path("ball.off").read_bytes())
    answer = run(*line.split())
    assert answer.exit_code in (1, 2)
    assert words in answer.stderr


def test_names_in_any_case() -> None:
    """Choices are accepted in upper case."""
    report = json.loads(run("fluid", "ball.off", *SHORT[:-1], "--scheme", "RK4", "--no-png", "--json").stdout)
    assert report["scheme"] == "rk4"
