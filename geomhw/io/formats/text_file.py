"""Text files of numbers: lines and tokens parsed in bulk, with the number of each line kept for messages."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.number_parsing import LONG, parse_numbers

_NUMBER = re.compile(rb"[+-]?(\d+(\.\d*)?([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?|nan|inf(inity)?)", re.IGNORECASE)
_TOKEN, _CONTROL = re.compile(rb"[^\x00-\x20]+"), re.compile(rb"[\x01-\x08\x0e-\x1f]")
_SPACE, _NEWLINE, _SLASH = 32, 10, 47
#: Bytes that programs leave after the end of a text.
_PADDING = b"\0\x1a"
#: Bytes scanned for lines at a time, and lines parsed at a time: temporary arrays stay in the processor's cache.
_BLOCK, _BATCH = 1 << 16, 1 << 12


@dataclass(frozen=True)
class NumberRows:
    """Numbers of some lines of a file, flat: row i is ``values[begins[i] : begins[i] + counts[i]]``."""

    file: "TextFile"
    lines: Ints
    values: NDArray[Any]
    begins: Ints
    counts: Ints

    def place(self, row: int) -> str:
        """Return where a row is, for a message: ``moo.off, line 17``."""
        return self.file.place(self.lines[row])

    def coordinates(self) -> tuple[Floats, list[str]]:
        """Return the first three numbers of each row, (rows, 3), and remarks; FormatError if one is missing.

        If all rows have two numbers, z is 0.
        """
        if len(self.counts) and (self.counts == 2).all():
            return np.pad(self.values.reshape(-1, 2), ((0, 0), (0, 1))), ["the vertices have two coordinates; z is 0"]
        if (short := self.counts < 3).any():
            bad = int(np.argmax(short))
            raise FormatError(f"{self.place(bad)}: a vertex needs 3 coordinates, not {self.counts[bad]}")
        if len(self.values) == 3 * len(self.counts):
            return self.values.reshape(-1, 3), []
        return self.values[self.begins[:, None] + np.arange(3)], []

    def integers(self, at: Ints | slice) -> Ints:
        """Return the values at some positions as integers; FormatError names the line of one that is not an integer."""
        values = self.values[at]
        if values.dtype.kind != "f":
            return values
        bad = ~(np.abs(values) < 2.0**62) | (values != np.floor(values))
        if bad.any():
            where = np.arange(len(self.values))[at][np.argmax(bad)]
            row = int(np.searchsorted(self.begins, where, side="right")) - 1
            raise FormatError(f"{self.place(row)}: '{self.values[where]:g}' is not a whole number")
        return values.astype(np.int64)


class TextFile:
    """The lines of a text file that have tokens; lines without any are not counted, except in ``place``.

    Substitutions (byte-order mark, carriage returns, comments, continued lines) keep the length, so that byte offsets
    stay valid. Stored for each line are the offset of its first token and the number of its tokens.
    """

    def __init__(self, name: str, data: bytes, *, comments: bool = False, continued: Sequence[str] = ()) -> None:
        whole, self.remarks = _without_padding(data)
        if b"\0" in whole:
            raise FormatError(f"{name} is not a text file: it holds a zero byte")
        self.name = name
        self._physical = text = _unify_newlines(whole)
        if continued and b"\\" in text:
            text = _join_lines(text, continued)
        self._text = _blank_comments(text) if comments and b"#" in text else text
        offset = np.int32 if len(data) < 2**31 else np.int64
        find = _token_lines
        if len(data) >= LONG:
            from geomhw.io.formats.decimal_numbers import token_lines as find
        heads, counts = [], [np.empty(0, offset)]
        for begin, end in _blocks(self._text):
            block_heads, block_counts = find(np.frombuffer(self._text, np.uint8, end - begin, begin))
            heads.append((block_heads + begin).astype(offset))
            counts.append(block_counts.astype(offset))
        self._heads: Ints = np.concatenate([*heads, np.array([len(whole)], offset)])
        self.counts: Ints = np.concatenate(counts)

    def __len__(self) -> int:
        return len(self.counts)

    def place(self, line: int) -> str:
        """Return where a line is, for a message: ``moo.off, line 17``."""
        return self._place(int(self._heads[line]))

    def tokens(self, line: int) -> list[str]:
        """Return the tokens of a line as text, shortened to 30 characters."""
        return [_shortened(token) for token, _ in self._tokens(line)]

    def rest(self, line: int, skip: int) -> str:
        """Return a line as text without its first bytes, with single blanks."""
        begin, end = int(self._heads[line]) + skip, int(self._heads[line + 1])
        stop = self._text.find(b"\n", begin, end)
        return b" ".join(self._text[begin : end if stop < 0 else stop].split()).decode("utf-8", "replace")

    def starting_with(self, keyword: str, *, any_case: bool = False) -> Ints:
        """Return the lines whose first token is a keyword, in small or capital letters if ``any_case``."""
        letters = np.frombuffer(self._text, np.uint8)
        lines = np.arange(len(self), dtype=self._heads.dtype)
        for i, letter in enumerate(keyword):
            found = letters[np.minimum(self._heads[lines] + i, len(letters) - 1)]
            lines = lines[(found | _SPACE if any_case else found) == ord(letter)]
        after = self._heads[lines] + len(keyword)
        return np.asarray(lines[(after == len(letters)) | (letters[np.minimum(after, len(letters) - 1)] <= _SPACE)])

    def numbers(
        self, lines: Ints, *, keyword: str = "", integers: bool = False, attributes: bool = False
    ) -> NumberRows:
        """Parse all numbers on some lines, ascending; FormatError at the first token that is not a number.

        keyword: word to skip at the start of each line. integers: try integers first, which parse faster; the values
        are floats where that fails. attributes: of ``7/3/2``, return the 7.
        """
        counts = self.counts[lines] - bool(keyword)
        batches = [lines[i : i + _BATCH] for i in range(0, len(lines), _BATCH)]
        parts = [self._parse(batch, keyword, integers, attributes) for batch in batches] or [np.empty(0)]
        return NumberRows(self, lines, np.concatenate(parts), np.cumsum(counts) - counts, counts)

    def _parse(self, lines: Ints, keyword: str, integers: bool, attributes: bool) -> NDArray[Any]:
        """Numbers of a batch of lines."""
        text = self._section(lines, len(keyword))
        is_main: NDArray[Any] | slice = slice(None)
        if attributes and b"/" in text:
            before = np.frombuffer(b" " + text, np.uint8)
            text = text.replace(b"/", b" ")
            is_main = before[token_starts(np.frombuffer(text, np.uint8))] != _SLASH
        values = parse_numbers(text, np.int64, len(self._text)) if integers else None
        if values is None:
            values = parse_numbers(text, np.float64, len(self._text))
        if values is not None:
            values = values[is_main]
        if values is None or len(values) != self.counts[lines].sum() - bool(keyword) * len(lines):
            self._complain(lines, bool(keyword), attributes)
        is_small = values.dtype.kind == "i" and -(2**31) <= values.min(initial=0) <= values.max(initial=0) < 2**31
        return values.astype(np.int32) if is_small else values

    def _section(self, lines: Ints, keyword: int) -> bytes:
        """The text of some lines, with a keyword of some length blanked in each."""
        low, high = int(lines[0]), int(lines[-1]) + 1
        bounds = self._heads[low : high + 1]
        letters = np.frombuffer(self._text, np.uint8)[bounds[0] : bounds[-1]].copy()
        for i in range(keyword):
            letters[self._heads[lines] - bounds[0] + i] = _SPACE
        if high - low > len(lines):
            letters = letters[np.repeat(np.isin(np.arange(low, high), lines), np.diff(bounds))]
        return letters.tobytes()

    def _place(self, offset: int) -> str:
        line = self._physical.count(b"\n", 0, offset) + 1
        return f"{self.name}, line {line}"

    def _tokens(self, line: int) -> Iterator[tuple[bytes, int]]:
        """Tokens of a line, each with its offset in the file."""
        for match in _TOKEN.finditer(self._text, int(self._heads[line]), int(self._heads[line + 1])):
            yield match[0], match.start()

    def _complain(self, lines: Ints, skip: int, attributes: bool) -> NoReturn:
        """Find the first token that is not a number; slow, but it runs once, for a message."""
        for line in lines.tolist():
            for token, offset in islice(self._tokens(line), skip, None):
                parts = token.split(b"/") if attributes else [token]
                # 7//2 omits the texture coordinate and 7/ ends early; the first part must be there.
                if not all(_NUMBER.fullmatch(part) for part in [parts[0], *filter(None, parts[1:])]):
                    raise FormatError(f"{self._place(offset)}: '{_shortened(token)}' is not a number")
        begin = int(self._heads[lines[0]])
        control = _CONTROL.search(self._text, begin)
        raise FormatError(f"{self._place(control.start() if control else begin)}: a control character is not a number")


def _shortened(token: bytes) -> str:
    text = token.decode("utf-8", "replace")
    return text if len(text) <= 30 else text[:27] + "..."


def _blocks(text: bytes | bytearray) -> Iterator[tuple[int, int]]:
    """Begin and end of blocks of whole lines."""
    begin = 0
    while begin < len(text):
        end = text.find(b"\n", begin + _BLOCK) + 1 or len(text)
        yield begin, end
        begin = end


def _token_lines(letters: NDArray[np.uint8]) -> tuple[Ints, Ints]:
    """For each line with tokens, the offset of the first one and the number of them; as `token_lines`, by numpy."""
    starts = token_starts(letters)
    tokens_before = np.searchsorted(starts, np.append(np.flatnonzero(letters == _NEWLINE), len(letters)))
    counts = np.diff(tokens_before, prepend=0)
    filled = counts > 0
    return starts[(tokens_before - counts)[filled]], counts[filled]


def token_starts(letters: NDArray[np.uint8]) -> Ints:
    """Offsets at which tokens start."""
    blank = np.ones(len(letters) + 1, dtype=bool)
    np.less_equal(letters, _SPACE, out=blank[1:])
    return np.flatnonzero(blank[:-1] > blank[1:])


def _without_padding(data: bytes) -> tuple[bytes, list[str]]:
    """The text without zero bytes, and bytes that once marked the end of a text, at its end; and a remark on them."""
    if not any(byte in data[-80:] for byte in _PADDING):
        return data, []
    whole = data.rstrip(_PADDING + b" \t\r\n")
    surplus = len(data[len(whole) :].strip())
    return whole, [f"left out {surplus} bytes of no text at the end"] if surplus else []


def _unify_newlines(data: bytes) -> bytes:
    """Blank a byte-order mark and turn every kind of line end into one newline, at the same length."""
    if data.startswith(b"\xef\xbb\xbf"):
        data = b"   " + data[3:]
    return data.replace(b"\r\n", b" \n").replace(b"\r", b"\n") if b"\r" in data else data


def _join_lines(text: bytes, keywords: Sequence[str]) -> bytes:
    """Blank a backslash and newline at the end of lines that start with a keyword, and of those joined to them."""
    start = rb"^[ \t]*(?:" + b"|".join(word.encode() for word in keywords) + rb")(?=[ \t\\])"
    lines = re.compile(start + rb"(?:[^\n\\#]*\\[ \t]*(?:\n|\Z))+", re.MULTILINE)
    return lines.sub(lambda match: match[0].replace(b"\\", b" ").replace(b"\n", b" "), text)


def _blank_comments(text: bytes) -> bytearray:
    """Blank each ``#`` and the rest of its line."""
    copy = bytearray(text)
    for match in re.finditer(rb"#[^\n]*", text):
        copy[match.start() : match.end()] = b" " * len(match[0])
    return copy
