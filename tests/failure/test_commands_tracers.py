"""``--tracers`` refuses wrong counts, non-manifold meshes and changed restarts."""

from pathlib import Path

import pytest

from geomhw.io import read, write
from support.flow_files import BALL, SHORT, both, spoiled_inputs
from support.program import contents, files, one_line, run, save_off

TRACED = ("--tracers", "44")


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(BALL)
    return folder


@pytest.mark.parametrize(("first", "then"), [([], TRACED), (TRACED, ["--tracers", "45"])])
def test_restart_with_other_tracers(first: list[str], then: list[str], folder: Path) -> None:
    """A restart with a different number of tracers is refused."""
    run("fluid", "ball.off", "-o", "ball.fluid.pvd", *SHORT, *first, "-q")
    before = contents(folder)
    one_line(run("fluid", "ball.off", *SHORT, *then, "--restart", "ball.fluid.restart.npz"), "tracers = ", "start anew")
    assert contents(folder) == before


@both
@pytest.mark.parametrize("count", ["0", "-3", "2.5", "many", "10000001"])
def test_no_number(command: str, count: str, folder: Path) -> None:
    """A count that is no positive whole number gives exit code 2, and no file is written."""
    answer = run(command, "ball.off", "--tracers", count)
    assert answer.exit_code == 2
    last = answer.stderr.strip().splitlines()[-1]
    assert "--tracers" in last
    assert count in last
    assert files(folder) == ["ball.off"]


def test_manifolds_only(folder: Path) -> None:
    """Tracers need a manifold; color alone does not."""
    spoiled_inputs()
    before = files(folder)
    one_line(run("advect", "fan.off", *SHORT, *TRACED), "tracers", "3 faces meet at edge 0-1")
    assert files(folder) == before
    assert run("advect", "moebius.off", *SHORT, *TRACED, "--no-png", "-q").exit_code == 0


def test_tracers_read_from_are_not_written_over(folder: Path) -> None:
    """A mesh with the name of a future tracer file is not overwritten."""
    (folder / "ball.off").rename(folder / "flow.tracers.00000.off")
    write(read("flow.tracers.00000.off"), "flow.tracers.00000.vtp")
    before = contents(folder)
    one_line(run("fluid", "flow.tracers.00000.vtp", *SHORT, *TRACED, "-o", "flow.pvd"), "flow.pvd", "input")
    assert contents(folder) == before
