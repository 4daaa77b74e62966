"""Text files of which every line says something, with ``#`` before what is a remark."""

from pathlib import Path

from geomhw.errors import FormatError
from geomhw.io.file_bytes import content


def read_lines(path: str | Path) -> list[tuple[int, str]]:
    """Lines that say something, without remarks and blanks at the ends, each with its number, from 1.

    FormatError if the file cannot be read, is no text, or says nothing.
    """
    path = Path(path)
    try:
        text = content(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FormatError(f"{path} is no text file in UTF-8") from None
    bare = [line.partition("#")[0].strip() for line in text.splitlines()]
    if not any(bare):
        raise FormatError(f"{path} holds nothing but blank lines and remarks")
    return [(number, line) for number, line in enumerate(bare, start=1) if line]
