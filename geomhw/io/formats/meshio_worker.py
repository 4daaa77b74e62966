"""The process in which meshio reads a file for ``external``: it may exit, print, loop or grow, and harms nobody.

Standard output carries the arrays as ``.npz``, or a text that starts with "!": why there are none.
"""

import contextlib
import io
import json
import os
import signal
import sys
import warnings
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from geomhw.errors import FormatError

#: In front of a refusal; no ``.npz`` starts with it.
REFUSAL = b"!"
#: Processor time for any file, in seconds, and for each byte: meshio takes a tenth of that on its slowest formats.
SECONDS, SECONDS_A_BYTE = 1.0, 1e-5
#: Memory for any file beyond what the libraries take, in bytes, and for each byte of the file.
MEMORY, MEMORY_A_BYTE = 1 << 25, 20
_TOO_MUCH = "it asks for more memory than a file of its size can need"


def main(path: Path) -> None:
    """Write what is in the file to standard output; the process ends by a signal where that takes too much time."""
    import meshio  # noqa: F401  # before time and memory are counted

    limit(path.stat().st_size)
    with os.fdopen(1, "wb") as stream:
        respond(path, stream)


def respond(path: Path, stream: BinaryIO) -> None:
    """Write the answer about a file."""
    try:
        arrays = extract(path)
    except FormatError as error:
        stream.write(REFUSAL + str(error).encode())
        return
    write_arrays(stream, arrays)


def extract(path: Path) -> dict[str, Any]:
    """Points, cells by block, arrays on both; FormatError where meshio does anything but return.

    ``kinds``, ``vertex_names`` and ``cell_names`` are lists of text; ``cells_I``, ``vertex_J`` and ``cell_J_I`` the
    arrays of block I and name J.
    """
    import meshio

    silent = io.StringIO()
    try:
        with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = _arrays(meshio.read(path))
    except MemoryError:
        raise FormatError(_TOO_MUCH) from None
    except (Exception, SystemExit) as error:
        reason = "" if isinstance(error, SystemExit) else " ".join(str(error).split())[:200]
        raise FormatError(reason) from error
    # An array may be as long as a header says and filled with whatever was in memory.
    if sum(value.nbytes for value in found.values() if isinstance(value, np.ndarray)) > MEMORY_A_BYTE * _size(path):
        raise FormatError(_TOO_MUCH)
    return found


def _size(path: Path) -> int:
    return max(path.stat().st_size, 1 << 10)


def _arrays(mesh: Any) -> dict[str, Any]:
    found: dict[str, Any] = {
        "points": np.asarray(mesh.points, dtype=np.float64),
        "kinds": [block.type for block in mesh.cells],
        "vertex_names": list(mesh.point_data),
        "cell_names": list(mesh.cell_data),
    }
    found |= {f"cells_{i}": np.asarray(block.data) for i, block in enumerate(mesh.cells)}
    found |= {f"vertex_{j}": np.asarray(values) for j, values in enumerate(mesh.point_data.values())}
    for j, blocks in enumerate(mesh.cell_data.values()):
        found |= {f"cell_{j}_{i}": np.asarray(values) for i, values in enumerate(blocks)}
    return found


def write_arrays(stream: BinaryIO, arrays: dict[str, Any]) -> None:
    """Arrays and lists of text, as ``read_arrays`` takes them."""
    texts: dict[str, Any] = {
        key: np.array(json.dumps(value)) for key, value in arrays.items() if isinstance(value, list)
    }
    numbers: dict[str, Any] = {
        key: value for key, value in arrays.items() if key not in texts and value.dtype.kind in "fiub"
    }
    np.savez(stream, **texts, **numbers)


def read_arrays(data: bytes) -> dict[str, Any]:
    """What ``extract`` found in the other process."""
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        return {key: json.loads(str(value)) if value.dtype.kind == "U" else value for key, value in stored.items()}


def limit(size: int) -> None:
    """Let this process end by SIGPROF after its time, and refuse it memory beyond its share; nothing off Unix."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, SECONDS + SECONDS_A_BYTE * size)
    if sys.platform.startswith("linux"):
        import resource

        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        most = used + MEMORY + MEMORY_A_BYTE * size
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
