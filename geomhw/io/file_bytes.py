"""What is in a file, or one sentence that says why it cannot be had."""

from pathlib import Path

from geomhw.errors import FormatError


def content(path: Path, most: int | None = None) -> bytes:
    """The bytes of a file, at most so many of them; a file that is empty is refused."""
    try:
        with path.open("rb") as stream:
            data = stream.read(most)
    except FileNotFoundError:
        raise FormatError(f"{path}: there is no such file") from None
    except OSError as error:
        what = "it is a folder" if path.is_dir() else (error.strerror or str(error)).lower()
        raise FormatError(f"{path} cannot be read: {what}") from error
    if not data:
        raise FormatError(f"{path} is an empty file")
    return data
