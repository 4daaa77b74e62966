"""Numbers one blank apart, in lines that are alike: nearly a JSON array, and read as one.

simdjson reads such arrays ten times as fast as numpy reads text, and finds the double nearest to what is written
[Lemire 2021]. It refuses what is no number in JSON, ``+1``, ``.5``, ``5.``, ``007``, ``nan``, and two blanks in a row:
the answer is None then, as it is where simdjson is not installed, and who asks has another way for all of that.

[Lemire 2021] D. Lemire, Number parsing at a gigabyte per second, Software: Practice and Experience 51 (8).
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

_LETTERS, _GAPS = b"0123456789+-.eE", b" \n"
_SPACE, _NEWLINE, _ZERO, _MINUS, _COMMA = (np.uint8(ord(letter)) for letter in " \n0-,")
#: Bytes read at a time, and the rest of a line: what is made of them stays in the processor's cache.
BLOCK = 1 << 16
#: The parser takes, and keeps, some twenty times the size of the longest text.
_LONGEST = 4 * BLOCK


def parse_regular(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    """Every number of a text, as ``kind``, float64 or int64; None where they are not one blank or line end apart.

    Tabs may stand beside the blank.
    """
    if _parser() is None or text.translate(None, _LETTERS).translate(None, _GAPS + b"\t"):
        return None
    return _parsed(text.strip(_GAPS) + b"\n", kind)


def parse_lines(text: bytes, begin: int, rows: int, *, whole: bool = False) -> tuple[NDArray[Any], int] | None:
    """The numbers of so many lines from a place on, (rows, columns), and where the line after them begins.

    whole: integers of 4 bytes are expected; else the numbers are doubles.
    None unless each of them has as many numbers as the first, blanks between and at the end, and nothing else.
    """
    columns = len(text[begin : text.find(b"\n", begin) + 1 or None].split())
    if not columns or 2 * rows * columns > len(text) + 1 - begin:  # before room is made for so many
        return None
    values, row = np.empty((rows, columns), np.int32 if whole else np.float64), 0
    while row < rows:
        part = _first_lines(text[begin : text.find(b"\n", begin + BLOCK) + 1 or None], rows - row)
        found = _parse_alike(part, columns, np.int64 if whole else np.float64)
        if found is None or not len(found) or (whole and not -(2**31) <= found.min() <= found.max() < 2**31):
            return None
        values[row : row + len(found)] = found
        row, begin = row + len(found), begin + len(part)
    return values, begin


def _first_lines(text: bytes, most: int) -> bytes:
    """The first lines of a text; all, if there are fewer."""
    ends = np.frombuffer(text, np.uint8) == _NEWLINE
    if np.count_nonzero(ends) < most:
        return text
    return text[: int(np.flatnonzero(ends)[most - 1]) + 1]


def _parse_alike(text: bytes, columns: int, kind: type[Any]) -> NDArray[Any] | None:
    """The numbers of lines of so many columns each, (rows, columns)."""
    if not text.endswith(b"\n"):
        text += b"\n"
    if not _alike(text, columns):
        text = _single(text)
        if not _alike(text, columns):
            return None
    values = _parsed(text, kind)
    return values.reshape(-1, columns) if values is not None else None


def _single(text: bytes) -> bytes:
    """The text with single blanks, and none before the end of a line."""
    text = text.replace(b"\r\n", b"\n")
    while b"  " in text:
        text = text.replace(b"  ", b" ")
    return text.replace(b" \n", b"\n")


def _alike(text: bytes, columns: int) -> bool:
    """Whether nothing but so many gaps a line is between the letters of numbers."""
    gaps = text.translate(None, _LETTERS)
    return gaps == (b" " * (columns - 1) + b"\n") * (len(gaps) // columns)


def _parsed(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    """The numbers of a text that has nothing but letters of numbers and gaps, one at its end."""
    parser = _parser()
    if parser is None or len(text) > _LONGEST:
        return None
    letters = np.frombuffer(text, np.uint8)
    gaps = (letters == _SPACE) | (letters == _NEWLINE)
    commas = letters ^ (letters ^ _COMMA) * gaps  # as by np.where, in a fourth of the time
    try:
        buffer = parser.parse(b"[%b]" % commas[:-1]).as_buffer(of_type="d" if kind is np.float64 else "i")
    except (ValueError, TypeError, RuntimeError):
        return None
    values = np.frombuffer(buffer, kind)
    if kind is np.float64 and not values.all() and _has_integer_minus_zero(commas):
        return None
    return values


def _has_integer_minus_zero(commas: NDArray[np.uint8]) -> bool:
    """Whether there is a ``-0``, which means -0.0 but is the integer 0 to JSON."""
    return bool(((commas[:-2] == _MINUS) & (commas[1:-1] == _ZERO) & (commas[2:] <= _COMMA)).any())  # or a tab


@cache
def _parser() -> Any:
    """A parser, None without simdjson."""
    try:
        from simdjson import Parser
    except ImportError:
        return None
    return Parser()
