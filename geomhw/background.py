"""Computation in a background thread."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def submit(work: Callable[[], T]) -> Future[T]:
    """Start ``work`` in a thread; its exceptions are raised by ``result()`` of the returned future.

    numpy and scipy release the interpreter lock while they compute. Modules that both threads import must be imported
    before.
    """
    worker = ThreadPoolExecutor(1)
    future = worker.submit(work)
    worker.shutdown(wait=False)
    return future
