"""Tests that ``make test-mpi`` runs, and no other run of the suite: they need petsc4py, mpi4py and mpirun."""

import os
import tempfile
from pathlib import Path

import pytest


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Collect this folder only where the command line names it."""
    here = Path(__file__).parent
    named = any((config.invocation_params.dir / argument).is_relative_to(here) for argument in config.args)
    return None if named else True


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Give each rank temporary folders of its own: pytest of one rank would remove those of another."""
    if config.option.basetemp is None and "OMPI_COMM_WORLD_RANK" in os.environ:
        folder = tempfile.TemporaryDirectory(prefix="geomhw-rank-", ignore_cleanup_errors=True)
        config.add_cleanup(folder.cleanup)
        config.option.basetemp = folder.name
