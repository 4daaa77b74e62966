"""Hypothesis profiles, and the fixtures that all tests share: each mesh of the zoo, an empty working folder."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

from geomhw.mesh.triangle_mesh import TriangleMesh

pytest.register_assert_rewrite("support", "fuzz")
from support.meshes import CLOSED, ZOO, zoo_mesh  # noqa: E402 - after its asserts are registered

# Examples are the same in each run; HYPOTHESIS_PROFILE=long searches for new ones.
settings.register_profile("ci", derandomize=True, database=None, deadline=None, max_examples=25)
settings.register_profile("long", derandomize=False, database=None, deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# Background processes of a shell inherit ignored interrupts; some tests interrupt themselves.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(params=ZOO)
def mesh(request: pytest.FixtureRequest) -> TriangleMesh:
    """Each mesh of the zoo in turn."""
    return zoo_mesh(request.param)


@pytest.fixture(params=CLOSED)
def closed_mesh(request: pytest.FixtureRequest) -> tuple[TriangleMesh, int]:
    """Each closed connected mesh with its genus."""
    return zoo_mesh(request.param), CLOSED[request.param]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder of this test's own, as the working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def no_opengl(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hide OpenGL and displays from this process and from those that it starts."""
    from geomhw.render import offscreen

    monkeypatch.setattr(offscreen, "missing_opengl", lambda: "there is no OpenGL library (libEGL.so.1)")
    monkeypatch.setattr(offscreen, "has_display", lambda: False)
    for name in ("VTK_DEFAULT_OPENGL_WINDOW", "DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    folder = tmp_path_factory.mktemp("libraries")
    (folder / "libEGL.so.1").touch()  # an empty file is no library
    monkeypatch.setenv("LD_LIBRARY_PATH", str(folder))
