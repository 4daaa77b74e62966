"""Formats that meshio reads, in a process of its own with limits on time and memory.

meshio trusts the counts in a file: on a damaged one it may loop for minutes or ask for all memory, print, or call
``sys.exit``.
"""

import pickle
import signal
import subprocess
import sys
from pathlib import Path

from geomhw.errors import FormatError
from geomhw.io.formats import meshio_worker as worker
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons
from geomhw.results import Result

#: Extension to the name of the format, as the report gives it.
FORMATS = {".msh": "Gmsh", ".mesh": "Medit", ".meshb": "Medit", ".inp": "Abaqus"}
FORMATS |= {".bdf": "Nastran", ".nas": "Nastran", ".vol": "Netgen", ".su2": "SU2"}
#: Limit by the clock, for a busy machine: this many times the processor time, and seconds to start.
_PATIENCE, _START = 20.0, 60.0


def read_external(path: Path) -> Result:
    """Return the triangles, quads and polygons of a file that meshio reads, in file order."""
    kind = FORMATS[path.suffix.lower()]
    # Isolated, so that no file of the user's folder is imported as a module; then with this process's own paths.
    program = f"import sys; sys.path[:] = {sys.path!r}; from pathlib import Path; "
    program += f"from {worker.__name__} import main; main(Path({str(path.absolute())!r}), {kind!r})"
    limit = _START + _PATIENCE * _seconds(path)
    command, silent = [sys.executable, "-I", "-c", program], subprocess.DEVNULL
    try:
        answer = subprocess.run(command, stdin=silent, stdout=subprocess.PIPE, stderr=silent, timeout=limit)
    except subprocess.TimeoutExpired:
        raise worker.unreadable(path, kind, _endless(path)) from None
    return build_result(path.name, kind, parse_reply(path, kind, answer.returncode, answer.stdout))


def parse_reply(path: Path, kind: str, code: int, output: bytes) -> Polygons:
    """Return the polygons that the other process found; FormatError where it refused the file or broke down."""
    if code == -getattr(signal, "SIGPROF", 0):
        raise worker.unreadable(path, kind, _endless(path))
    if code:
        raise worker.unreadable(path, kind, "its reader breaks down on it")
    answer = pickle.loads(output)  # of our own making
    if isinstance(answer, FormatError):
        raise answer
    assert isinstance(answer, Polygons)
    return answer


def _seconds(path: Path) -> float:
    return worker.SECONDS + worker.SECONDS_A_BYTE * path.stat().st_size


def _endless(path: Path) -> str:
    return f"not done after {_seconds(path):.3g} s of computing, far more than its size explains; it is damaged"
