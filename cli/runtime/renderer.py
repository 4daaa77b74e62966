"""A process that draws the pictures of a command: it loads pyvista while the command computes.

Threads do not help, since imports hold Python's lock. Drawings are pickled on the pipe to the process, and pictures on
the pipe from it. It neither reads standard input nor writes standard output, and ends with the command.
"""

import atexit
import gc
import os
import pickle
import signal
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from geomhw.errors import GeomhwError, RenderError
from geomhw_cli.runtime.interrupts import SIGNALS
from geomhw_cli.runtime.memory import DRAWING, require_memory

if TYPE_CHECKING:
    from geomhw.render.layers import Panel
    from geomhw.render.panels import Picture

_PROGRAM = "import sys; sys.path[:] = {path}; from geomhw_cli.runtime.renderer import serve; serve()"
#: Seconds that a process takes to end, at most.
SECONDS = 5
_PROTOCOL = 5  # arrays go to the pipe without a copy


class Renderer:
    """A process that draws; `opened` stands for `geomhw.render.panels.Drawing`."""

    def __init__(self) -> None:
        command = [sys.executable, "-c", _PROGRAM.format(path=[str(folder) for folder in sys.path])]
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        except OSError as error:
            raise RenderError(f"cannot draw: no process can be started: {error.strerror}") from error

    def end(self) -> None:
        """End the process, which keeps nothing."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):  # bytes that the process did not take
                if pipe:
                    pipe.close()

    @contextmanager
    def opened(self, *arguments: Any, **options: Any) -> "Iterator[Callable[[Sequence[Panel]], Picture]]":
        """Open a drawing for pictures of its panels; the arguments are those of `Drawing`."""
        opening: tuple[Any, Any] | None = arguments, options

        def drawn(panels: "Sequence[Panel]") -> "Picture":
            nonlocal opening
            request, opening = (opening, panels), None
            return self._answer(request)

        yield drawn

    def _answer(self, request: Any) -> Any:
        """Send a request and return the answer, or raise the error that it is."""
        assert self._process.stdin
        assert self._process.stdout
        try:
            pickle.dump(request, self._process.stdin, _PROTOCOL)
            self._process.stdin.flush()
            answer, text = pickle.load(self._process.stdout)  # of our own making
        except (EOFError, OSError, pickle.UnpicklingError):
            raise RenderError(f"cannot draw: the process that draws {self._ending()}") from None
        if isinstance(answer, Exception):
            raise answer from (None if isinstance(answer, GeomhwError) else RuntimeError(text))
        return answer

    def _ending(self) -> str:
        """How the process ended."""
        try:
            code = self._process.wait(SECONDS)
        except subprocess.TimeoutExpired:
            return "gave an answer that cannot be read"
        if code >= 0:
            return f"has ended with exit code {code}"
        name = signal.Signals(-code).name
        return f"was stopped by {name}" + (", perhaps for lack of memory" if name == "SIGKILL" else "")


_running: list[Renderer] = []


def started() -> Renderer:
    """Start the process that draws, or return the one that runs."""
    if not _running:
        require_memory(DRAWING, "drawing")
        atexit.register(end)
        with _blocked_signals():
            _running.append(Renderer())
    return _running[0]


def end() -> None:
    """End the process that draws, if there is one."""
    while _running:
        _running.pop().end()


@contextmanager
def _blocked_signals() -> Iterator[None]:
    """Block the signals that end a run, for a process started within the block: its parent decides for it."""
    if not hasattr(signal, "pthread_sigmask"):  # on Windows
        yield
        return
    former = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, former)


def serve() -> None:
    """Draw what standard input asks for, and answer on standard output, until standard input ends."""
    requests, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)  # messages of libraries
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
    gc.disable()  # which takes a tenth of the time to load
    with suppress(Exception):  # it comes again when a picture is asked for
        import geomhw.render.panels  # noqa: F401
        from geomhw.render.offscreen import load

        load()
    gc.freeze()
    gc.enable()
    drawing: Any = None
    while True:
        try:
            opening, panels = pickle.load(requests)
        except EOFError:
            os._exit(0)
        try:
            if opening:
                from geomhw.render.panels import Drawing

                if drawing:
                    drawing.__exit__()
                arguments, options = opening
                drawing = Drawing(*arguments, **options)
            answer = drawing(panels), ""
        except Exception as error:
            answer = error, traceback.format_exc()
        pickle.dump(answer, answers, _PROTOCOL)
        answers.flush()
