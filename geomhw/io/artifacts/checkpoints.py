"""Checkpoints of a run: named arrays and a description of the run, in one ``.npz`` file."""

import json
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.errors import FormatError
from geomhw.io.artifacts.arrays import read_numpy
from geomhw.io.atomic import replacing
from geomhw.io.file_content import read_bytes

_DESCRIPTION, _DIGEST = "description", "digest"


def write_checkpoint(path: str | Path, description: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
    """Write a checkpoint atomically; equal states give equal bytes.

    Parameters
    ----------
    path
        File to write.
    description
        JSON values that identify the run.
    arrays
        Arrays by name.
    """
    text = json.dumps(dict(description) | {_DIGEST: _digest(description, arrays)}, sort_keys=True)
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        everything: dict[str, Any] = {_DESCRIPTION: np.array(text), **arrays}
        np.savez(stream, **everything)


def read_checkpoint(path: str | Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read the description and the arrays of a checkpoint.

    Raises
    ------
    FormatError
        If the file cannot be read, is not a checkpoint, or is not as it was written.
    """
    data = read_bytes(Path(path))
    try:
        arrays = read_numpy(data)
        if not isinstance(arrays, dict):
            raise ValueError("it is one array")
        description = json.loads(str(arrays.pop(_DESCRIPTION)))
        if not isinstance(description, dict):
            raise ValueError("its description is not of a run")
        if description.pop(_DIGEST) != _digest(description, arrays):
            raise ValueError("it is not as it was written")
        return description, arrays
    except Exception:  # zipfile, numpy and json each have their own errors
        name = Path(path).name
        raise FormatError(
            f"{name} holds no state to restart from, or is damaged; give the .restart.npz of an earlier run"
        ) from None


def _digest(description: Mapping[str, Any], arrays: Mapping[str, Any]) -> str:
    """SHA-256 of a description and of names, types, shapes and values of arrays, in hexadecimal."""
    digest = sha256(json.dumps(description, sort_keys=True).encode())
    for name, values in sorted(arrays.items()):
        array = np.ascontiguousarray(values)
        digest.update(f"{name} {array.dtype.str} {np.shape(values)} ".encode() + array.tobytes())
    return digest.hexdigest()
