"""``advect`` and ``fluid`` refuse wrong fields, steps, outputs and restarts, and write nothing then."""

import sys
from pathlib import Path

import numpy as np
import pytest

from geomhw.mesh.triangle_mesh import TriangleMesh
from support.flow_files import BALL, FINE, SHORT, both, series, spoiled_inputs, table
from support.messages import missing
from support.program import contents, files, one_line, run, save_off


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(BALL)
    return folder


@both
def test_no_mp4_without_ffmpeg(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without imageio-ffmpeg, ``--mp4`` is refused before the run starts."""
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    one_line(run(command, "ball.off", *SHORT, "--mp4", "flow.mp4"), "pip install imageio-ffmpeg", "GIF")
    assert files(folder) == ["ball.off"]


@both
@pytest.mark.usefixtures("no_opengl")
def test_no_film_without_opengl(command: str, folder: Path) -> None:
    """Without OpenGL, films are refused before the run starts."""
    one_line(run(command, "ball.off", *SHORT, "--gif", "flow.gif"), "libegl1")
    assert files(folder) == ["ball.off"]
    assert run(command, "ball.off", *SHORT, "--csv", "flow.csv", "--no-png").exit_code == 0
    one_line(run(command, "ball.off", *SHORT, "-q"), f"ball.{command}.pvd", "is written", "--no-png")
    assert f"ball.{command}.00003.vtp" in files(folder / f"ball.{command}")


@both
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["FIELD", "hole.npy"], ["hole.npy", "row 7", "nan"]),
        (["FIELD", "short.npy"], ["short.npy", "79 rows", "80 faces"]),
        (["FIELD", "w.vtp:gale"], ["gale", "wind"]),
        (["FIELD", "w.vtp:u"], ["'u' is not a vector field"]),
        (["FIELD", "none.vtp:u"], ["none.vtp", "no such file"]),
        (["--color", "w.vtp:wind"], ["w.vtp:wind", "per vertex"]),
        (["-o", "none/flow.pvd"], ["no folder none"]),
        (["--csv", "none/flow.csv"], ["no folder none"]),
    ],
)
def test_refusals(command: str, arguments: list[str], words: list[str], folder: Path) -> None:
    """Wrong fields and folders: exit code 1, one line, no file written."""
    spoiled_inputs()
    before = files(folder)
    option = {"advect": "--field", "fluid": "--init"}[command]
    one_line(run(command, "ball.off", *[option if part == "FIELD" else part for part in arguments]), *words)
    assert files(folder) == before


@both
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["FIELD", "spiral"], "'spiral' is no field"),
        (["FIELD", "rigid:up"], "'up' is no axis"),
        (["--color", "plaid"], "'plaid' is no color"),
        (["--color", "blob:top"], "'top' is no source"),
        (["--dt", "soon"], "'soon'"),
        (["--dt", "0"], "'0' is not a number"),
        (["--dt", "-0.1"], "'-0.1' is not a number"),
        (["--dt", "nan"], "'nan' is not a number"),
        (["--steps", "0"], "'0' is not a whole number from 1"),
        (["--every", "0"], "'0' is not a whole number from 1"),
        (["--color", "blob:42"], "source 42 is not a vertex ... 0 to 41"),
        (["-o", "flow.vtk"], "'.vtk'"),
        (["--gif", "flow.avi"], "'.avi'"),
    ],
)
def test_usage(command: str, arguments: list[str], words: str, folder: Path) -> None:
    """Wrong values of options: exit code 2, the reason in the last line, no file written."""
    option = {"advect": "--field", "fluid": "--init"}[command]
    answer = run(command, "ball.off", *[option if part == "FIELD" else part for part in arguments])
    assert answer.exit_code == 2
    assert not missing(answer.stderr.strip().splitlines()[-1], words)
    assert files(folder) == ["ball.off"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--dt", "0.1", "--cfl", "1"], "--dt ... --cfl ... exclude"),
        (["--steps", "3", "--until", "1"], "--steps ... --until ... exclude"),
        (["--cfl", "1"], "--force none"),
        (["--scheme", "best"], "'best'"),
        (["--force", "wind"], "'wind'"),
        (["--until", "0"], "--until ... not a number from"),
        (["--cfl", "-1", "--force", "none"], "--cfl ... not a number from"),
        (["--viscosity", "-1"], "--viscosity ... not 0 or a number from"),
        (["--scheme", "handout", "--viscosity", "1"], "no viscosity"),
    ],
)
def test_fluid_usage(arguments: list[str], words: str, folder: Path) -> None:
    """Options that exclude each other, or unknown choices: exit code 2, no file written."""
    answer = run("fluid", "ball.off", *arguments)
    assert answer.exit_code == 2
    assert not missing(answer.stderr.strip().splitlines()[-1], words)
    assert files(folder) == ["ball.off"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fan.off"], "oriented manifold"),
        (["moebius.off"], "oriented manifold"),
        (["moebius.off", "--scheme", "handout"], "oriented manifold"),
        (["ball.off", "--restart", "none.npz"], "none.npz ... no such file"),
        (["ball.off", "--restart", "hole.npy"], "hole.npy ... no state"),
        (["ball.off", "--restart", "ball.off"], "ball.off ... no state"),
    ],
)
def test_fluid_refusals(arguments: list[str], words: str, folder: Path) -> None:
    """Wrong meshes and numbers: exit code 1, one line, no file written."""
    spoiled_inputs()
    before = files(folder)
    one_line(run("fluid", *arguments), words)
    assert files(folder) == before


def test_a_frame_read_from_is_not_written_over(folder: Path) -> None:
    """A flow that starts from a frame of an earlier series may not overwrite it."""
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *SHORT, "-q")
    before = contents(folder)
    again = ("--init", "ball.fluid.00002.vtp:velocity")
    one_line(
        run("fluid", "ball.off", "-o", "ball.fluid.pvd", *again, *SHORT), "ball.fluid.pvd", "input ball.fluid.00002.vtp"
    )
    assert contents(folder) == before
    assert run("fluid", "ball.off", *again, *SHORT, "-o", "next.pvd").exit_code == 0


def test_a_step_too_long(folder: Path) -> None:
    """When a step is too long halfway, the frames so far form a valid series, and no film is written."""
    arguments = ("--scheme", "fast", "--dt", "0.15", "--steps", "200", "--every", "1")
    answer = run("fluid", "ball.off", "-o", "ball.fluid.pvd", *arguments, "--csv", "f.csv", "--gif", "f.gif")
    one_line(answer, "too long", "Courant number", "the largest")
    frames = series("ball.fluid.pvd")
    assert 1 < len(frames) == len(table("f.csv")) < 200
    assert all(np.isfinite(frame["velocity"]).all() for frame in frames)
    assert not Path("f.gif").exists()
    assert not [name for name in files(folder) if name.startswith(".")]


@pytest.mark.parametrize("mesh", [FINE, TriangleMesh(2 * BALL.vertices, BALL.faces)])
def test_restart_on_another_mesh(mesh: TriangleMesh, folder: Path) -> None:
    """A state of another mesh is refused, also one with as many vertices."""
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *SHORT, "-q")
    save_off(mesh)
    before = contents(folder)
    one_line(run("fluid", "ball.off", *SHORT, "--restart", "ball.fluid.restart.npz"), "mesh")
    assert contents(folder) == before


def test_restart_into_another_series(folder: Path) -> None:
    """A restart into a series with other times is refused."""
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *SHORT, "-q")
    run("fluid", "ball.off", "--dt", "0.02", "--steps", "9", "--every", "3", "-o", "other.pvd", "-q")
    before = contents(folder)
    one_line(run("fluid", "ball.off", *SHORT, "--restart", "ball.fluid.restart.npz", "-o", "other.pvd"), "other.pvd")
    assert contents(folder) == before


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (["--dt", "0.02"], "dt ... 0.01 ... 0.02"),
        (["--scheme", "fast"], "scheme ... conservative ... rk4"),
        (["--init", "rigid:z"], "init ... rotation:x ... rigid:z"),
        (["--every", "2"], "every = 3"),
        (["-o", "other.pvd"], "other.pvd"),
    ],
)
def test_restart_of_another_run(other: list[str], words: str, folder: Path) -> None:
    """A restart with other parameters or another series is refused."""
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *SHORT, "-q")
    before = contents(folder)
    one_line(run("fluid", "ball.off", *SHORT, *other, "--restart", "ball.fluid.restart.npz"), words)
    assert contents(folder) == before
