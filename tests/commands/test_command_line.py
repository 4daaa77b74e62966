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
    assert run("fluid", "ball.off", "--dt", "0.01", "--until", "0.02", "-q").exit_code == 0


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
    assert run("fluid", "ball.off", *arguments).exit_code == 0
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
