"""Files of the reference folder that GEOMHW_REFERENCE names."""

import os
from pathlib import Path

import pytest

REFERENCE = os.environ.get("GEOMHW_REFERENCE") and Path(os.environ["GEOMHW_REFERENCE"]).resolve()
needs_reference = pytest.mark.skipif(not REFERENCE, reason="GEOMHW_REFERENCE names no folder of reference meshes")


def reference(path: str) -> Path:
    """Return a file of the reference folder; only in tests marked ``needs_reference``."""
    assert REFERENCE
    return REFERENCE / path
