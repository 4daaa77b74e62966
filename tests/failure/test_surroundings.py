"""What surrounds a run: environment variables of notebooks, closed streams, limits on memory, pipes that end."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from geomhw.mesh.primitives import icosphere
from support.messages import missing
from support.pictures import needs_opengl
from support.program import save_off

pytestmark = pytest.mark.skipif(os.name == "nt", reason="made of a POSIX shell's tools")


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(icosphere(1))
    return folder


def shell(script: str) -> "subprocess.CompletedProcess[str]":
    """Run a script in bash, where ``geomhw`` is the program."""
    program = f'geomhw() {{ "{sys.executable}" -m geomhw_cli "$@"; }}; {script}'
    return subprocess.run(["bash", "-c", program], capture_output=True, text=True)


@needs_opengl
def test_backend_of_a_notebook() -> None:
    """MPLBACKEND as Jupyter sets it does not reach the pictures."""
    answer = shell(
        "MPLBACKEND=module://matplotlib_inline.backend_inline geomhw geodesic ball.off -q -o a.vtp --png a.png"
    )
    assert (answer.returncode, answer.stderr) == (0, "")
    assert Path("a.png").exists()


@pytest.mark.parametrize("closed", ["2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    ("command", "output"),
    [
        ("advect ball.off --steps 2 --every 1 -o s.pvd", "s.00002.vtp"),
        ("fluid ball.off --steps 2 --every 1 -o f.pvd", "f.00002.vtp"),
        ("geodesic ball.off --all-pairs -o D.npy", "D.npy"),
    ],
)
def test_closed_streams(command: str, output: str, closed: str) -> None:
    """Closed standard streams lose no output."""
    assert shell(f"geomhw {command} {closed}").returncode == 0
    assert Path(output).stat().st_size


def test_reader_that_ends() -> None:
    """``compare`` into a pipe that is not read fails, and does not say that files differ."""
    assert shell("geomhw compare ball.off ball.off | true; exit ${PIPESTATUS[0]}").returncode in (0, 2)


def test_full_output_of_a_check() -> None:
    assert shell("geomhw info --check ball.off >/dev/full").returncode == 2


@pytest.mark.parametrize(("kilobytes", "png"), [(300_000, ""), (600_000, "--png a.png")])
def test_limit_on_memory(kilobytes: int, png: str) -> None:
    """A limit below what the program or the drawing takes gives one line about memory."""
    answer = shell(f"ulimit -v {kilobytes}; geomhw geodesic ball.off -o a.vtp {png}")
    assert answer.returncode == 1
    (line,) = answer.stderr.strip().splitlines()
    assert not missing(line, "Error: ... not enough memory ... ulimit -v")


@pytest.mark.parametrize("redirection", ["2>/dev/full", ">/dev/full 2>/dev/full"])
@pytest.mark.parametrize(
    ("command", "code"),
    [("compare ball.off no.off", 2), ("info --check no.off", 2), ("info --unknown", 2), ("info no.off", 1)],
)
def test_full_standard_error(command: str, code: int, redirection: str) -> None:
    """A message that cannot be written changes no exit code."""
    assert shell(f"geomhw {command} {redirection}").returncode == code


def test_log_that_cannot_be_written() -> None:
    """A run whose log cannot be written writes its output."""
    assert shell("geomhw geodesic ball.off -v --no-png -o a.vtp 2>/dev/full").returncode == 0
    assert Path("a.vtp").stat().st_size


@pytest.mark.parametrize(
    "command", ["geodesic ball.off --no-png -o a.vtp", "repair ball.off -o r.ply", "info ball.off"]
)
def test_quiet_json(command: str) -> None:
    answer = shell(f"geomhw {command} -q --json")
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
