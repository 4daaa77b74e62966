"""Compiled loops without a cache folder, and the notice of a long compilation."""

import logging
import time
from typing import Any

import numba
import numpy as np
import pytest

from geomhw import compiled as module
from geomhw.compiled import compiled


def test_no_cache_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no cache folder can be written, loops are compiled without a cache."""

    def njit(cache: bool = False, **options: Any) -> Any:
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return numba.njit(**options)

    monkeypatch.setattr(module, "njit", njit)

    @compiled
    def total(values: np.ndarray) -> float:
        s = 0.0
        for value in values:
            s += value
        return s

    assert total(np.arange(4.0)) == 6.0


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
