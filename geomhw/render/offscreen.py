"""Check for offscreen OpenGL before VTK opens a window.

VTK crashes the process if there is no OpenGL. This check loads libEGL and initializes a display on the first device, as
VTK does, in milliseconds.
"""

import ctypes
import os
import sys

from geomhw.errors import RenderError

#: How to install software OpenGL on a machine without a display.
INSTALL_HINT = "on Debian or Ubuntu: apt install libegl1 libgl1-mesa-dri"

_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_EGL_WINDOW = "vtkEGLRenderWindow"
_EGL_PLATFORM_DEVICE_EXT = 0x313F


def load() -> None:
    """Load the libraries that draw, which takes a second."""
    import scipy.spatial  # noqa: F401
    from PIL import Image, ImageDraw, ImageFont  # noqa: F401
    from pyvista import Plotter  # noqa: F401  # at whose first use most of pyvista is loaded


def prepare() -> None:
    """Select VTK's window class for drawing off screen; raise RenderError if there is no OpenGL.

    Call it before the first window opens. A window class set in the environment is kept.
    """
    os.environ.setdefault("VTK_FORCE_MSAA", "1")  # VTK does not multisample with Mesa otherwise
    chosen = os.environ.get(_WINDOW)
    if not sys.platform.startswith("linux") or (chosen and chosen != _EGL_WINDOW):
        return
    missing = missing_opengl()
    if missing is None:
        os.environ[_WINDOW] = _EGL_WINDOW
    elif chosen or not has_display():
        raise RenderError(f"cannot draw: {missing}; {INSTALL_HINT}")


def missing_opengl() -> str | None:
    """Return why EGL cannot draw on this machine, or None if it can."""
    # Keeps Mesa from reporting a missing driver on stderr: the error message does.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return "there is no OpenGL library (libEGL.so.1) on this machine"
    if not _egl_works(egl):
        return "libEGL.so.1 finds no OpenGL driver on this machine"
    return None


def has_display() -> bool:
    """Return whether an X server answers; DISPLAY may name one that is not running."""
    try:
        x11 = ctypes.CDLL("libX11.so.6")
        ctypes.CDLL("libGL.so.1")
    except OSError:
        return False
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XOpenDisplay.argtypes = [ctypes.c_char_p]
    x11.XCloseDisplay.argtypes = [ctypes.c_void_p]
    display = x11.XOpenDisplay(None)
    if display:
        x11.XCloseDisplay(display)
    return bool(display)


def _egl_works(egl: ctypes.CDLL) -> bool:
    """Return whether the display of EGL's first device initializes, the one VTK uses [EGL_EXT_platform_device]."""
    pointer = ctypes.c_void_p
    egl.eglGetProcAddress.restype = pointer
    egl.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    egl.eglInitialize.argtypes = [pointer, pointer, pointer]
    egl.eglTerminate.argtypes = [pointer]
    query = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    get_display = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not query or not get_display:
        return False
    devices, count = (pointer * 1)(), ctypes.c_int(0)
    prototype = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, pointer * 1, ctypes.POINTER(ctypes.c_int))
    if not prototype(query)(1, devices, ctypes.byref(count)) or count.value < 1:
        return False
    display = ctypes.CFUNCTYPE(pointer, ctypes.c_uint, pointer, pointer)(get_display)(
        _EGL_PLATFORM_DEVICE_EXT, devices[0], None
    )
    if not display or not egl.eglInitialize(display, None, None):
        return False
    egl.eglTerminate(display)
    return True
