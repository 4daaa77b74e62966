"""Finding out, before VTK is asked for a window, whether this machine can draw without a display.

VTK crashes the process when it finds no OpenGL, so Python looks first: it loads libEGL and initializes a display on
the first device, which is what VTK does next. That takes milliseconds.
"""

import ctypes
import os
import sys

from geomhw.errors import RenderError

#: What brings software OpenGL to a machine without a display.
INSTALL_HINT = "on Debian or Ubuntu: apt install libegl1 libgl1-mesa-dri"

_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_EGL_WINDOW = "vtkEGLRenderWindow"
_EGL_PLATFORM_DEVICE_EXT = 0x313F


def prepare() -> None:
    """Choose VTK's window for drawing off screen; RenderError if there is no OpenGL to draw with.

    To be called before the first window opens. A window class chosen by the caller's environment is respected.
    """
    os.environ.setdefault("VTK_FORCE_MSAA", "1")  # else VTK takes no samples within pixels where Mesa draws
    chosen = os.environ.get(_WINDOW)
    if not sys.platform.startswith("linux") or (chosen and chosen != _EGL_WINDOW):
        return
    missing = missing_opengl()
    if missing is None:
        os.environ[_WINDOW] = _EGL_WINDOW
    elif chosen or not has_display():
        raise RenderError(f"cannot draw: {missing}; {INSTALL_HINT}")


def missing_opengl() -> str | None:
    """What keeps EGL from drawing here, in words, or None if nothing does."""
    # Mesa reports a driver it cannot find on stderr; we have our own sentence for that.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return "there is no OpenGL library (libEGL.so.1) on this machine"
    if not _egl_works(egl):
        return "libEGL.so.1 finds no OpenGL driver on this machine"
    return None


def has_display() -> bool:
    """Whether an X server answers: DISPLAY may well name one that is not there."""
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
    """Whether the display of EGL's first device initializes: VTK takes that one [EGL_EXT_platform_device]."""
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
