"""Atomic writes: files are written under a temporary name beside their target, then renamed, all of them or none."""

import errno
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from geomhw.errors import FormatError

#: Advice for errors of the operating system.
_ADVICE = [
    ({errno.ENOSPC, errno.EDQUOT}, "make room, or write to another disk"),
    ({errno.EACCES, errno.EPERM, errno.EROFS}, "write to a folder that you may write to"),
    ({errno.EFBIG}, "raise the limit on the size of files (ulimit -f), or write to another disk"),
    ({errno.ENOENT}, "is its folder, or that of the file it links to, still there?"),
]
#: Temporary files and targets that wait for the end of `together`, which renames them.
_waiting: ContextVar[list[tuple[Path, Path]] | None] = ContextVar("_waiting", default=None)


@contextmanager
def replacing(paths: Sequence[str | Path]) -> Iterator[list[Path]]:
    """Write files atomically: yield temporary files, which replace the targets when the block ends.

    On any exception, interrupts included, the temporary files are removed and the targets stay as they were. The
    target of a symbolic link is replaced, not the link.

    Parameters
    ----------
    paths
        Targets, in existing folders.

    Yields
    ------
    Empty files in the folders of the targets, with the same extensions.

    Raises
    ------
    FormatError
        If a target cannot be written; errors of the operating system (a full disk, a read-only folder) become one.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from geomhw.io import replacing
    >>> target = Path(tempfile.mkdtemp()) / "out.json"
    >>> with replacing([target]) as (temporary,):
    ...     _ = temporary.write_text("{}")
    >>> target.read_text()
    '{}'
    """
    targets = [Path(os.path.realpath(path)) for path in paths]
    temporaries = [_sibling(target, "unfinished") for target in targets]
    try:
        for target, temporary in zip(targets, temporaries, strict=True):
            if reason := why_not_writable(target):
                raise FormatError(f"cannot write {target.name}: {reason}")
            # Not tempfile, whose files only their owner may read: the umask decides on permissions.
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporaries
        for temporary in temporaries:
            with temporary.open("r+b") as stream:
                os.fsync(stream.fileno())
        pairs = list(zip(temporaries, targets, strict=True))
        if (waiting := _waiting.get()) is None:
            _rename_all(pairs)
        else:
            waiting += pairs
            temporaries = []
    except OSError as error:
        raise _write_error(error, _name_in(error, temporaries, targets)) from error
    finally:
        _remove(temporaries)


@contextmanager
def together() -> Iterator[None]:
    """Delay the renames of `replacing` to the end of the block: all files of the block are written, or none.

    Raises
    ------
    FormatError
        As `replacing`.
    """
    waiting: list[tuple[Path, Path]] = []
    token = _waiting.set(waiting)
    try:
        try:
            yield
        finally:
            _waiting.reset(token)
        _rename_all(waiting)
    except OSError as error:
        raise _write_error(error, _name_in(error, *zip(*waiting, strict=True))) from error
    finally:
        _remove([temporary for temporary, _ in waiting])


def why_not_writable(path: Path) -> str:
    """Return why a file cannot be written at this path, or ""."""
    target = Path(os.path.realpath(path))
    if os.path.isdir(target):
        return "it is a folder"
    if os.path.islink(target):
        return "it is a link that leads to itself"
    if os.path.exists(target) and not os.path.isfile(target):  # a file would take the place of the device
        return "it is a device or a pipe; write to a file"
    try:
        os.lstat(target)
    except (FileNotFoundError, NotADirectoryError):
        pass
    except OSError as error:  # a name that is too long, a folder that may not be searched
        return (error.strerror or str(error)).lower()
    if not os.path.isdir(target.parent):
        return f"there is no folder {path.parent if target.name == path.name else target.parent}"
    return ""


@contextmanager
def reporting_errors(path: Path) -> Iterator[None]:
    """Turn an OSError into a FormatError that says that a file cannot be written, why, and what to do."""
    try:
        yield
    except OSError as error:
        raise _write_error(error, path.name) from error


def _write_error(error: OSError, name: str) -> FormatError:
    advice = next((f"; {words}" for numbers, words in _ADVICE if error.errno in numbers), "")
    return FormatError(f"cannot write {name}: {error.strerror or error}{advice}")


def _name_in(error: OSError, temporaries: Sequence[Path] = (), targets: Sequence[Path] = ()) -> str:
    """The target of the temporary file that an error names, or else the names of all targets."""
    names = {os.fspath(temporary): target.name for temporary, target in zip(temporaries, targets, strict=True)}
    return names.get(error.filename, ", ".join(names.values()))


def _sibling(target: Path, what: str) -> Path:
    """An unused hidden name in the same folder (rename works within a file system), with the same extension.

    what: "unfinished" or "former", for the file that a killed process leaves behind.
    """
    return target.with_name(f".{target.stem[:40]}.{what}-{os.urandom(4).hex()}{target.suffix}")


def _remove(paths: Sequence[Path]) -> None:
    for path in paths:
        with suppress(OSError):
            path.unlink()


def _rename_all(pairs: Sequence[tuple[Path, Path]]) -> None:
    """Rename temporary files to their targets, or restore the targets and raise."""
    targets = [target for _, target in pairs]
    backups = [_sibling(target, "former") if target.exists() and len(targets) > 1 else None for target in targets]
    done = 0
    try:
        for target, backup in zip(targets, backups, strict=True):
            if backup:
                _link_or_copy(target, backup)
        for temporary, target in pairs:
            os.replace(temporary, target)
            done += 1
    except BaseException:
        for target, backup in zip(targets[:done], backups[:done], strict=True):
            if backup:
                os.replace(backup, target)
            else:
                target.unlink()
        raise
    finally:
        _remove([backup for backup in backups if backup])


def _link_or_copy(target: Path, backup: Path) -> None:
    try:
        os.link(target, backup)
    except OSError:  # a file system without hard links
        import shutil

        shutil.copy2(target, backup)
