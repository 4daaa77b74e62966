"""The state of a run, to go on from: named arrays and a description of the run, in one ``.npz``."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.errors import FormatError
from geomhw.io.artifacts.numpy_file import read_numpy
from geomhw.io.atomic import replacing

_DESCRIPTION = "description"


def write_checkpoint(path: str | Path, description: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
    """Write plain values and arrays, whole or not at all; equal states give equal bytes."""
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        everything: dict[str, Any] = {_DESCRIPTION: np.array(json.dumps(description, sort_keys=True)), **arrays}
        np.savez(stream, **everything)


def read_checkpoint(path: str | Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The description and the arrays; FormatError where the file is not such a state."""
    try:
        arrays = read_numpy(Path(path).read_bytes())
        if not isinstance(arrays, dict):
            raise ValueError("it is one array")
        description = json.loads(str(arrays.pop(_DESCRIPTION)))
        if not isinstance(description, dict):
            raise ValueError("it does not say of what run")
        return description, arrays
    except FileNotFoundError:
        raise FormatError(f"{path}: there is no such file to restart from") from None
    except Exception:  # zip, numpy and json have a dozen ways to say the same
        name = Path(path).name
        raise FormatError(f"{name} holds no state to restart from; give the .restart.npz of an earlier run") from None
