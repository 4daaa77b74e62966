"""Every reader as a function of bytes: what it may do with them is return, or raise a GeomhwError."""

import os
import signal
import tempfile
import warnings
from collections.abc import Callable
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any

from geomhw.compare.arrays import compare_matrices
from geomhw.compare.documents import compare_documents
from geomhw.compare.rules import Ignored, Tolerance
from geomhw.errors import GeomhwError
from geomhw.io import (
    read,
    read_arrays,
    read_checkpoint,
    read_cloud,
    read_csv,
    read_field,
    read_json,
    read_png,
    read_polylines,
    read_series,
)
from geomhw.io.formats import meshio_worker
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.meshio_read import FORMATS, parse_reply
from geomhw.io.reading import READABLE
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Four vertices, two faces: the mesh that fields are read for.
SQUARE = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
Target = Callable[[Path], Any]
#: Processor time of the other process: less than in use, since meshio loops on many damaged files until it is stopped.
SECONDS = 0.05


def _field(key: str) -> Target:
    return lambda path: read_field(f"{path}{key}", SQUARE)


def _external(path: Path) -> object:
    """Both sides of the other process in this one, which takes a thousandth of the time to start Python."""
    import resource  # on Unix

    code, stream, timer, memory = 0, BytesIO(), signal.ITIMER_PROF, resource.RLIMIT_AS
    signal.signal(signal.SIGPROF, _stop)
    usual = resource.getrlimit(memory)
    try:
        try:
            resource.setrlimit(memory, (meshio_worker.address_space(path.stat().st_size), usual[1]))
            signal.setitimer(timer, SECONDS, SECONDS)
            meshio_worker.reply(path, "meshio", stream)
        finally:
            signal.setitimer(timer, 0)
    except _OutOfTime:
        signal.setitimer(timer, 0)
        code = -signal.SIGPROF
    resource.setrlimit(memory, usual)
    return build_result(path.name, "meshio", parse_reply(path, "meshio", code, stream.getvalue()))


class _OutOfTime(BaseException):
    """Stands for the end of the other process; no Exception, which meshio might catch."""


def _stop(*_: object) -> None:
    raise _OutOfTime


def _matrices(path: Path) -> object:
    found = read_arrays(path)
    return compare_matrices(found, found, Tolerance(), Ignored())


def _border(path: Path) -> object:
    return read_polylines(path, SQUARE.vertices)


def _document(path: Path) -> object:
    found = read_json(path)
    return compare_documents(found, found, Tolerance(), Ignored())


#: Name of a target, the extension of its files, and the reader.
TARGETS: dict[str, tuple[str, Target]] = {
    **{extension[1:]: (extension, read) for extension in READABLE if extension not in FORMATS},
    **{extension[1:]: (extension, _external) for extension in FORMATS},
    "cloud": (".vtp", read_cloud),
    "border": (".border", _border),
    "series": (".pvd", read_series),
    "table": (".csv", read_csv),
    "columns": (".csv", _field(":x,y")),
    "array": (".npy", _field("")),
    "archive": (".npz", _field(":u")),
    "func": (".func.gii", _field(":0")),
    "curv": (".thickness", _field("")),
    "annot": (".annot", _field("")),
    "label": (".label", _field(":value")),
    "mgh": (".mgh", _field(":0")),
    "mgz": (".mgz", _field(":0")),
    "npy": (".npy", _matrices),
    "npz": (".npz", _matrices),
    "mtx": (".mtx", _matrices),
    "document": (".json", _document),
    "picture": (".png", read_png),
    "state": (".restart.npz", read_checkpoint),
}


@lru_cache(maxsize=1)
def _folder() -> tempfile.TemporaryDirectory[str]:
    memory = "/dev/shm"
    return tempfile.TemporaryDirectory(prefix="geomhw-fuzz-", dir=memory if os.access(memory, os.W_OK) else None)


def feed(name: str, data: bytes) -> str | None:
    """Give a reader these bytes as a file; the sentence with which it refused them, or None if it took them."""
    extension, reader = TARGETS[name]
    path = Path(_folder().name) / f"input{extension}"
    path.write_bytes(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # what numpy warns of would stand on a user's terminal
            reader(path)
    except GeomhwError as error:
        told = str(error)
        assert "\n" not in told, told
        return told
    return None
