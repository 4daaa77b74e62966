"""A large file written piece by piece, whose finished part is kept when the run is interrupted.

Until it is whole, ``D.npy`` is written as ``D.partial.npy``; ``D.partial.json`` holds the run that it belongs to and
its progress. The same run resumes from there; the whole file takes the target's name.
"""

import json
import os
import shutil
import time
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Any

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing, reporting_errors, why_not_writable
from geomhw.io.locks import is_at, lock_open_file

#: Least seconds between two saves of the progress.
INTERVAL = 1.0
#: Bytes read at a time.
_READ = 1 << 24


@dataclass(frozen=True)
class Written:
    """Bytes that another process wrote: their number and CRC-32."""

    size: int
    checksum: int


@dataclass(frozen=True)
class Place:
    """An unfinished file, the file of its progress, its inode and its run, by which other machines recognize it."""

    path: Path
    state: Path
    inode: int
    run: Mapping[str, Any]


def write_part(place: Place, start: int, data: bytes) -> "Written | None":
    """Write bytes into an unfinished file from ``start`` on; return None if the file is not at this place here."""
    try:
        if json.loads(place.state.read_text(encoding="utf-8"))["run"] != place.run or not place.inode:
            return None
        stream = FileIO(place.path, "r+b")
    except (OSError, ValueError, KeyError, TypeError):
        return None
    with stream, reporting_errors(place.path):
        if os.fstat(stream.fileno()).st_ino != place.inode:
            return None
        stream.seek(start)
        left = memoryview(data)
        while left:
            left = left[stream.write(left) :]
    return Written(len(data), zlib.crc32(data))


