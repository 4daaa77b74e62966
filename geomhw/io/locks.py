"""Locks of files that a run writes over a long time; the operating system releases those of a process that ended."""

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from geomhw.errors import FormatError


def lock_open_file(stream: IO[Any], path: Path) -> None:
    """Lock an open file until it is closed; FormatError if another process has locked it."""
    try:
        import fcntl
    except ImportError:  # Windows: files are not locked
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FormatError(f"{path} is being written by another run; wait for its end, or take another name") from None
    except OSError:  # a file system without locks
        return


@contextmanager
def locked(paths: Sequence[Path]) -> Iterator[None]:
    """Hold locks on files, existing or not, within the block.

    The lock of ``a.pvd`` is on ``.a.pvd.lock``, which is removed at the end.

    Raises
    ------
    FormatError
        If another process holds one of the locks, or a folder is not writable.
    """
    with ExitStack() as stack:
        for path in dict.fromkeys(Path(os.path.realpath(path)) for path in paths):
            stack.enter_context(_locked(path))
        yield


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    lock = path.with_name(f".{path.name}.lock")
    while True:
        try:
            stream = lock.open("a")
        except OSError:  # the folder is not writable: writing will say so
            yield
            return
        with stream:
            lock_open_file(stream, path)
            if not is_at(stream, lock):  # removed by its owner, between opening and locking
                continue
            try:
                yield
            finally:
                with suppress(OSError):
                    lock.unlink()
            return


def is_at(stream: IO[Any], path: Path) -> bool:
    """Return whether a path still names an open file."""
    try:
        return os.path.samestat(os.fstat(stream.fileno()), path.stat())
    except FileNotFoundError:
        return False
