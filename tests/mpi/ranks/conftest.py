"""The folder that all ranks share in a test."""

from pathlib import Path

import pytest

from support.rank_meshes import RANKS


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One folder for all ranks."""
    return RANKS.comm.bcast(tmp_path)
