"""Numbers in a text file, parsed all at once, with the line each of them stands on kept for the message."""

import re
import warnings
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FormatError
from geomhw.io.polygons import ragged
from geomhw.mesh.arrays import Ints

_NUMBER = re.compile(rb"[+-]?(\d+\.?\d*([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?|nan|inf(inity)?)", re.IGNORECASE)
_SPACE, _NEWLINE, _SLASH = 32, 10, 47


@dataclass(frozen=True)
class Numbers:
    """Numbers of several lines in one flat array: line i holds ``values[begins[i] : begins[i] + counts[i]]``."""

    values: NDArray[Any]
    begins: Ints
    counts: Ints

    def columns(self, width: int) -> NDArray[Any]:
        """The first ``width`` numbers of every line, (lines, width); every line must have as many."""
        if len(self.values) == width * len(self.counts):
            return self.values.reshape(-1, width)
        return np.asarray(self.values[self.begins[:, None] + np.arange(width)])


class Lines:
    """The tokens of a text file by line; blank lines do not count as lines, but do in the numbers that ``place`` says.

    All substitutions (byte-order mark, carriage returns, comments, continued lines) keep the length, so that a byte
    offset means the same before and after.
    """

    def __init__(self, name: str, data: bytes, *, comments: bool = False, continued: bool = False) -> None:
        if b"\0" in data:
            raise FormatError(f"{name} is not a text file: it holds a zero byte")
        self.name = name
        self._physical = _plain_newlines(data)
        text = self._physical.replace(b"\\ \n", b"   ").replace(b"\\\n", b"  ") if continued else self._physical
        # Writable, and closed by a newline so that every token has a byte after it.
        self._clean = np.frombuffer(bytearray(text + b"\n"), dtype=np.uint8)
        if comments and b"#" in text:
            _blank_comments(self._clean)
        place = _place_type(len(self._clean))
        self._starts = token_starts(self._clean).astype(place)
        newlines = np.flatnonzero(self._clean == _NEWLINE).astype(place)
        ends = np.searchsorted(self._starts, newlines).astype(place)
        del newlines
        counts = np.diff(ends, prepend=place(0))
        filled = counts > 0
        self.counts: Ints = counts[filled]
        self._first = (ends - counts)[filled]

    def __len__(self) -> int:
        return len(self.counts)

    def place(self, row: int) -> str:
        """Where that line is, for a message: ``moo.off, line 17``."""
        return self._place(int(self._starts[self._first[row]]))

    def tokens(self, row: int) -> list[str]:
        """Tokens of one line, as text."""
        begin = int(self._first[row])
        return [self._token(int(at)) for at in self._starts[begin : begin + int(self.counts[row])]]

    def starting_with(self, word: str) -> Ints:
        """The lines whose first token is that word."""
        heads = self._starts[self._first]
        heads = heads[heads + len(word) < len(self._clean)]
        fits = self._clean[heads + len(word)] <= _SPACE
        for i, letter in enumerate(word):
            fits &= self._clean[heads + i] == ord(letter)
        return np.flatnonzero(fits)

    def numbers(self, rows: Ints, *, keyword: str = "", whole: bool = False, attributes: bool = False) -> Numbers:
        """All numbers on these lines (ascending), or FormatError at the first token that is none.

        keyword: the word that starts each line, passed over. whole: integers are expected, which parse ten times
        faster; should there be others, the values are floats. attributes: of ``7/3/2``, take the 7.
        """
        counts = self.counts[rows] - bool(keyword)
        begins = np.cumsum(counts) - counts
        if not counts.sum():
            return Numbers(np.empty(0), begins, counts)
        section = self._section(rows, len(keyword))
        main = _main_parts(section) if attributes else None
        text = section.tobytes()
        values = parse_numbers(text, np.int64) if whole else None
        if values is None:
            values = parse_numbers(text, np.float64)
        if values is not None and main is not None:
            values = values[main] if len(values) == len(main) else None
        # Fewer numbers than tokens: the integer parser reads the two of "- 2" as one. It never makes two of one.
        if values is None or len(values) != counts.sum():
            self._complain(rows, bool(keyword), attributes)
        return Numbers(values, begins, counts)

    def _section(self, rows: Ints, blanked: int) -> NDArray[np.uint8]:
        """A copy of the bytes of these lines, one after the other, the first few of each line blanked."""
        bounds = np.append(self._starts[self._first], len(self._clean))
        low, high = rows[0], rows[-1] + 1
        section = self._clean[bounds[low] : bounds[high]].copy()
        lengths = np.diff(bounds[low : high + 1])
        if high - low != len(rows):
            chosen = np.zeros(high - low, dtype=bool)
            chosen[rows - low] = True
            section = section[np.repeat(chosen, lengths)]
            lengths = lengths[chosen]
        heads = np.cumsum(lengths) - lengths
        for i in range(blanked):
            section[heads + i] = _SPACE
        return section

    def _place(self, offset: int) -> str:
        line = self._physical.count(b"\n", 0, offset) + 1
        return f"{self.name}, line {line}"

    def _word(self, offset: int) -> bytes:
        return self._clean[offset : offset + 400].tobytes().split(None, 1)[0]

    def _token(self, offset: int) -> str:
        shown = self._word(offset).decode("utf-8", "replace")
        return shown if len(shown) <= 30 else shown[:27] + "..."

    def _complain(self, rows: Ints, skip: int, attributes: bool) -> NoReturn:
        """Find the token that is no number; slow, but it runs only once and for a message."""
        numbered = ragged(self._first[rows] + skip, self.counts[rows] - skip)
        for offset in self._starts[numbered].tolist():
            parts = self._word(offset).split(b"/") if attributes else [self._word(offset)]
            # 7//2 leaves the middle out, and 7/ the end; the first part is what counts.
            if not all(_NUMBER.fullmatch(part) for part in [parts[0], *filter(None, parts[1:])]):
                raise FormatError(f"{self._place(offset)}: '{self._token(offset)}' is not a number")
        raise FormatError(f"{self.place(int(rows[0]))}: the numbers that start here cannot be read")


