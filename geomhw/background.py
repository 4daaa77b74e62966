"""Computation in a background thread."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
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


def ahead(values: Iterable[T]) -> Iterator[T]:
    """Yield values, each computed in a thread while the caller uses the one before.

    >>> list(ahead(k * k for k in range(4)))
    [0, 1, 4, 9]
    """
    iterator = iter(values)
    found = submit(lambda: [*islice(iterator, 1)])
    while value := found.result():
        found = submit(lambda: [*islice(iterator, 1)])
        yield value[0]