class ResumableFile:
    """Appends to the file of one run; a context manager that keeps the finished part unless `finish` is called.

    Parameters
    ----------
    target
        The file to write.
    run
        JSON values that identify the run.
    start
        First bytes of the file.
    size
        Bytes of the whole file.
    suffix
        Extension of the unfinished file, by default that of the target.

    Attributes
    ----------
    done
        Units of work done so far, by this run and those it resumes.
    note
        JSON values that the last `append` left for resuming.
    start
        How many first bytes there are.

    Raises
    ------
    FormatError
        If the unfinished file belongs to another run, is damaged, is written by another process now, or the disk has
        no room for the whole file.
    """

    def __init__(self, target: str | Path, run: Mapping[str, Any], start: bytes, size: int, suffix: str = "") -> None:
        self.target = Path(os.path.realpath(target))
        self.path = self.target.with_name(f"{self.target.stem}.partial{suffix or self.target.suffix}")
        self.state = self.target.with_name(f"{self.target.stem}.partial.json")
        self._run, self._saved, self.start = dict(run), time.monotonic(), len(start)
        for path in (self.target, self.path, self.state):
            if reason := why_not_writable(path):
                raise FormatError(f"cannot write {path.name}: {reason}")
        self._refuse_files_of_others()
        self.done, self._length, self._checksum = 0, 0, 0
        self.note: dict[str, Any] = {}
        self._stream = self._opened()
        try:
            self._resume(start)
            self._require_room(size - self._length)
        except BaseException:
            is_empty = not os.fstat(self._stream.fileno()).st_size
            if is_empty and not self.state.exists():
                self.path.unlink(missing_ok=True)
            self._stream.close()
            raise
        if not self._length:
            self._save()  # first, so that a killed run is known as one
            self._write(start)

    def append(self, data: "bytes | Written", done: int, note: Mapping[str, Any]) -> None:
        """Append bytes, or count bytes that are there, after which ``done`` units are done; save now and then."""
        if isinstance(data, Written):
            self._checksum = joined_checksum(self._checksum, data)
            self._length += data.size
        else:
            self._write(data)
        self.done, self.note = done, dict(note)
        if time.monotonic() - self._saved > INTERVAL:
            self._save()

    def place(self) -> "Place":
        """Return the file as other processes find it, to write parts of it with `write_part`."""
        return Place(self.path.absolute(), self.state.absolute(), os.fstat(self._stream.fileno()).st_ino, self._run)

    def finish(self) -> None:
        """Give the file the target's name and remove the progress."""
        with reporting_errors(self.target):
            os.fsync(self._stream.fileno())
            if os.name == "nt":  # renames no open files
                self._stream.close()
            os.replace(self.path, self.target)
        self.state.unlink(missing_ok=True)
        self._stream.close()  # and with it the lock, when no file of this run can be taken for unfinished

    def discard(self) -> None:
        """Remove the unfinished file and the progress."""
        if os.name == "nt":
            self._stream.close()
        self.path.unlink(missing_ok=True)
        self.state.unlink(missing_ok=True)
        self._stream.close()

    def __enter__(self) -> "ResumableFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._stream.closed:
            return
        if self.done:
            self._save()
            self._stream.close()
        else:
            self.discard()

    def _opened(self) -> FileIO:
        """Open and lock the unfinished file."""
        with reporting_errors(self.path):
            stream = FileIO(self.path, "r+b", opener=lambda path, flags: os.open(path, flags | os.O_CREAT, 0o666))
        try:
            lock_open_file(stream, self.path)
            if not is_at(stream, self.path):
                raise FormatError(f"{self.target.name} was finished by another run just now; take another name")
        except BaseException:
            stream.close()
            raise
        return stream

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        with reporting_errors(self.path):
            self._stream.seek(self._length)
            while left:
                left = left[self._stream.write(left) :]
        self._length += len(data)
        self._checksum = zlib.crc32(data, self._checksum)

    def _save(self) -> None:
        with reporting_errors(self.path):
            os.fsync(self._stream.fileno())
        progress = {"run": self._run, "done": self.done, "bytes": self._length, "note": self.note}
        progress["checksum"] = self._checksum
        with replacing([self.state]) as (temporary,):
            text = json.dumps(progress | {"progress_checksum": _checksum(progress)}, indent=2)
            temporary.write_text(text + "\n", encoding="utf-8")
        self._saved = time.monotonic()

    def _refuse_files_of_others(self) -> None:
        """Raise an error if one of the files is a link, or the unfinished file is not of a run."""
        for path in (self.path, self.state):
            if path.is_symlink():
                raise FormatError(f"cannot write {path.name}: it is a link; remove it, or take another name")
        if self.path.exists() and self.path.stat().st_size and not self.state.exists():
            raise FormatError(
                f"cannot write {self.path.name}: it is there, and not of an interrupted run, which would have "
                f"{self.state.name} beside it; remove it, or take another name"
            )
        if self.state.exists() and not (self.path.exists() and self.path.stat().st_size):
            self._parsed()  # alone, it is of a run that was killed at its end, or is lost here

    def _resume(self, start: bytes) -> None:
        """Read the progress of an interrupted run, and cut the unfinished file to the bytes that it counts."""
        size = self.path.stat().st_size
        if self.state.exists() and size:  # a kill at the end may leave the progress alone
            found = self._progress()
            if size < found["bytes"]:
                raise FormatError(f"{self.path.name} is shorter than {self.state.name} says; {self._advice}")
            if found["bytes"]:
                self._require_bytes(found, start)
                self.done, self.note = found["done"], found["note"]
                self._length, self._checksum = found["bytes"], found["checksum"]
        with reporting_errors(self.path):
            self._stream.truncate(self._length)

    @property
    def _advice(self) -> str:
        return f"remove {self.state.name} and {self.path.name} to start anew"

    def _parsed(self) -> tuple[dict[str, Any], bool]:
        """The progress of a run, and whether it is as it was saved."""
        try:
            found = json.loads(self.state.read_text(encoding="utf-8"))
            is_whole = found.pop("progress_checksum") == _checksum(found)
            found["run"].keys(), found["bytes"], found["done"], found["note"], found["checksum"]
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            raise FormatError(f"{self.state.name} is not the state of a run; {self._advice}") from None
        return dict(found), is_whole

    def _progress(self) -> dict[str, Any]:
        """The progress of an interrupted run, if it is of this run and as it was saved."""
        found, is_whole = self._parsed()
        run = found["run"]
        for name in sorted(run.keys() | self._run.keys()):
            if run.get(name) != self._run.get(name):
                advice = f"{self._advice}, or take another name"
                raise FormatError(f"{self.state.name} is of a run with another {name}; {advice}")
        if not is_whole:
            raise FormatError(f"{self.state.name} is damaged; {self._advice}")
        return found

    def _require_bytes(self, found: Mapping[str, Any], start: bytes) -> None:
        """Raise an error if the finished bytes are not those that were written."""
        checksum, left = 0, found["bytes"]
        with reporting_errors(self.path), self.path.open("rb") as stream:
            is_ours = stream.read(len(start)) == start
            stream.seek(0)
            while left and (data := stream.read(min(left, _READ))):
                checksum, left = zlib.crc32(data, checksum), left - len(data)
        if left or not is_ours or checksum != found["checksum"]:
            raise FormatError(f"{self.path.name} is damaged; {self._advice}")

    def _require_room(self, needed: int) -> None:
        free = shutil.disk_usage(self.target.parent).free
        if needed > free:
            sizes = f"it takes {needed / 1e6:,.3f} MB, and there is room for {free / 1e6:,.3f} MB"
            raise FormatError(f"cannot write {self.target.name}: {sizes}; make room, or write to another disk")


def _checksum(progress: Mapping[str, Any]) -> int:
    return zlib.crc32(json.dumps(progress, sort_keys=True).encode())


def joined_checksum(first: int, following: Written) -> int:
    """CRC-32 of bytes with one CRC-32 and following bytes: first · x^(8 size) + that of the others, modulo 2."""
    return _product(_power(8 * following.size), first) ^ following.checksum


def _product(a: int, b: int) -> int:
    """Product of polynomials modulo that of CRC-32. Bit 31 is the coefficient of 1, bit 0 that of x^31."""
    product = 0
    for bit in range(31, -1, -1):
        if a >> bit & 1:
            product ^= b
        b = b >> 1 ^ (0xEDB88320 if b & 1 else 0)
    return product


@cache
def _power(exponent: int) -> int:
    """x^exponent modulo the polynomial of CRC-32."""
    if exponent < 2:
        return 1 << (31 - exponent)
    half = _power(exponent // 2)
    return _product(_product(half, half), _power(exponent % 2))
