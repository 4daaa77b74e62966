"""Signals at moments that are hard to hit: while the program loads, in compiled code, and at the end."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from geomhw.mesh.primitives import icosphere
from geomhw.render import panels
from support.pictures import needs_opengl
from support.program import contents, run, save_off

PICTURE = ["geodesic", "ball.off", "-q", "-o", "a.vtk", "--png", "a.png"]
MATRIX = ["geodesic", "ball.off", "--all-pairs", "-o", "D.npy"]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(icosphere(1))
    return folder


def answer_of(script: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run a script that ends in the program."""
    return subprocess.run([sys.executable, "-c", script, *arguments], capture_output=True, text=True)


def test_loading() -> None:
    """The program is loaded after its signals are handled, not while its entry point is imported."""
    script = "import sys; from geomhw_cli.main import main; sys.exit('geomhw_cli.program' in sys.modules)"
    assert answer_of(script).returncode == 0


COMPILED = """
import signal
from geomhw.geodesic.heat_method import HeatDistance
from geomhw_cli.main import main

def rows(self, sets):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt as stop:
        raise {error}("a compiled loop returned a result with an exception set") from stop

HeatDistance.rows = rows
main()
"""


@pytest.mark.parametrize("error", ["SystemError", "RuntimeError"])
def test_compiled_code(error: str, folder: Path) -> None:
    """An interrupt that compiled code or the import of a class turned into another error is still one."""
    before = contents(folder)
    answer = answer_of(COMPILED.replace("{error}", error), *MATRIX)
    assert (answer.returncode, answer.stderr.strip()) == (130, "Error: interrupted")
    assert contents(folder) == before


SWALLOWED = """
import signal
from geomhw.geodesic.heat_method import HeatDistance
from geomhw_cli.main import main

computed, signals = HeatDistance.rows, [signal.SIGINT]

def rows(self, sets):
    try:
        while signals:
            signal.raise_signal(signals.pop())
    except KeyboardInterrupt:
        pass
    return computed(self, sets)

HeatDistance.rows = rows
main()
"""


def test_a_signal_that_a_library_swallows() -> None:
    """The run ends as if the signal came at the end, and says so."""
    answer = answer_of(SWALLOWED, *MATRIX, "-q")
    assert answer.returncode == 130
    assert "Error: interrupted when all was done" in answer.stderr, answer.stderr
    assert Path("D.npy").exists()


IN_A_FINALIZER = """
import signal, time
from geomhw.geodesic.heat_method import HeatDistance
from geomhw_cli.main import main

class Last:
    def __del__(self):
        signal.raise_signal(signal.SIGTERM)
        print("unreached")

def rows(self, sets):
    Last()
    time.sleep(10)

HeatDistance.rows = rows
main()
"""


def test_a_signal_in_a_finalizer() -> None:
    """Python ignores errors there; the signal comes again, and ends the run without a traceback."""
    answer = answer_of(IN_A_FINALIZER, *MATRIX, "-q")
    assert (answer.returncode, answer.stdout) == (128 + signal.SIGTERM, "")
    assert answer.stderr.strip().startswith("Error: interrupted")
    assert "all was done" not in answer.stderr
    assert not Path("D.npy").exists()


HALF_BUILT = """
import os, signal
from geomhw.geodesic.heat_method import HeatDistance
from geomhw_cli.main import main

class HalfBuilt:
    def __init__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        self.whole = True

    def __del__(self):
        print(self.whole)

HeatDistance.rows = lambda self, sets: HalfBuilt()
main()
"""


def test_the_finalizer_of_an_object_that_a_signal_left_incomplete() -> None:
    """Its error is not printed."""
    answer = answer_of(HALF_BUILT, *MATRIX, "-q")
    assert (answer.returncode, answer.stdout) == (128 + signal.SIGTERM, "")
    assert "AttributeError" not in answer.stderr


IN_THE_IMPORT_SYSTEM = """
import functools, signal, sys, time, types
import importlib._bootstrap as bootstrap
from geomhw.geodesic.heat_method import HeatDistance
from geomhw_cli.main import main

def rows(self, sets):
    locks, released = bootstrap._imp, []
    interrupted = functools.partial(signal.raise_signal, signal.SIGTERM)
    bootstrap._imp = types.SimpleNamespace(acquire_lock=interrupted, release_lock=lambda: released.append(True))
    try:
        bootstrap._get_module_lock("geomhw")
    finally:
        bootstrap._imp = locks
        print("released" if released else "kept")
    time.sleep(10)

HeatDistance.rows = rows
main()
"""


