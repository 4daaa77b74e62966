"""Numbers in a text file, parsed all at once, with the line each of them stands on kept for the message."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import FormatError
from geomhw.io.formats.number_parsing import parse_numbers

_NUMBER = re.compile(rb"[+-]?(\d+\.?\d*([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?|nan|inf(inity)?)", re.IGNORECASE)
_TOKEN = re.compile(rb"[^\x00-\x20]+")
_SPACE, _TAB, _NEWLINE, _SLASH = 32, 9, 10, 47
#: Bytes looked through at a time, and the rest of a line; bytes parsed at a time.
BLOCK, BATCH = 1 << 16, 1 << 17


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
    offset means the same before and after. Kept of each line are where it starts and the number of its tokens; work
    goes by blocks of whole lines, so that what it takes beyond the text and the numbers does not grow with them.
    """

    def __init__(self, name: str, data: bytes, *, comments: bool = False, continued: bool = False) -> None:
        if b"\0" in data:
            raise FormatError(f"{name} is not a text file: it holds a zero byte")
        self.name = name
        self._physical = _plain_newlines(data)
        text = self._physical
        if continued and b"\\" in text:
            text = text.replace(b"\\ \n", b"   ").replace(b"\\\n", b"  ")
        self._clean = _without_comments(text) if comments and b"#" in text else text
        place = _place_type(len(data))
        heads, counts = [np.empty(0, place)], [np.empty(0, place)]
        for begin, end in _blocks(self._clean):
            block_heads, block_counts = _lines_of(np.frombuffer(self._clean, np.uint8, end - begin, begin))
            heads.append((block_heads + begin).astype(place))
            counts.append(block_counts.astype(place))
        self._heads: Ints = np.concatenate(heads)
        self.counts: Ints = np.concatenate(counts)

    def __len__(self) -> int:
        return len(self.counts)

    def place(self, row: int) -> str:
        """Where that line is, for a message: ``moo.off, line 17``."""
        return self._place(int(self._heads[row]))

    def tokens(self, row: int) -> list[str]:
        """Tokens of one line, as text."""
        return [_shown(token) for token, _ in self._words(row)]

    def starting_with(self, word: str) -> Ints:
        """The lines whose first token is that word."""
        letters = np.frombuffer(self._clean, np.uint8)
        rows = np.arange(len(self), dtype=self._heads.dtype)
        for i, letter in enumerate(word):
            rows = rows[letters[np.minimum(self._heads[rows] + i, len(letters) - 1)] == ord(letter)]
        after = self._heads[rows] + len(word)
        return np.asarray(rows[(after == len(letters)) | (letters[np.minimum(after, len(letters) - 1)] <= _SPACE)])

    def numbers(self, rows: Ints, *, keyword: str = "", whole: bool = False, attributes: bool = False) -> Numbers:
        """All numbers on these lines (ascending), or FormatError at the first token that is none.

        keyword: the word that starts each line, passed over. whole: integers are expected, which parse several times
        faster; should there be others, the values are floats. attributes: of ``7/3/2``, take the 7.
        """
        counts = self.counts[rows] - bool(keyword)
        begins = np.cumsum(counts) - counts
        parts = [np.empty(0)] if not counts.sum() else []
        for some in self._batches(rows) if not parts else ():
            values = self._parsed(some, len(keyword), whole, attributes)
            # Fewer numbers than tokens: the integer parser reads the two of "- 2" as one. It never makes two of one.
            if values is None or len(values) != self.counts[some].sum() - bool(keyword) * len(some):
                self._complain(some, bool(keyword), attributes)
            parts.append(values)
        return Numbers(parts[0] if len(parts) == 1 else np.concatenate(parts), begins, counts)

    def _batches(self, rows: Ints) -> Iterator[Ints]:
        """The rows in parts, each of as many as some bytes hold, but of one line at least."""
        offsets = self._heads[rows]
        first = 0
        while first < len(rows):
            limit = min(int(offsets[first]) + BATCH, len(self._clean))
            after = max(first + 1, int(np.searchsorted(offsets, offsets.dtype.type(limit))))
            yield rows[first:after]
            first = after

    def _parsed(self, rows: Ints, blanked: int, whole: bool, attributes: bool) -> NDArray[Any] | None:
        """Numbers of a batch in the narrowest type that holds them; None where something is none."""
        section = self._section(rows, blanked)
        main = None
        if attributes and b"/" in section:
            letters = np.frombuffer(section, np.uint8).copy()
            main = _main_parts(letters)
            section = letters.tobytes()
        values = parse_numbers(section, np.int64) if whole else None
        if values is None:
            values = parse_numbers(section, np.float64)
        if values is not None and main is not None:
            values = values[main] if len(values) == len(main) else None
        if values is None or values.dtype.kind == "f":
            return values
        return values.astype(np.int32) if len(values) and -(2**31) <= values.min() <= values.max() < 2**31 else values

    def _section(self, rows: Ints, blanked: int) -> bytes:
        """The bytes of these lines, one after the other; for a first word, and its blank, come tabs."""
        low, high = int(rows[0]), int(rows[-1]) + 1
        heads = self._heads[low : high + 1]
        begin = int(heads[0])
        end = int(heads[-1]) if len(heads) > high - low else len(self._clean)
        if high - low == len(rows) and not blanked:
            return bytes(self._clean[begin:end])
        section = np.frombuffer(self._clean, np.uint8, end - begin, begin).copy()
        starts = heads[: high - low] - begin
        for i in range(blanked + 1 if blanked else 0):  # tabs, as JSON has blanks between its commas
            section[np.minimum(starts[rows - low] + i, len(section) - 1)] = _TAB
        if high - low != len(rows):
            chosen = np.zeros(high - low, dtype=bool)
            chosen[rows - low] = True
            section = section[np.repeat(chosen, np.diff(starts, append=end - begin))]
        return section.tobytes()

    def _place(self, offset: int) -> str:
        line = self._physical.count(b"\n", 0, offset) + 1
        return f"{self.name}, line {line}"

    def _words(self, row: int) -> Iterator[tuple[bytes, int]]:
        """Tokens of a line, and where each is in the file."""
        at = int(self._heads[row])
        end = int(self._heads[row + 1]) if row + 1 < len(self) else len(self._clean)
        for match in _TOKEN.finditer(self._clean, at, end):
            yield match[0], match.start()

    def _complain(self, rows: Ints, skip: int, attributes: bool) -> NoReturn:
        """Find the token that is no number; slow, but it runs only once and for a message."""
        for row in rows.tolist():
            for word, offset in islice(self._words(row), skip, None):
                parts = word.split(b"/") if attributes else [word]
                # 7//2 leaves the middle out, and 7/ the end; the first part is what counts.
                if not all(_NUMBER.fullmatch(part) for part in [parts[0], *filter(None, parts[1:])]):
                    raise FormatError(f"{self._place(offset)}: '{_shown(word)}' is not a number")
        raise FormatError(f"{self.place(int(rows[0]))}: the numbers that start here cannot be read")


