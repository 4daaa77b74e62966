"""The background writer: in order, one piece at a time, without loss of an error."""

import os
import signal
import threading
import time
import weakref
from functools import partial

import pytest

from geomhw.errors import FormatError
from geomhw_cli.runtime.background_writer import BackgroundWriter


def test_in_order() -> None:
    """Pieces are done in order, and all of them when the block ends."""
    done: list[int] = []
    with BackgroundWriter() as writer:
        for k in range(50):
            writer(partial(done.append, k))
    assert done == list(range(50))


def test_the_caller_goes_on() -> None:
    """The caller continues while a piece is written."""
    gate, passed = threading.Event(), []
    with BackgroundWriter() as writer:
        writer(lambda: passed.append(gate.wait(10)))
        assert not passed
        gate.set()
    assert passed == [True]


class Frame:
    """A large object."""


def test_no_more_than_one_is_waited_for() -> None:
    """At most two pieces are alive: the one being written, and the one just done."""
    alive: weakref.WeakSet[Frame] = weakref.WeakSet()
    most = 0
    with BackgroundWriter() as writer:
        for _ in range(6):
            frame = Frame()
            alive.add(frame)
            writer(partial(lambda held: time.sleep(0.01), frame))
            del frame
            most = max(most, len(alive))
    assert most <= 2


def fail() -> None:
    raise FormatError("no room")


def test_an_error_is_raised_at_the_next_piece() -> None:
    """An error is raised at the next piece, and nothing is done after it."""
    done: list[int] = []
    with BackgroundWriter() as writer:
        writer(partial(done.append, 1))
        writer(fail)
        for _ in range(2):
            with pytest.raises(FormatError, match="no room"):
                writer(partial(done.append, 2))
        writer._latest = None  # told twice is enough
    assert done == [1]


def test_an_error_is_raised_on_leaving() -> None:
    """The error of the last piece is raised at the end, unless the caller raises its own."""
    with pytest.raises(FormatError, match="no room"), BackgroundWriter() as writer:
        writer(fail)

    def both() -> None:
        with BackgroundWriter() as writer:
            writer(fail)
            raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        both()


def test_an_interrupt_waits_for_the_piece_at_hand() -> None:
    """An interrupt waits for the current piece, also when it is repeated."""
    done: list[str] = []

    def slow() -> None:
        time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.1)
        done.append("whole")

    def interrupted() -> None:
        with BackgroundWriter() as writer:
            writer(slow)
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert done == ["whole"]
