"""The process that draws for commands: deaths, errors, commands without pictures, standard streams."""

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import ArgumentError, FieldError
from geomhw.mesh.primitives import icosphere
from geomhw.render.layers import Panel, Surface
from geomhw.render.look import Look
from geomhw.render.panels import draw, drawn_by, save_vector
from geomhw_cli import main
from geomhw_cli.runtime import renderer
from support.pictures import needs_opengl
from support.program import contents, files, one_line, run, save_off

BALL = icosphere(1)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Iterator[Path]:
    """Each test has its own working folder with a small sphere in it, and leaves no process behind."""
    save_off(BALL)
    yield folder
    renderer.end()


def test_process_that_dies(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that dies loses no data, and one line says how it ended."""
    start = renderer.Renderer.__init__

    def dying(self: renderer.Renderer) -> None:
        start(self)
        os.kill(self._process.pid, signal.SIGKILL)

    monkeypatch.setattr(renderer.Renderer, "__init__", dying)
    answer = run("geodesic", "ball.off", "-o", "a.vtk", "--png", "a.png")
    one_line(answer, "process that draws", "SIGKILL", "memory", "a.vtk is written", "--no-png")
    assert files(folder) == ["a.vtk", "ball.off"]


def test_process_that_does_not_start(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no process can be started, one line says so before the computation."""
    monkeypatch.setattr(sys, "executable", "/none/python")
    one_line(run("geodesic", "ball.off", "-o", "a.vtk", "--png", "a.png"), "cannot draw", "process", "No such file")
    assert files(folder) == ["ball.off"]


def test_errors() -> None:
    """Errors of the library arrive as they are, and the process goes on."""
    with drawn_by(renderer.started().opened):
        with pytest.raises(FieldError, match="do not fit 42 rows"):
            draw(BALL, [Panel(surface=Surface(np.zeros(7)))], look=Look(width=120))
        with pytest.raises(TypeError) as caught:
            draw(BALL, [Panel(surface=Surface(BALL.vertices[:, 0], isolines="many"))], look=Look(width=120))  # type: ignore[arg-type]
    assert "Traceback" in str(caught.value.__cause__)
    assert "panels.py" in str(caught.value.__cause__)


def test_remedies() -> None:
    """What an error names as its remedy arrives, too."""
    error = pickle.loads(pickle.dumps(ArgumentError("take robust=True", "robust=True")))
    assert (str(error), error.remedy) == ("take robust=True", "robust=True")


@needs_opengl
def test_pictures() -> None:
    """Pictures, their texts and their films are those of this process."""
    panels = [Panel("height", Surface(BALL.vertices[:, 1], label="height", isolines=5))]
    here = draw(BALL, panels, look=Look(width=120))
    with drawn_by(renderer.started().opened):
        there = draw(BALL, panels, look=Look(width=120))
    assert np.array_equal(here, there)
    for name, picture in (("here.svg", here), ("there.svg", there)):
        save_vector(Path(name), picture)
    assert Path("here.svg").read_bytes() == Path("there.svg").read_bytes()


@pytest.mark.parametrize(
    "command",
    [
        "geodesic ball.off -q -o a.vtk",
        "geodesic ball.off -q --no-png",
        "geodesic ball.off -q --all-pairs -o D.npy",
        "geodesic ball.off -q -o a.vtk --html a.html",
        "geodesic ball.off --estimate",
        "vecdiffuse ball.off -q --no-png",
        "advect ball.off -q --steps 2 --every 1 -o a.pvd --html a.html",
        "fluid ball.off -q --steps 2 --every 1 --no-png",
        "view ball.off -q -o a.html",
        "info ball.off -q",
    ],
)
def test_no_picture(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """No process is started where no picture is drawn."""
    monkeypatch.setattr(renderer, "Renderer", None)
    main._start_renderer(command.split())
    assert run(*command.split()).exit_code == 0


@pytest.mark.parametrize(
    ("command", "early"),
    [
        ("geodesic a.off --png a.png", True),
        ("fluid a.off --gif=a.gif", True),
        ("geodesic a.off -o a.vtk", False),
        ("batch geodesic a.off --out b -- --png {out}/a.png", False),
        ("geodesic --png a.png --help", False),
    ],
)
def test_early_start(command: str, early: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The process starts before the command is loaded if options ask for a picture."""
    started: list[bool] = []
    monkeypatch.setattr(renderer, "started", lambda: started.append(True))
    main._start_renderer(command.split())
    assert bool(started) == early


@needs_opengl
def test_standard_streams(folder: Path) -> None:
    """The mesh comes from standard input and the result goes to standard output, with a picture as without one."""
    words = ["geodesic", "-", "--format", "off", "-o", "-", "--output-format", "vtk", "--source", "0", "-q"]
    outputs = [
        subprocess.run(
            [sys.executable, "-m", "geomhw_cli", *words, *more],
            input=Path("ball.off").read_bytes(),
            capture_output=True,
            check=True,
        )
        for more in (["--png", "a.png"], ["--no-png"])
    ]
    assert outputs[0].stdout == outputs[1].stdout
    assert outputs[0].stderr == b""
    assert Path("a.png").stat().st_size
    assert not [name for name in contents(folder) if name.startswith(".")]
