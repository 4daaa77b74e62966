"""A thread that writes files during the computation, and interrupts that wait for it."""

import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from types import TracebackType

_INTERRUPTS = (signal.SIGINT, signal.SIGTERM)


class BackgroundWriter:
    """Runs tasks one after the other in another thread.

    A task is accepted when the one before is done, so at most one is in memory. An error of a task is raised in the
    caller, at the next task or on leaving the context, and no later task runs. On leaving, also by an interrupt, the
    current task is finished first: interrupts reach the main thread only, so none stops a task halfway.

    >>> with BackgroundWriter() as writer:
    ...     writer(lambda: print("written"))
    written
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, "background_writer")
        self._latest: Future[None] | None = None

    def __call__(self, task: Callable[[], None]) -> None:
        """Wait for the task before, raise its error, and start this one."""
        self._wait()
        self._latest = self._thread.submit(task)

    def __enter__(self) -> "BackgroundWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: TracebackType | None) -> None:
        with delayed_interrupts():
            self._thread.shutdown()
        if kind is None:
            self._wait()

    def _wait(self) -> None:
        if self._latest:
            self._latest.result()


@contextmanager
def delayed_interrupts() -> Iterator[None]:
    """Delay Ctrl-C and termination signals to the end of the block."""
    if threading.current_thread() is not threading.main_thread():  # Python allows handlers in the main thread only
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
