"""How far a long run has come, on stderr, where that is a terminal."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

_UNITS = 1000


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """A call to make with the share that is done, 0..1; the bar shows the time to go."""
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    with click.progressbar(length=_UNITS, label=label, file=sys.stderr) as bar:

        def show(share: float) -> None:
            bar.update(round(share * _UNITS) - bar.pos)

        yield show
