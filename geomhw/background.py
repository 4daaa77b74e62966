"""Work on a second core."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def submit(work: Callable[[], T]) -> Future[T]:
    """Begin the work, while the caller goes on with something else; its errors come with its result.

    numpy and scipy let other threads run while they compute on arrays. Whatever both threads import has to be there
    already, or one may find half of it.
    """
    worker = ThreadPoolExecutor(1)
    future = worker.submit(work)
    worker.shutdown(wait=False)
    return future
