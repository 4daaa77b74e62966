"""``--engine petsc`` where petsc4py or mpi4py is missing, and options that the engine does not have."""

import sys
from pathlib import Path

import pytest

from geomhw.distributed import connect
from geomhw.errors import ArgumentError
from geomhw.io import write
from geomhw.mesh.primitives import icosphere
from geomhw.results import Result
from support.program import files, run


@pytest.fixture
def ball(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write(Result(icosphere(1)), "ball.ply")
    return tmp_path


@pytest.fixture
def without_petsc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "petsc4py", None)


@pytest.mark.usefixtures("without_petsc")
def test_library() -> None:
    """Connecting raises an error that says what to install."""
    with pytest.raises(ArgumentError, match=r"petsc4py.*apt install"):
        connect()


@pytest.mark.usefixtures("without_petsc")
def test_command(ball: Path) -> None:
    """The command fails in one line with exit code 2 and leaves no file."""
    answer = run("geodesic", "ball.ply", "--engine", "petsc", "-o", "a.pvtu")
    assert answer.exit_code == 2
    (line,) = answer.stderr.strip().splitlines()
    assert "--engine petsc" in line
    assert "python3-petsc4py" in line
    assert files(ball) == ["ball.ply"]


@pytest.mark.usefixtures("without_petsc")
def test_later_rank_is_silent(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the processes that mpirun starts, only the first prints an error."""
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "1")
    answer = run("geodesic", "ball.ply", "--engine", "petsc", "-o", "a.pvtu")
    assert answer.stderr == ""
    assert files(ball) == ["ball.ply"]


@pytest.mark.parametrize(
    "options",
    [["--robust"], ["--refine"], ["--solver", "direct"], ["--all-pairs"], ["--method", "exact"], ["--png", "a.png"]],
)
def test_options_of_the_embedded_engine(options: list[str], ball: Path) -> None:
    """An option that the engine does not have is refused."""
    answer = run("geodesic", "ball.ply", "--engine", "petsc", *options)
    assert answer.exit_code == 2
    assert options[0] in answer.stderr
    assert "--engine petsc" in answer.stderr
    assert files(ball) == ["ball.ply"]
