"""Progress bar of a long run, on stderr if that is a terminal."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

_UNITS = 1000


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """A function to call with the completed share of the run, 0..1; the bar shows the remaining time."""
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    with click.progressbar(length=_UNITS, label=label, file=sys.stderr) as bar:
        yield lambda share: bar.update(round(share * _UNITS) - bar.pos)
