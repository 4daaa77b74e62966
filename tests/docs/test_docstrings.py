"""Every example in a docstring of the library runs, and prints what it says."""

import doctest
import importlib
from pathlib import Path

import pytest

import geomhw
from support.pictures import needs_opengl

ROOT = Path(geomhw.__file__).parent
MODULES = sorted(
    ".".join(path.relative_to(ROOT.parent).with_suffix("").parts)
    for path in ROOT.rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=needs_opengl) if ".render." in name else name for name in MODULES]
)
def test_examples(name: str) -> None:
    """The examples of a module."""
    results = doctest.testmod(importlib.import_module(name))
    assert results.attempted > 0
    assert results.failed == 0
