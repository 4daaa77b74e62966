"""A large file written piece by piece, whose finished part is kept when the run is interrupted.

Until it is whole, ``D.npy`` is written as ``D.partial.npy``; ``D.partial.json`` holds the run that it belongs to and
its progress. The same run resumes from there; the whole file takes the target's name.
"""

import json
import os
import shutil
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing, reporting_errors, why_not_writable

#: Least seconds between two saves of the progress.
INTERVAL = 1.0


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

    Raises
    ------
    FormatError
        If the unfinished file belongs to another run, or the disk has no room for the whole file.
    """

    def __init__(self, target: str | Path, run: Mapping[str, Any], start: bytes, size: int, suffix: str = "") -> None:
        self.target = Path(os.path.realpath(target))
        self.path = self.target.with_name(f"{self.target.stem}.partial{suffix or self.target.suffix}")
        self.state = self.target.with_name(f"{self.target.stem}.partial.json")
        self._run, self._saved = dict(run), time.monotonic()
        for path in (self.target, self.path, self.state):
            if reason := why_not_writable(path):
                raise FormatError(f"cannot write {path.name}: {reason}")
        self.done, self.note, self._length = self._progress()
        self._require_room(size - self._length)
        with reporting_errors(self.path):
            self._stream = self.path.open("r+b" if self._length else "wb", buffering=0)
            self._stream.truncate(self._length)
            self._stream.seek(self._length)
        if not self._length:
            self._write(start)

    def append(self, data: bytes, done: int, note: Mapping[str, Any]) -> None:
        """Append bytes, after which ``done`` units of work are done; save the progress now and then."""
        self._write(data)
        self.done, self.note = done, dict(note)
        if time.monotonic() - self._saved > INTERVAL:
            self._save()

    def finish(self) -> None:
        """Give the file the target's name and remove the progress."""
        with reporting_errors(self.target):
            os.fsync(self._stream.fileno())
            self._stream.close()
            os.replace(self.path, self.target)
        self.state.unlink(missing_ok=True)

    def bytes_so_far(self) -> bytes:
        """Return all bytes of the unfinished file."""
        return self.path.read_bytes()

    def discard(self) -> None:
        """Remove the unfinished file and the progress."""
        self._stream.close()
        self.path.unlink(missing_ok=True)
        self.state.unlink(missing_ok=True)

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

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        with reporting_errors(self.path):
            while left:
                left = left[self._stream.write(left) :]
        self._length += len(data)

    def _save(self) -> None:
        with reporting_errors(self.path):
            os.fsync(self._stream.fileno())
        progress = {"run": self._run, "done": self.done, "bytes": self._length, "note": self.note}
        with replacing([self.state]) as (temporary,):
            temporary.write_text(json.dumps(progress, indent=2) + "\n", encoding="utf-8")
        self._saved = time.monotonic()

    def _progress(self) -> tuple[int, dict[str, Any], int]:
        """Units of this run that are done, the note, and the bytes written."""
        if not (self.state.exists() and self.path.exists()):  # a kill at the end may leave one of them
            return 0, {}, 0
        advice = f"remove {self.state.name} and {self.path.name} to start anew"
        try:
            found = json.loads(self.state.read_text(encoding="utf-8"))
            run, done, length, note = found["run"], int(found["done"]), int(found["bytes"]), dict(found["note"])
            is_whole = self.path.stat().st_size >= length > 0
        except (OSError, ValueError, KeyError, TypeError):
            raise FormatError(f"{self.state.name} is not the state of a run; {advice}") from None
        for name in sorted(run.keys() | self._run.keys()):
            if run.get(name) != self._run.get(name):
                raise FormatError(f"{self.state.name} is of a run with another {name}; {advice}, or take another name")
        if not is_whole:
            raise FormatError(f"{self.path.name} is shorter than {self.state.name} says; {advice}")
        return done, note, length

    def _require_room(self, needed: int) -> None:
        free = shutil.disk_usage(self.target.parent).free
        if needed > free:
            sizes = f"it takes {needed / 1e6:,.3f} MB, and there is room for {free / 1e6:,.3f} MB"
            raise FormatError(f"cannot write {self.target.name}: {sizes}; make room, or write to another disk")