def _shown(word: bytes) -> str:
    text = word.decode("utf-8", "replace")
    return text if len(text) <= 30 else text[:27] + "..."


def _blocks(text: bytes | bytearray) -> Iterator[tuple[int, int]]:
    """Where blocks of whole lines begin and end."""
    begin = 0
    while begin < len(text):
        end = text.find(b"\n", begin + BLOCK) + 1 or len(text)
        yield begin, end
        begin = end


def _lines_of(letters: NDArray[np.uint8]) -> tuple[Ints, Ints]:
    """Of each line that has tokens: where the first one starts, and how many there are."""
    blank = np.ones(len(letters) + 1, dtype=bool)
    np.less_equal(letters, _SPACE, out=blank[1:])
    marks = letters == _NEWLINE
    marks |= blank[:-1] > blank[1:]  # tokens start here
    at = np.flatnonzero(marks)
    ends = np.flatnonzero(letters[at] == _NEWLINE)
    if not len(ends) or ends[-1] != len(at) - 1:
        ends = np.append(ends, len(at))  # the last line of a file may go without
    counts = np.diff(ends, prepend=-1) - 1
    filled = counts > 0
    return at[(ends - counts)[filled]], counts[filled]


def _plain_newlines(data: bytes) -> bytes:
    """Byte-order mark blanked and every kind of line end made one newline, at the same length."""
    if data.startswith(b"\xef\xbb\xbf"):
        data = b"   " + data[3:]
    return data.replace(b"\r\n", b" \n").replace(b"\r", b"\n") if b"\r" in data else data


def _place_type(size: int) -> type[Any]:
    """Of positions in so many bytes: half the memory, for files of usual size."""
    return np.int32 if size < 2**31 else np.int64


def _without_comments(text: bytes) -> bytearray:
    """The text with blanks from each ``#`` to the end of its line."""
    copy = bytearray(text)
    for begin, end in _blocks(copy):
        if copy.find(b"#", begin, end) >= 0:
            _blank_comments(np.frombuffer(copy, np.uint8, end - begin, begin))
    return copy


def _blank_comments(letters: NDArray[np.uint8]) -> None:
    """The same for whole lines, in place."""
    newlines = np.append(np.flatnonzero(letters == _NEWLINE), len(letters))
    hashes = np.flatnonzero(letters == ord("#"))
    ends = newlines[np.searchsorted(newlines, hashes)]
    first = np.diff(ends, prepend=-1) > 0  # of the hashes of a line
    inside = np.zeros(len(letters) + 1, dtype=np.int8)
    inside[hashes[first]] = 1
    inside[ends[first]] = -1
    np.cumsum(inside, dtype=np.int8, out=inside)
    letters[inside[:-1].view(bool)] = _SPACE


def token_starts(clean: NDArray[np.uint8]) -> Ints:
    blank = clean <= _SPACE
    start = np.empty(len(clean), dtype=bool)
    start[0] = not blank[0]
    np.greater(blank[:-1], blank[1:], out=start[1:])
    return np.flatnonzero(start)


def _main_parts(section: NDArray[np.uint8]) -> NDArray[np.bool_] | None:
    """Turn slashes to blanks, in place, and say which of the numbers then there follows no slash; None: all."""
    slashes = section == _SLASH
    if not slashes.any():
        return None
    section ^= slashes * np.uint8(_SLASH ^ _SPACE)
    section[1:] ^= (slashes[1:] & slashes[:-1]) * np.uint8(_SPACE ^ _TAB)  # of two slashes, the second: one blank
    return np.asarray(~slashes[token_starts(section) - 1])
