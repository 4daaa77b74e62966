"""Files that are whole or absent: written under a temporary name beside their target, then renamed."""

import contextlib
import errno
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from geomhw.errors import FormatError

#: What to do about an error of the system.
_ADVICE = [
    ({errno.ENOSPC, errno.EDQUOT}, "make room, or write to another disk"),
    ({errno.EACCES, errno.EPERM, errno.EROFS}, "write to a folder that you may write to"),
    ({errno.EFBIG}, "raise the limit on the size of files (ulimit -f), or write to another disk"),
    ({errno.ENOENT}, "is its folder, or that of the file it links to, still there?"),
]


@contextmanager
def replacing(paths: Sequence[str | Path]) -> Iterator[list[Path]]:
    """Temporary siblings to write to; on leaving, they take the places of ``paths``, all of them or none.

    On any exception, an interrupt too, the temporaries are removed and what was there before is there again.
    OSError (a full disk, a read-only folder) becomes a FormatError. A symbolic link stays one: its target is replaced.

    >>> with replacing(["out.json"]) as (temporary,):  # doctest: +SKIP
    ...     temporary.write_text("{}")
    """
    targets = [Path(os.path.realpath(path)) for path in paths]
    temporaries = [_sibling(target, "unfinished") for target in targets]
    try:
        for target, temporary in zip(targets, temporaries, strict=True):
            if reason := why_not_written(target):
                raise FormatError(f"cannot write {target.name}: {reason}")
            # Not tempfile, whose files only their owner may read: these bits are the ones the umask leaves.
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporaries
        for temporary in temporaries:
            _flush_to_disk(temporary)
        _rename_all(temporaries, targets)
    except OSError as error:
        raise FormatError(_sentence(error, temporaries, targets)) from error
    finally:
        for temporary in temporaries:
            with contextlib.suppress(OSError):
                temporary.unlink()


def why_not_written(path: Path) -> str:
    """What forbids to put a file in this place, or ""; a device, say, would give way to the file."""
    target = Path(os.path.realpath(path))
    if target.is_dir():
        return "it is a folder"
    if target.is_symlink():
        return "it is a link that leads to itself"
    if target.exists() and not target.is_file():
        return "it is a device or a pipe; write to a file"
    if not target.parent.is_dir():
        return f"there is no folder {path.parent if target.name == path.name else target.parent}"
    return ""


def _sibling(target: Path, what: str) -> Path:
    """An unused hidden name in the same folder (rename works within a file system), with the same extension.

    what: "unfinished" or "former"; a process that is killed leaves such a file behind, and its name says so.
    """
    return target.with_name(f".{target.stem[:40]}.{what}-{os.urandom(4).hex()}{target.suffix}")


def _flush_to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _rename_all(temporaries: Sequence[Path], targets: Sequence[Path]) -> None:
    """Rename all, or put back what was there and raise."""
    backups = [_sibling(target, "former") if target.exists() and len(targets) > 1 else None for target in targets]
    done = 0
    try:
        for target, backup in zip(targets, backups, strict=True):
            if backup is not None:
                _second_name(target, backup)
        for temporary, target in zip(temporaries, targets, strict=True):
            os.replace(temporary, target)
            done += 1
    except BaseException:
        for target, backup in zip(targets[:done], backups[:done], strict=True):
            if backup is None:
                target.unlink()
            else:
                os.replace(backup, target)
        raise
    finally:
        for backup in filter(None, backups):
            with contextlib.suppress(OSError):
                backup.unlink()


def _second_name(target: Path, backup: Path) -> None:
    try:
        os.link(target, backup)
    except OSError:  # a file system without hard links
        import shutil

        shutil.copy2(target, backup)


def _sentence(error: OSError, temporaries: Sequence[Path], targets: Sequence[Path]) -> str:
    """The target that the error is about, under the name that the user knows, and the system's reason."""
    named = [
        t.name for temporary, t in zip(temporaries, targets, strict=True) if error.filename == os.fspath(temporary)
    ]
    return disk_sentence(error, ", ".join(named or [target.name for target in targets]))


def disk_sentence(error: OSError, name: str) -> str:
    """Why a file of that name cannot be written, and what to do."""
    advice = next((f"; {words}" for numbers, words in _ADVICE if error.errno in numbers), "")
    return f"cannot write {name}: {error.strerror or error}{advice}"
