"""Signals that end a run: Ctrl-C, SIGTERM, SIGHUP. Each raises KeyboardInterrupt, once, and is remembered."""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

TYPE_CHECKING = False  # typing is not loaded before the signals are handled
if TYPE_CHECKING:
    from typing import Any

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
#: Signals that have arrived, the first of which decides the exit code.
arrived: list[int] = []
#: Seconds after which a signal comes again that fell where it cannot end the run.
AGAIN = 0.005


def install() -> None:
    """Raise KeyboardInterrupt at the signals."""
    sys.unraisablehook = _ignored
    for number in _handled():
        signal.signal(number, _interrupt)


def end_at_once() -> None:
    """Let the signals end the process from now on, when its work is done, without the interpreter's clean-up."""
    for number in _handled():
        signal.signal(number, lambda number, _: os._exit(128 + number))


def _handled() -> list[int]:
    """The signals that this process does not ignore."""
    return [number for number in SIGNALS if signal.getsignal(number) not in (signal.SIG_IGN, None)]


def exit_code() -> int:
    """128 and the number of the first signal, by default of Ctrl-C."""
    return 128 + (arrived or [signal.SIGINT])[0]


@contextmanager
def restored() -> Iterator[None]:
    """Raise KeyboardInterrupt within the block where compiled code or the import system made another error of it."""
    try:
        yield
    except Exception as error:
        if arrived:
            raise KeyboardInterrupt from error
        raise


@contextmanager
def delayed() -> Iterator[None]:
    """Delay the signals to the end of the block."""
    import threading

    if threading.current_thread() is not threading.main_thread():  # Python allows handlers in the main thread only
        yield
        return
    waiting: list[int] = []

    def wait(number: int, frame: object) -> None:
        waiting.append(number)
        if len(waiting) > 2:
            os._exit(128 + waiting[0])

    former = {number: signal.signal(number, wait) for number in _handled()}
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
    if waiting:
        signal.raise_signal(waiting[0])


def _interrupt(number: int, frame: object) -> None:
    """Raise KeyboardInterrupt at the first signal, let the second pass while files are cleaned up, end at the third.

    Not within the import system, which would keep its lock, so that a thread that imports waits forever.
    """
    code = getattr(frame, "f_code", None)
    if code and code.co_filename.startswith("<frozen importlib") and _come_again(number):
        return
    arrived.append(number)
    if len(arrived) == 1:
        raise KeyboardInterrupt
    if len(arrived) > 2:
        os._exit(exit_code())


def _come_again(number: int) -> bool:
    """Send a signal once more in a moment; return whether that is possible."""
    if not hasattr(signal, "setitimer"):  # on Windows
        return False

    def send(_: int, frame: object) -> None:
        handler = signal.getsignal(number)
        if callable(handler):
            handler(number, frame)  # type: ignore[arg-type]

    signal.signal(signal.SIGALRM, send)
    signal.setitimer(signal.ITIMER_REAL, AGAIN)
    return True


def _ignored(error: "Any") -> None:
    """Print an error that Python ignores, as in a finalizer; a signal there comes again.

    After a signal, finalizers of objects that are not complete fail; they are of no interest.
    """
    if not arrived:
        sys.__unraisablehook__(error)
    elif issubclass(error.exc_type, KeyboardInterrupt) and _come_again(arrived[0]):
        del arrived[:]
