"""The state of a run, to go on from: named arrays and a description of the run, in one ``.npz``."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.errors import FormatError
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
        with np.load(path, allow_pickle=False) as stored:
            arrays = dict(stored.items())
        return json.loads(str(arrays.pop(_DESCRIPTION))), arrays
    except FileNotFoundError:
        raise FormatError(f"{path}: there is no such file to restart from") from None
    except Exception as error:  # zip, numpy and json have a dozen ways to say the same
        raise FormatError(f"{Path(path).name} holds no state to restart from: {error}") from error
