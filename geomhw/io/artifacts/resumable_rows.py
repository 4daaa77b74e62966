"""A large file that comes to be bit by bit, and whose beginning is kept when the work is interrupted.

While it is not whole it lies beside its target, ``D.npy``, as ``D.partial.npy``, with ``D.partial.json`` saying of what
run it is and how far it has come. The same run goes on from there; when all is there, it takes the target's name.
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
from geomhw.io.atomic import disk_sentence, replacing, why_not_written

#: How far it has come is written down no more often than this, in seconds.
INTERVAL = 1.0


class ResumableFile:
    """Appends to the file of one run; a context, on leaving which without `finish` what there is stays.

    run: plain values that say of what run it is. start: the first bytes. size: of all. suffix: of the file while it is
    not whole, by default the target's. note: values to go on with.

    FormatError if there is the beginning of another run, or no room for all.
    """

    def __init__(self, target: str | Path, run: Mapping[str, Any], start: bytes, size: int, suffix: str = "") -> None:
        self.target = Path(os.path.realpath(target))
        stem, suffix = self.target.stem, suffix or self.target.suffix
        self.path = self.target.with_name(f"{stem}.partial{suffix}")
        self.state = self.target.with_name(f"{stem}.partial.json")
        self._run, self._saved = dict(run), time.monotonic()
        for path in (self.target, self.path, self.state):
            if reason := why_not_written(path):
                raise FormatError(f"cannot write {path.name}: {reason}")
        self.done, self.note, self._length = self._resumed()
        self._require_room(size - self._length)
        try:
            self._stream = self.path.open("r+b" if self._length else "wb", buffering=0)
            self._stream.truncate(self._length)
            self._stream.seek(self._length)
        except OSError as error:
            raise FormatError(disk_sentence(error, self.path.name)) from error
        if not self._length:
            self._write(start)

    def append(self, data: bytes, done: int, note: Mapping[str, Any]) -> None:
        """Write what makes ``done`` units of work done, and now and then how far that is."""
        self._write(data)
        self.done, self.note = done, dict(note)
        if time.monotonic() - self._saved > INTERVAL:
            self._save()

    def finish(self) -> None:
        """Give it the target's name."""
        try:
            os.fsync(self._stream.fileno())
            self._stream.close()
            os.replace(self.path, self.target)
        except OSError as error:
            raise FormatError(disk_sentence(error, self.target.name)) from error
        self.state.unlink(missing_ok=True)

    def bytes_so_far(self) -> bytes:
        """All that is there."""
        return self.path.read_bytes()

    def discard(self) -> None:
        """Leave nothing."""
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
        try:
            while left:
                left = left[self._stream.write(left) :]
        except OSError as error:
            raise FormatError(disk_sentence(error, self.path.name)) from error
        self._length += len(data)

    def _save(self) -> None:
        try:
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise FormatError(disk_sentence(error, self.path.name)) from error
        written = {"run": self._run, "done": self.done, "bytes": self._length, "note": self.note}
        with replacing([self.state]) as (temporary,):
            temporary.write_text(json.dumps(written, indent=2) + "\n", encoding="utf-8")
        self._saved = time.monotonic()

    def _resumed(self) -> tuple[int, dict[str, Any], int]:
        """How much is done of this run, what was noted, and how many bytes that is."""
        if not (self.state.exists() and self.path.exists()):  # the one alone is what a kill at the end may leave
            return 0, {}, 0
        anew = f"remove {self.state.name} and {self.path.name} to start anew"
        try:
            found = json.loads(self.state.read_text(encoding="utf-8"))
            run, done, length, note = found["run"], int(found["done"]), int(found["bytes"]), dict(found["note"])
            whole = self.path.stat().st_size >= length > 0
        except (OSError, ValueError, KeyError, TypeError):
            raise FormatError(f"{self.state.name} is not the state of a run; {anew}") from None
        for name in sorted(run.keys() | self._run.keys()):
            if run.get(name) != self._run.get(name):
                raise FormatError(f"{self.state.name} is of a run with another {name}; {anew}, or take another name")
        if not whole:
            raise FormatError(f"{self.path.name} is shorter than {self.state.name} says; {anew}")
        return done, note, length

    def _require_room(self, more: int) -> None:
        free = shutil.disk_usage(self.target.parent).free
        if more > free:
            raise FormatError(
                f"cannot write {self.target.name}: it takes {_amount(more)}, and there is room for {_amount(free)}; "
                "make room, or write to another disk"
            )


def _amount(count: int) -> str:
    value, unit = float(count), "bytes"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 1000:
            break
        value, unit = value / 1000, larger
    return f"{value:.3g} {unit}"
