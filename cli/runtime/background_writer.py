"""A thread that writes files during the computation."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType

from geomhw_cli.runtime import interrupts


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
        with interrupts.delayed():
            self._thread.shutdown()
        if kind is None:
            self._wait()

    def _wait(self) -> None:
        if self._latest:
            self._latest.result()