def _plain_newlines(data: bytes) -> bytes:
    """Byte-order mark blanked and every kind of line end made one newline, at the same length."""
    if data.startswith(b"\xef\xbb\xbf"):
        data = b"   " + data[3:]
    return data.replace(b"\r\n", b" \n").replace(b"\r", b"\n") if b"\r" in data else data


def _place_type(size: int) -> type[Any]:
    """Of positions in so many bytes: half the memory, for files of usual size."""
    return np.int32 if size < 2**31 else np.int64


def _blank_comments(clean: NDArray[np.uint8]) -> None:
    """Blank from each ``#`` to the end of its line, in place."""
    place = _place_type(len(clean))
    newlines = np.flatnonzero(clean == _NEWLINE).astype(place)
    hashes = np.flatnonzero(clean == ord("#")).astype(place)
    ends = newlines[np.searchsorted(newlines, hashes)]
    first = np.diff(ends, prepend=place(-1)) > 0  # of the hashes of a line
    inside = np.zeros(len(clean), dtype=np.int8)
    inside[hashes[first]] = 1
    inside[ends[first]] = -1
    np.cumsum(inside, dtype=np.int8, out=inside)
    clean[inside.view(bool)] = _SPACE


def token_starts(clean: NDArray[np.uint8]) -> Ints:
    blank = clean <= _SPACE
    start = np.empty(len(clean), dtype=bool)
    start[0] = not blank[0]
    np.greater(blank[:-1], blank[1:], out=start[1:])
    return np.flatnonzero(start)


def _main_parts(section: NDArray[np.uint8]) -> NDArray[np.bool_] | None:
    """Turn slashes to spaces, in place, and say which of the numbers then there follows no slash; None: all."""
    slashes = section == _SLASH
    if not slashes.any():
        return None
    section[slashes] = _SPACE
    return np.asarray(~slashes[token_starts(section) - 1])


def converted(values: NDArray[Any], kind: np.dtype[Any]) -> NDArray[Any]:
    """Numbers of a text in the type that the file says; ValueError where an integer type cannot hold one.

    What is too large for a float is infinite, as it is when read from text.
    """
    if kind.kind in "iu":
        limits = np.iinfo(kind)
        bad = (values != np.floor(values)) | (values < limits.min) | (values > limits.max)
        if bad.any():
            raise ValueError(f"{values[np.argmax(bad)]:.20g} is none of the whole numbers of {kind.itemsize} bytes")
    with np.errstate(over="ignore"):
        return values.astype(kind)


def parse_numbers(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    """Every number of a text that has some; None where one is none. numpy before 2.3 only warns and stops there."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except ValueError:
            return None
