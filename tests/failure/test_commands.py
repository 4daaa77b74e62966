"""``geodesic`` and ``helmholtz`` refuse broken meshes and wrong arguments, and keep existing files."""

import os
from pathlib import Path

import pytest

from geomhw.io import write
from geomhw.mesh.primitives import icosphere
from geomhw.results import Field
from geomhw.results import Result as MeshResult
from support.program import run, save_off

pytestmark = pytest.mark.usefixtures("folder")


GOOD = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, ["bad.off", "no such file"]),
        ("", ["bad.off", "empty"]),
        (GOOD[:40], ["bad.off", "ends"]),
        (GOOD.replace("4 4 0", "5 4 0"), ["bad.off"]),
        (GOOD.replace("3 0 1 3", "3 0 1 4"), ["bad.off", "line 8", "4"]),
        (GOOD.replace("1 0 0", "nan 0 0", 1), ["bad.off", "line 4", "nan"]),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", ["bad.off", "0 faces"]),
        (GOOD.replace("0 0 1\n", "0.5 0 0\n"), ["face 1", "zero area"]),
    ],
)
def test_bad_mesh_is_one_sentence(text: str | None, words: list[str], folder: Path) -> None:
    """Each kind of broken file gives one line on stderr, exit code 1, and no output file."""
    if text is not None:
        Path("bad.off").write_text(text)
    answer = run("geodesic", "bad.off")
    assert answer.exit_code == 1
    assert answer.stdout == ""
    assert len(answer.stderr.strip().splitlines()) == 1
    for word in words:
        assert word in answer.stderr
    assert {p.name for p in folder.iterdir()} <= {"bad.off"}


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--source", "12"], 2, "source 12 is not a vertex"),
        (["--source", "-1"], 2, "source -1"),
        (["--source", "top"], 2, "'top' is no source"),
        (["--time", "soon"], 2, "time step"),
        (["--time", "-1"], 2, "positive"),
        (["-o", "nowhere/a.vtk"], 1, "no folder nowhere"),
        (["-o", "a.xyz"], 2, "'.xyz'"),
        (["-o", "ball.off"], 2, "'.off'"),
        (["--png", "a.jpg"], 2, "'.jpg'"),
        (["--png", "a.png", "--no-png"], 2, "exclude"),
        (["--sauce", "3"], 2, "No such option"),
    ],
)
def test_bad_arguments(arguments: list[str], code: int, words: str, folder: Path) -> None:
    """Wrong arguments are refused before any file is written."""
    save_off(icosphere(0))
    answer = run("geodesic", "ball.off", *arguments)
    assert answer.exit_code == code
    assert words in answer.stderr
    assert [p.name for p in folder.iterdir()] == ["ball.off"]


LONG = "a" * 300


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (f"info {LONG}.off", "cannot be read"),
        (f"geodesic ball.off --pairs {LONG} -o D.csv", "cannot be read"),
        (f"geodesic ball.off --source @{LONG} -o a.vtk", "cannot be read"),
        (f"geodesic ball.off --mask {LONG}.ply:a -o a.vtk", "no such file"),
        (f"fluid ball.off --restart {LONG}.restart.npz", "cannot be read"),
        (f"geodesic ball.off -o {LONG}.vtk", "cannot write"),
        ("advect ball.off --field ..:v", "a folder"),
        ("advect ball.off --color ..:v", "a folder"),
        ("geodesic ball.off --mask . -o a.vtk", "a folder"),
        ("geodesic . -o a.vtk", "a folder"),
        ("geodesic ball.off --source @. -o a.vtk", "a folder"),
    ],
)
def test_files_that_cannot_be_read_or_written(line: str, words: str, folder: Path) -> None:
    """Names that are too long and folders are refused as inputs or outputs, before any file is written."""
    save_off(icosphere(0))
    answer = run(*line.split())
    assert answer.exit_code in (1, 2)
    assert words in answer.stderr
    assert ("write" in words) == ("cannot write" in answer.stderr)
    assert [p.name for p in folder.iterdir()] == ["ball.off"]


def test_failure_keeps_what_was_there() -> None:
    """A run that fails keeps an older result."""
    save_off(icosphere(0))
    Path("a.vtk").write_text("older")
    assert run("geodesic", "ball.off", "--source", "99", "-o", "a.vtk").exit_code == 2
    assert Path("a.vtk").read_text() == "older"


def test_input_is_never_overwritten() -> None:
    """A mesh is not overwritten, under any of its names."""
    write(MeshResult(icosphere(1)), "ball.ply")
    os.symlink("ball.ply", "link.ply")
    before = Path("ball.ply").read_bytes()
    for target in ("ball.ply", "link.ply", "./ball.ply"):
        answer = run("geodesic", "ball.ply", "-o", target)
        assert answer.exit_code == 1
        assert "input" in answer.stderr
    assert Path("ball.ply").read_bytes() == before


@pytest.mark.usefixtures("no_opengl")
def test_no_opengl_loses_no_data() -> None:
    """Without OpenGL the data are written, and one line names the missing package."""
    save_off(icosphere(1))
    answer = run("geodesic", "ball.off")
    assert answer.exit_code == 1
    assert Path("ball.geodesic.vtk").exists()
    assert not Path("ball.geodesic.png").exists()
    assert len(answer.stderr.strip().splitlines()) == 1
    for word in ("libegl1", "ball.geodesic.vtk is written", "--no-png"):
        assert word in answer.stderr


@pytest.mark.parametrize(
    ("spec", "words"),
    [("none.vtp:wind", "none.vtp"), ("wind.vtp:gale", "gale"), ("wind.vtp:scalar", "not a vector field")],
)
def test_helmholtz_refusals(spec: str, words: str) -> None:
    """A missing file, a missing array and a scalar array give different messages."""
    ball = icosphere(1)
    save_off(ball)
    fields = [Field("wind", "face", ball.face_normals), Field("scalar", "vertex", ball.vertices[:, 0])]
    write(MeshResult(ball, fields), "wind.vtp")
    answer = run("helmholtz", "ball.off", "--field", spec)
    assert answer.exit_code == 1
    assert words in answer.stderr
