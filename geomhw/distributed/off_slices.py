"""Slices of OFF files of triangles: binary rows of equal length, or lines of text, counted by chunks of the file."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.ranks import Ranks
from geomhw.distributed.sliced_file import LONGEST_HEADER, SlicedFile, unsliceable
from geomhw.errors import FormatError
from geomhw.io.formats.off_read import BINARY, KEYWORD, WIDTHS, corners_of_faces, counts_of, first_token
from geomhw.io.formats.text_file import NumberRows, TextFile

#: Bytes of a text file that are read at a time.
CHUNK = 1 << 22


def open_off(path: Path) -> SlicedFile:
    """Open an OFF file, whose header decides whether it is binary."""
    with path.open("rb") as stream:
        head = stream.read(LONGEST_HEADER)
    keyword = KEYWORD.match(head, first_token(head))
    if keyword and keyword[2]:
        raise unsliceable(path, f"its keyword is {keyword[0].decode()}")
    if keyword and (binary := BINARY.match(head, keyword.end())):
        return _BinaryOff(path, head, binary.end(), re.findall(rb"ST|C|N", keyword[1] or b""))
    return _TextOff(path, head, len(keyword[0]) if keyword else 0)


class _BinaryOff(SlicedFile):
    """Numbers of four bytes, big-endian: vertices; faces, each with the number of its corners, and of its colors."""

    def __init__(self, path: Path, head: bytes, start: int, prefixes: list[bytes]) -> None:
        self.path = path
        self.n_vertices, self.n_faces, _ = _words(path, start, 3)
        self._vertex = np.dtype((">f4", 3 + sum(WIDTHS[prefix][0] for prefix in prefixes)))
        self._vertices = start + 12
        self._faces = self._vertices + self.n_vertices * self._vertex.itemsize
        if self.n_vertices <= 0 or self.n_faces <= 0:
            raise FormatError(f"{path} has {self.n_vertices} vertices and {self.n_faces} faces; a surface needs both")
        size, *_, colors = _words(path, self._faces, 5)
        if size != 3 or not 0 <= colors <= 4:
            raise unsliceable(path, f"face 0 has {size} corners" if size != 3 else f"face 0 has {colors} colors")
        self._colors = colors
        self._face = np.dtype([("count", ">i4"), ("corners", ">i4", 3), ("colors", ">i4"), ("", ">i4", colors)])
        if (missing := self._faces + self.n_faces * self._face.itemsize - path.stat().st_size) > 0:
            raise FormatError(f"{path} ends before its last face; {missing} bytes are missing, or colors differ")

    def read_vertices(self, begin: int, end: int) -> Floats:
        """Return the coordinates of a range of vertices."""
        offset = self._vertices + begin * self._vertex.itemsize
        rows = np.fromfile(self.path, self._vertex.base, (end - begin) * self._vertex.shape[0], offset=offset)
        return rows.reshape(end - begin, -1)[:, :3].astype(float)

    def read_faces(self, begin: int, end: int) -> Ints:
        """Return the vertices of a range of triangles."""
        rows = np.fromfile(self.path, self._face, end - begin, offset=self._faces + begin * self._face.itemsize)
        other = (rows["count"] != 3) | (rows["colors"] != self._colors)
        for bad in np.flatnonzero(other)[:1]:
            raise unsliceable(self.path, f"face {begin + bad} has other numbers of corners or colors than face 0")
        return rows["corners"].astype(np.int64)


def _words(path: Path, offset: int, count: int) -> list[int]:
    """Some integers of a file; FormatError if it ends before."""
    found = np.fromfile(path, ">i4", count, offset=offset) if path.stat().st_size > offset else np.empty(0)
    if len(found) < count:
        raise FormatError(f"{path} ends inside its header")
    return [int(number) for number in found]


class _TextOff(SlicedFile):
    """A line for each vertex and each face; lines without numbers do not count."""

    def __init__(self, path: Path, head: bytes, keyword: int) -> None:
        self.path = path
        if b"\n" not in head:
            raise unsliceable(path, "its first line has no end")
        text = TextFile(str(path), head[: head.rindex(b"\n") + 1], comments=True)
        tokens = text.tokens(0) if len(text) else [""]
        tokens = [*filter(None, [tokens[0][keyword:]]), *tokens[1:]]
        #: Lines of the header.
        self._header = 1 if tokens else 2
        if not tokens:
            tokens = text.tokens(1) if len(text) > 1 else []
        self.n_vertices, self.n_faces = counts_of(f"{path}, header", tokens)

    def index(self, ranks: Ranks) -> None:
        """Count lines by chunks of the file; each rank counts a part of them."""
        count = -(-self.path.stat().st_size // CHUNK)
        begin, end = ranks.shares(count)[ranks.rank : ranks.rank + 2]
        with ranks.agreeing():
            counts = np.array([len(self._chunk(chunk)) for chunk in range(begin, end)], dtype=np.int64)
        self._starts = np.concatenate([[0], np.cumsum(np.concatenate(ranks.comm.allgather(counts)))])
        if (found := int(self._starts[-1]) - self._header) < self.n_vertices + self.n_faces:
            raise unsliceable(
                self.path, f"{self.n_vertices} vertices and {self.n_faces} faces are on {max(found, 0)} lines"
            )

    def read_vertices(self, begin: int, end: int) -> Floats:
        """Return the coordinates of a range of vertices."""
        parts = [rows.coordinates()[0] for rows in self._rows(begin, end, integers=False)]
        return np.concatenate([np.empty((0, 3)), *parts])

    def read_faces(self, begin: int, end: int) -> Ints:
        """Return the vertices of a range of triangles."""
        found = [np.empty(0, dtype=np.int64)]
        for rows in self._rows(begin + self.n_vertices, end + self.n_vertices, integers=True):
            corners, sizes = corners_of_faces(rows)
            for bad in np.flatnonzero(sizes != 3)[:1]:
                raise unsliceable(self.path, f"a face has {sizes[bad]} corners")
            found.append(corners)
        return np.concatenate(found).reshape(-1, 3)

    def _rows(self, begin: int, end: int, integers: bool) -> Iterator[NumberRows]:
        """The numbers of a range of lines after the header, chunk by chunk."""
        begin, end = begin + self._header, end + self._header
        chunk = int(np.searchsorted(self._starts, begin, side="right")) - 1
        while begin < end:
            start, stop = self._starts[chunk : chunk + 2]
            lines = np.arange(begin - start, min(end, stop) - start)
            if len(lines):
                yield self._chunk(chunk).numbers(lines, integers=integers)
            begin, chunk = max(begin, min(end, stop)), chunk + 1

    def _chunk(self, number: int) -> TextFile:
        """The lines that start in a chunk."""
        start = max(number * CHUNK - 1, 0)
        with self.path.open("rb") as stream:
            stream.seek(start)
            data = stream.read((number + 1) * CHUNK - start)
            if number:
                data = data[data.find(b"\n") + 1 :] if b"\n" in data else b""
            if data and not data.endswith(b"\n"):
                data += stream.readline()
        return TextFile(f"{self.path}, from byte {start} on", data, comments=True)
