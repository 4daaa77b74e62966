"""Entry point of the ``geomhw`` program: handles signals from the first line on, then loads and runs the program."""

import io
import os
import sys

from geomhw_cli.runtime import interrupts
from geomhw_cli.runtime.picture_kinds import FILMS, KINDS

#: Environment variables from which linear algebra libraries read their number of threads when they are loaded.
BLAS_THREADS = [f"{name}_NUM_THREADS" for name in ("OPENBLAS", "MKL", "BLIS", "OMP")] + ["VECLIB_MAXIMUM_THREADS"]
#: Options that ask for a picture or a film.
PICTURES = {f"--{kind}" for kind in (*KINDS, *FILMS)}
#: Words with which they do not, or not in this process.
DRAWING_NOTHING = {"batch", "--estimate", "-h", "--help"}
TYPE_CHECKING = False  # typing takes a while to load, in which a signal would end in a traceback
if TYPE_CHECKING:
    from typing import Any, NoReturn


def main() -> "NoReturn":
    """Run the program and end the process.

    After an interrupt the process ends without the interpreter's clean-up, which may crash in a working thread.
    """
    try:
        interrupts.install()
        _open_standard_streams()
        # With several BLAS threads, the order of sums and so the last digits depend on the number of cores.
        os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
        os.environ["MPLBACKEND"] = "agg"  # notebooks set one that is not installed here
        with interrupts.restored():
            _start_renderer(sys.argv[1:])
            from geomhw_cli.program import run

            code = run()
        interrupts.end_at_once()
        if interrupts.arrived and not code:
            print("Error: interrupted when all was done", file=sys.stderr)
    except KeyboardInterrupt as stop:
        print(f"Error: interrupted{f'; {stop}' if str(stop) else ''}", file=sys.stderr)
        code = interrupts.exit_code()
    if interrupts.arrived:  # also a signal that a library swallowed
        from geomhw_cli.runtime import renderer

        renderer.end()
        code = interrupts.exit_code()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)
    sys.exit(code)


def _start_renderer(words: "list[str]") -> None:
    """Start the process that draws, if options ask for pictures, before modules load that take a while."""
    options = {word.partition("=")[0] for word in words}
    if options & PICTURES and not options & DRAWING_NOTHING:
        from contextlib import suppress

        from geomhw.errors import GeomhwError
        from geomhw_cli.runtime import renderer

        with suppress(GeomhwError):  # it comes again in the command
            renderer.started()


def _open_standard_streams() -> None:
    """Open the null device in place of closed standard streams, whose numbers data files would take."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
            setattr(sys, name, os.fdopen(number, mode, closefd=False))
    if not sys.stderr.isatty():
        stream = io.BufferedWriter(_Messages(2, "w", closefd=False))
        sys.stderr = io.TextIOWrapper(stream, sys.stderr.encoding, "backslashreplace", line_buffering=True)


class _Messages(io.FileIO):
    """Standard error; messages that it cannot take, as on a full disk, are lost and change no exit code."""

    def write(self, data: "Any") -> int:
        """Write bytes."""
        try:
            return super().write(data)
        except OSError:
            return len(data)


def __getattr__(name: str) -> "Any":
    """Names of `geomhw_cli.program`, loaded at first use."""
    if name.startswith("__"):  # the import system asks for __path__, before signals are handled
        raise AttributeError(name)
    from geomhw_cli import program

    return getattr(program, name)
