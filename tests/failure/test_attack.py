"""A short run of the stress test; the long one is ``make attack``."""

from itertools import chain

import pytest
from attack import files, metamorphic, states
from attack.run import attack

#: Methods that take seconds a mesh.
SLOW = ("center",)


@pytest.mark.parametrize("first", [3, 13])
def test_random_meshes(first: int) -> None:
    """Four meshes of random families under every change."""
    assert [*chain.from_iterable(metamorphic.attack(100, 4, first, without=SLOW))] == []


def test_hostile_files() -> None:
    """One damaged file of each format through a command."""
    assert [*chain.from_iterable(files.attack(1, 28))] == []


def test_damaged_states() -> None:
    """Damaged states of a matrix and of a flow."""
    assert [*chain.from_iterable(states.attack(1, 6))] == []


@pytest.mark.parametrize(("part", "count"), [("signals", 2), ("rivals", 10)])
def test_processes(part: str, count: int, capsys: pytest.CaptureFixture[str]) -> None:
    """A run with a signal, or with a rival."""
    assert attack([part], seed=1, count=count) == 0, capsys.readouterr().out
