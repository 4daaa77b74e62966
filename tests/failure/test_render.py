"""Pictures refuse values that do not fit, and machines without OpenGL."""

import ctypes
import os

import numpy as np
import pytest

from geomhw.errors import FieldError, RenderError
from geomhw.mesh import primitives
from geomhw.render import offscreen
from geomhw.render.layers import Panel, Surface
from geomhw.render.panels import draw

BALL = primitives.icosphere(3)


@pytest.mark.parametrize("values", [np.zeros(7), np.zeros((642, 2)), np.zeros((642, 3, 1))])
def test_values_that_do_not_fit(values):
    """Values of a wrong shape raise."""
    with pytest.raises(FieldError, match="do not fit 642 rows"):
        draw(BALL, [Panel(surface=Surface(values))])


def test_isolines_need_numbers_at_vertices():
    """Isolines of face values raise."""
    with pytest.raises(FieldError, match="isolines"):
        draw(BALL, [Panel(surface=Surface(np.zeros(1280), "face", isolines=3))])


def _no_library(*_):
    raise OSError


@pytest.fixture
def headless_linux(monkeypatch):
    monkeypatch.setattr(offscreen.sys, "platform", "linux")
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)
    monkeypatch.delenv("DISPLAY", raising=False)


def test_no_library_is_one_sentence(monkeypatch, headless_linux):
    """Without an OpenGL library the error names the packages, before VTK would crash."""
    monkeypatch.setattr(ctypes, "CDLL", _no_library)
    with pytest.raises(RenderError, match=r"no OpenGL library.*apt install libegl1 libgl1-mesa-dri$"):
        draw(BALL, [Panel()])


def test_no_driver_is_one_sentence(monkeypatch, headless_linux):
    """Without an OpenGL driver a RenderError is raised."""
    monkeypatch.setattr(offscreen, "missing_opengl", lambda: "libEGL.so.1 finds no OpenGL driver on this machine")
    monkeypatch.setattr(offscreen, "has_display", lambda: False)
    with pytest.raises(RenderError, match="no OpenGL driver"):
        offscreen.prepare()


def test_display_serves_where_egl_does_not(monkeypatch, headless_linux):
    """A display is used where EGL has no driver."""
    monkeypatch.setattr(offscreen, "missing_opengl", lambda: "no EGL")
    monkeypatch.setattr(offscreen, "has_display", lambda: True)
    offscreen.prepare()
    assert "VTK_DEFAULT_OPENGL_WINDOW" not in os.environ


def test_choice_of_window_is_respected(monkeypatch):
    """A window class chosen by the user is kept."""
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    monkeypatch.setattr(offscreen, "missing_opengl", _no_library)
    offscreen.prepare()
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == "vtkOSOpenGLRenderWindow"
