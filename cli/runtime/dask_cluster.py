"""Work on the workers of a Dask scheduler, in order, and again on another worker where one is lost."""

import logging
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from math import inf
from typing import Any

from geomhw.errors import ArgumentError, ConvergenceError
from geomhw_cli.options import option

#: Workers that a task may lose before the run fails; tasks that wait for each worker; seconds to reach a scheduler, and
#: between two counts of its workers.
LOSSES, AHEAD, PATIENCE, RECOUNT = 10, 2, 20, 1.0
SCHEDULER = option(
    "--scheduler",
    "ADDRESS|local",
    str,
    "Compute on the workers of this Dask scheduler, such as tcp://host:8786, or on a process for each core. Needs "
    "geomhw[dask].",
)


@contextmanager
def connected(address: str, workers: int | None = None) -> Iterator[Any]:
    """Connect to a scheduler, or start one here with some workers, by default one for each core.

    Raises ArgumentError if Dask is not installed or the scheduler cannot be reached.
    """
    dask, distributed = _loaded("dask"), _loaded("distributed")
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    settings = {"distributed.scheduler.allowed-failures": LOSSES, "distributed.worker.daemon": False}
    with dask.config.set(settings):
        try:
            if address == "local":
                where = distributed.LocalCluster(
                    n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None
                )
            else:
                where = address
            client = distributed.Client(where, timeout=PATIENCE)
        except (OSError, ValueError) as error:
            raise ArgumentError(f"--scheduler: {address} cannot be reached: {error}") from error
        try:
            yield client
        finally:
            client.close()
            if address == "local":
                where.close()


def in_order(client: Any, function: Callable[..., Any], items: Sequence[Any], *shared: Any) -> Iterator[Any]:
    """Yield function(item, *shared) for each item in order; a few wait for each worker, so that memory is bounded.

    shared: arguments that are sent to each worker once.
    """
    everywhere = [client.scatter(value, broadcast=True, hash=False) for value in shared]
    waiting: deque[Any] = deque()
    left, workers, counted = iter(items), 1, -inf
    try:
        while True:
            if time.monotonic() - counted > RECOUNT:
                workers, counted = len(client.scheduler_info(n_workers=-1)["workers"]), time.monotonic()
            room = AHEAD * max(1, workers) - len(waiting)
            for item in (item for _, item in zip(range(room), left, strict=False)):
                waiting.append(client.submit(function, item, *everywhere, pure=False))
            if not waiting:
                return
            yield _result(waiting.popleft())
    finally:
        client.cancel(list(waiting))


def as_they_end(
    client: Any, function: Callable[[Any], Any], items: Sequence[Any]
) -> Generator[tuple[Any, Any], None, None]:
    """Yield each item with function(item) when that ends."""
    futures = {client.submit(function, item, pure=False): item for item in items}
    try:
        for future in _loaded("distributed").as_completed(futures):
            yield futures[future], _result(future)
    finally:
        client.cancel(list(futures))


def _result(future: Any) -> Any:
    """The result of a task. Raises ConvergenceError if all workers that tried it were lost."""
    try:
        return future.result()
    except _loaded("distributed").KilledWorker as error:
        raise ConvergenceError(f"{LOSSES} workers were lost, perhaps for lack of memory; give them more") from error


def _loaded(name: str) -> Any:
    """A module of Dask, which is not typed. Raises ArgumentError if it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        raise ArgumentError("--scheduler needs Dask; install geomhw[dask]") from None
