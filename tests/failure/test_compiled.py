"""Compiled loops without a cache folder, and the notice of a long compilation."""

import logging
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from geomhw import compiled as module
from geomhw.compiled import compiled


def test_no_cache_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no cache folder can be written, loops are compiled without a cache."""

    def no_folder(self: Any) -> None:
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(Dispatcher, "enable_caching", no_folder)

    @compiled
    def total(values: np.ndarray) -> float:
        s = 0.0
        for value in values:
            s += value
        return s

    assert total(np.arange(4.0)) == 6.0


LOOPS = """
import sys
import numpy as np
from geomhw.compiled import compiled, compiled_in_place

@compiled
def doubled(values):
    copy = np.empty(len(values))
    for k in range(len(values)):
        copy[k] = 2 * np.exp(values[k])
    return copy

@compiled_in_place
def double(values):
    for k in range(len(values)):
        values[k] = 2 * np.exp(values[k])

values = np.arange(5.0)
copy = doubled(values)
double(values)
assert (copy == values).all() and (values == 2 * np.exp(np.arange(5))).all()
print("numba.np.npyimpl" in sys.modules)
"""


RENAMED = """
from numba.core import runtime
del runtime.rtsys
"""


@pytest.mark.parametrize("renamed", [False, True])
def test_cached_code_is_loaded_alone(renamed: bool, tmp_path: Path) -> None:
    """The first process compiles; the next one loads machine code without numba's declarations; both compute.

    With a numba whose parts have other names, it loads the declarations.
    """
    script = tmp_path / "loops.py"
    script.write_text((RENAMED if renamed else "") + LOOPS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for loaded in ("True", str(renamed)):
        run = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=True)
        assert run.stdout.strip() == loaded


@pytest.mark.parametrize(("seconds", "lines"), [(0.0, 0), (0.5, 1)])
def test_notice(seconds: float, lines: int, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    """A compilation is logged once if it takes long, nested ones included."""
    monkeypatch.setattr(module, "SLOW", 0.1)
    monkeypatch.setattr(module.event, "unregister", lambda kind, listener: None)
    logging.getLogger("geomhw").setLevel(logging.NOTSET)
    notice = module._CompilationNotice()
    notice.on_start(None)
    notice.on_start(None)
    notice.on_end(None)
    time.sleep(seconds)
    notice.on_end(None)
    time.sleep(0.2)
    assert [record.name for record in caplog.records] == ["geomhw"] * lines
