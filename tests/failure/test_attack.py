"""A short run of the stress test; the long one is ``make attack``."""

from itertools import chain

import pytest
from attack import files, metamorphic, states
from attack.families import FAMILIES
from attack.run import attack


@pytest.mark.parametrize("seed", range(4))
def test_random_meshes(seed: int) -> None:
    """Five meshes of random families under every change."""
    count = len(FAMILIES) // 4
    assert [*chain.from_iterable(metamorphic.attack(100 + seed, count, first=count * seed))] == []


def test_hostile_files() -> None:
    assert [*chain.from_iterable(files.attack(1, 28))] == []


def test_damaged_states() -> None:
    assert [*chain.from_iterable(states.attack(1, 12))] == []


@pytest.mark.parametrize("part", ["signals", "rivals"])
def test_processes(part: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Two runs with a signal, and one with a rival."""
    assert attack([part], seed=1, count=4 if part == "signals" else 10) == 0, capsys.readouterr().out
