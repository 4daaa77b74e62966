"""The folder that all ranks share in a test."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from support.rank_meshes import RANKS


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One folder for all ranks."""
    return RANKS.comm.bcast(tmp_path)


@pytest.fixture(scope="session", autouse=True)
def _ends_together() -> Iterator[None]:
    """Let no rank remove its folders, which others use, before all have run their tests."""
    yield
    RANKS.comm.Barrier()
