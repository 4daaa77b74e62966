"""Whole files as bytes, lines of text or JSON; a file that cannot be read gives a one-line error."""

import json
import os
import re
import stat
from collections.abc import Iterator
from hashlib import sha256
from io import StringIO
from itertools import chain
from pathlib import Path
from typing import Any

from geomhw.errors import FormatError

_OTHER_FILES = {stat.S_ISFIFO: "named pipe", stat.S_ISCHR: "device", stat.S_ISBLK: "device", stat.S_ISSOCK: "socket"}
#: Text in UTF-16: a byte-order mark, or a Latin letter in two bytes of either order.
_UTF16 = re.compile(rb"\xff\xfe|\xfe\xff|[\t\n\r -~]\0[\t\n\r -~]\0|\0[\t\n\r -~]\0[\t\n\r -~]")


#: First bytes of files that stand in place of a mesh: what they are, and what to do.
_STRANGERS = {
    rb"\x1f\x8b|BZh\d|\xfd7zXZ\0|\x28\xb5\x2f\xfd": "a compressed file; decompress it first",
    rb"PK\x03\x04|7z\xbc\xaf|Rar!": "an archive; take the mesh out first",
    rb"version https://git-lfs": "a pointer of Git LFS; run git lfs pull",
    rb"\s*(?i:<!doctype html|<html)": "a page in HTML; save the mesh itself",
}
#: First bytes of meshes, by extension.
_MESHES = {
    ".off": rb"(?:ST|C|N|4|n)*OFF[\s\d#]",
    ".ply": rb"ply\s",
    ".vtk": rb"# vtk DataFile Version",
    ".stl": rb"\s*solid\s",
    ".vtp": rb"(?s:\s*(?:<\?xml.{0,200}?\?>\s*)?<VTKFile[^>]*\stype=.PolyData)",
    ".vtu": rb"(?s:\s*(?:<\?xml.{0,200}?\?>\s*)?<VTKFile[^>]*\stype=.UnstructuredGrid)",
    ".msh": rb"\$MeshFormat",
    ".mesh": rb"\s*MeshVersionFormatted",
}
#: Extensions of compressed files.
COMPRESSED = (".gz", ".bz2", ".xz", ".zst", ".zip", ".7z", ".rar", ".tgz", ".tar")


def refuse_strangers(path: Path, data: bytes) -> None:
    """Raise FormatError if a file is text in UTF-16, or another kind of file that meshes come in."""
    if _UTF16.match(data):
        raise FormatError(f"{path} is text in UTF-16, which is not read; save it in UTF-8")
    if what := next((what for start, what in _STRANGERS.items() if re.match(start, data)), None):
        raise FormatError(f"{path} is {what}")
    meant = next((extension for extension, start in _MESHES.items() if re.match(start, data)), path.suffix.lower())
    if meant != path.suffix.lower() and path.suffix:
        raise FormatError(f"{path} is in the format {meant[1:].upper()}; give it the extension {meant}")


def read_bytes(path: Path, limit: int | None = None) -> bytes:
    """Return the first ``limit`` bytes of a file, by default all; FormatError if it cannot be read or is empty.

    Only regular files are read: a named pipe may never end, and reading a device has effects.
    """
    try:
        mode = path.stat().st_mode
        if other := next((kind for test, kind in _OTHER_FILES.items() if test(mode)), ""):
            raise FormatError(f"{path} cannot be read: it is a {other}, not a regular file")
        with path.open("rb") as stream:
            data = stream.read(limit)
    except FileNotFoundError:
        raise FormatError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        reason = "it is a folder" if os.path.isdir(path) else (getattr(error, "strerror", None) or str(error)).lower()
        raise FormatError(f"{path} cannot be read: {reason}") from error
    if not data:
        raise FormatError(f"{path} is an empty file")
    return data


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of a file in hexadecimal; memory does not grow with its size.

    Raises
    ------
    FormatError
        If the file cannot be read.
    """
    digest = sha256()
    try:
        with open(path, "rb") as stream:
            while data := stream.read(1 << 20):
                digest.update(data)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {(error.strerror or str(error)).lower()}") from error
    return digest.hexdigest()


def read_lines(path: str | Path) -> Iterator[tuple[int, str]]:
    """Read a text file, and iterate over the lines that are not blank, without remarks after ``#``.

    Parameters
    ----------
    path
        File in UTF-8.

    Returns
    -------
    Pairs of line number, from 1, and text without leading and trailing blanks.

    Raises
    ------
    FormatError
        If the file cannot be read, is not text, or has no such lines.
    """
    path = Path(path)
    try:
        data = read_bytes(path)
        refuse_strangers(path, data)
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FormatError(f"{path} is not a text file in UTF-8") from None
    if next(_bare_lines(text), None) is None:
        raise FormatError(f"{path} holds nothing but blank lines and remarks")
    return _bare_lines(text)


def _bare_lines(text: str) -> Iterator[tuple[int, str]]:
    """Iterate over the lines as `read_lines` does. A list of them would take 50 times the memory of the text."""
    lines = chain.from_iterable(map(str.splitlines, StringIO(text, newline="\n")))
    bare = (line.partition("#")[0].strip() for line in lines)
    return ((number, line) for number, line in enumerate(bare, start=1) if line)


def read_json(path: str | Path) -> Any:
    """Read a JSON document; NaN and Infinity are accepted as numbers.

    Raises
    ------
    FormatError
        If the file cannot be read or is not JSON.
    """
    path = Path(path)
    try:
        return json.loads(read_bytes(path).decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path.name} cannot be read as JSON: {error}") from None