def test_a_signal_in_the_import_system() -> None:
    """The import system releases its lock before the signal ends the run; else other threads would wait forever."""
    answer = answer_of(IN_THE_IMPORT_SYSTEM, *MATRIX, "-q")
    assert (answer.returncode, answer.stdout.strip()) == (128 + signal.SIGTERM, "released")
    assert answer.stderr.strip() == "Error: interrupted"


AT_THE_END = """
import atexit, signal, sys
atexit.register(lambda: signal.raise_signal(signal.SIGTERM))
from geomhw_cli.main import main
main()
"""


def test_at_the_end() -> None:
    """A signal while the interpreter ends gives its exit code and no traceback; the files are there."""
    answer = answer_of(AT_THE_END, *MATRIX, "-q")
    assert (answer.returncode, answer.stderr) == (128 + signal.SIGTERM, "")
    assert Path("D.npy").exists()


DRAWING = """
import os, signal, threading
from geomhw_cli.main import main
from geomhw_cli.runtime.renderer import Renderer

ask = Renderer._answer

def asked(self, request):
    print(self._process.pid, flush=True)
    threading.Timer(0.1, os.kill, [os.getpid(), signal.{signal}]).start()
    return ask(self, request)

signal.signal(signal.SIGHUP, signal.SIG_DFL)
Renderer._answer = asked
main()
"""


def is_there(process: int) -> bool:
    """Whether a process runs."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@needs_opengl
@pytest.mark.parametrize(
    "command",
    ["geodesic ball.off -q -o a.vtk --png a.png", "advect ball.off -q --steps 2 --every 1 -o a.pvd --gif a.gif"],
)
def test_drawing(command: str) -> None:
    """A signal while a picture is drawn ends the run and the process that draws."""
    answer = answer_of(DRAWING.replace("{signal}", "SIGHUP"), *command.split())
    assert answer.returncode == 128 + signal.SIGHUP, answer.stderr
    assert "is written, a." in answer.stderr
    assert not Path(command.split()[-1]).exists()
    assert not is_there(int(answer.stdout.split()[0]))


def test_a_killed_run() -> None:
    """The process that draws ends by itself after a run that cannot end it."""
    answer = answer_of(DRAWING.replace("{signal}", "SIGKILL"), *PICTURE)
    assert answer.returncode == -signal.SIGKILL
    limit = time.monotonic() + 30
    while is_there(int(answer.stdout)) and time.monotonic() < limit:
        time.sleep(0.1)
    assert not is_there(int(answer.stdout))


CTRL_C = """
import os, signal, time
from geomhw_cli.main import main
from geomhw_cli.runtime.renderer import Renderer

start = Renderer.__init__

def started(self):
    start(self)
    time.sleep(0.6)  # the process loads
    os.killpg(0, signal.SIGINT)

Renderer.__init__ = started
main()
"""


def test_ctrl_c() -> None:
    """Ctrl-C reaches the process that draws, too, which leaves it to the run."""
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", CTRL_C, *PICTURE]
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True) as process:
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (128 + signal.SIGINT, "")
    assert err.strip() == "Error: interrupted"


@needs_opengl
@pytest.mark.parametrize(
    "command",
    [
        "geodesic ball.off -q -o a.vtk --png a.png --svg a.svg",
        "advect ball.off -q --steps 2 --every 1 -o a.pvd --gif a.gif --svg a.svg",
    ],
)
def test_pictures_of_a_run(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt between two pictures replaces none of them."""

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(panels, "save_vector", stopped)
    first, second = (word for word in command.split() if word.endswith((".png", ".gif", ".svg")))
    for name in (first, second):
        Path(name).write_text("old")
    answer = run(*command.split())
    assert answer.exit_code == 130
    assert f"{first}, {second} is not" in answer.stderr or f"{second}, {first} is not" in answer.stderr
    assert (Path(first).read_text(errors="replace"), Path(second).read_text()) == ("old", "old")
    assert not [name for name in contents(folder) if name.startswith(".")]
