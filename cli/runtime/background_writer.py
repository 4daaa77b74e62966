"""Writing behind the computation: one other thread, and what interrupts mean to it."""

import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from types import TracebackType

_INTERRUPTS = (signal.SIGINT, signal.SIGTERM)


class BackgroundWriter:
    """Does what it is handed, piece after piece, in a thread of its own, while the caller goes on.

    A piece is taken when the one before it is done, so what one holds is all that is held. What goes wrong is raised in
    the caller, at the next piece or on leaving, and nothing is done after it. On leaving, by an interrupt too, the
    piece at hand is finished first: interrupts go to the main thread, so no piece is ever cut in two.

    >>> with BackgroundWriter() as writer:
    ...     writer(lambda: print("written"))
    written
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, "background_writer")
        self._latest: Future[None] | None = None

    def __call__(self, piece: Callable[[], None]) -> None:
        """Wait for the piece before, raise what it raised, and hand over this one."""
        self._wait()
        self._latest = self._thread.submit(piece)

    def __enter__(self) -> "BackgroundWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: TracebackType | None) -> None:
        with held_interrupts():
            self._thread.shutdown()
        if kind is None:
            self._wait()

    def _wait(self) -> None:
        if self._latest:
            self._latest.result()


@contextmanager
def held_interrupts() -> Iterator[None]:
    """Ctrl-C, or a signal to end, counts from the end of the block on."""
    if threading.current_thread() is not threading.main_thread():  # where Python allows no handlers
        yield
        return
    arrived: list[int] = []
    former = {number: signal.signal(number, lambda number, _: arrived.append(number)) for number in _INTERRUPTS}
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
    if arrived:
        signal.raise_signal(arrived[0])
