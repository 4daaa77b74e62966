"""Computing time by stage."""

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Stages:
    """Measure and add up the time spent in named stages.

    Attributes
    ----------
    seconds : dict
        Elapsed time by name of the stage.

    Examples
    --------
    >>> stages = Stages()
    >>> with stages("assembly"):
    ...     pass
    >>> list(stages.seconds)
    ['assembly']
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the body of a ``with`` statement under that name."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = round(self.seconds.get(name, 0.0) + time.perf_counter() - start, 4)
