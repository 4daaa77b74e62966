"""Entry point of the ``geomhw`` program: handles signals from the first line on, then loads and runs the program."""

import io
import os
import sys

from geomhw_cli.runtime import interrupts

TYPE_CHECKING = False  # typing takes a while to load, in which a signal would end in a traceback
if TYPE_CHECKING:
    from typing import Any, NoReturn


def main() -> "NoReturn":
    """Run the program and end the process.

    After an interrupt the process ends without the interpreter's clean-up, which may crash in a thread that is loading
    or drawing.
    """
    try:
        interrupts.install()
        _open_standard_streams()
        with interrupts.restored():
            from geomhw_cli.program import run

            code = run()
        interrupts.end_at_once()
        if interrupts.arrived and not code:
            print("Error: interrupted when all was done", file=sys.stderr)
    except KeyboardInterrupt as stop:
        print(f"Error: interrupted{f'; {stop}' if str(stop) else ''}", file=sys.stderr)
        code = interrupts.exit_code()
    if interrupts.arrived:  # also a signal that a library swallowed
        code = interrupts.exit_code()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)
    sys.exit(code)


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
