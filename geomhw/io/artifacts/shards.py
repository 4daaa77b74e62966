"""Shard files: the parts of one run that separate processes computed, with what each of them holds.

A file is a line that names the format, a line of JSON, the manifest, and the data.
"""

import json
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from geomhw.errors import FormatError
from geomhw.io.atomic import replacing
from geomhw.io.file_content import read_bytes

_FIRST = b"geomhw shard 1\n"
#: Bytes of a manifest at most, and bytes read at a time.
_MANIFEST, _READ = 1 << 28, 1 << 22


@dataclass(frozen=True)
class Shard:
    """One of the parts of a run.

    run: JSON values that identify the run. number, of: this is part 1 to ``of``. kind: of the data. about: further
    JSON values. start, size, checksum: of the data in the file.
    """

    path: Path
    run: Mapping[str, Any]
    number: int
    of: int
    kind: str
    about: Mapping[str, Any]
    start: int
    size: int
    checksum: int

    def chunks(self) -> Iterator[bytes]:
        """Read the data piece by piece; raises FormatError if they are not those that were written."""
        left, checksum = self.size, 0
        try:
            with self.path.open("rb") as stream:
                stream.seek(self.start)
                while left and (data := stream.read(min(left, _READ))):
                    left, checksum = left - len(data), zlib.crc32(data, checksum)
                    yield data
        except OSError as error:
            raise FormatError(f"cannot read {self.path.name}: {(error.strerror or str(error)).lower()}") from error
        if left or checksum != self.checksum:
            raise FormatError(f"{self.path.name} is damaged: its data are not those that were written; compute it anew")

    def lines(self) -> Iterator[bytes]:
        """Read the data line by line, without the ends of lines."""
        rest = b""
        for chunk in self.chunks():
            *whole, rest = (rest + chunk).split(b"\n")
            yield from whole
        if rest:
            yield rest


def write_shard(
    path: str | Path,
    run: Mapping[str, Any],
    number: int,
    of: int,
    kind: str,
    about: Mapping[str, Any],
    chunks: Callable[[], Iterable[bytes]],
) -> None:
    """Write a shard atomically; chunks: returns the data, which are read twice."""
    size, checksum = 0, 0
    for data in chunks():
        size, checksum = size + len(data), zlib.crc32(data, checksum)
    manifest = {"run": dict(run), "shard": number, "of": of, "kind": kind, "about": dict(about)}
    manifest |= {"bytes": size, "checksum": checksum}
    manifest["manifest_checksum"] = _checksum(manifest)
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        stream.write(_FIRST + json.dumps(manifest).encode() + b"\n")
        for data in chunks():
            stream.write(data)


def read_shard(path: Path) -> Shard:
    """Read the manifest of a shard. Raises FormatError unless the file is a whole one."""
    if read_bytes(path, len(_FIRST)) != _FIRST:
        raise FormatError(f"{path.name} is no shard; give files that were written with --shard")
    with path.open("rb") as stream:
        stream.seek(len(_FIRST))
        text = stream.readline(_MANIFEST)
        start, end = stream.tell(), stream.seek(0, 2)
    try:
        found = json.loads(text)
        run, about = dict(found["run"]), dict(found["about"])
        number, of, size, checksum = (found[key] for key in ("shard", "of", "bytes", "checksum"))
        if (
            found.pop("manifest_checksum") != _checksum(found)
            or not all(type(value) is int for value in (number, of, size, checksum))
            or not 1 <= number <= of
        ):
            raise ValueError("numbers")
    except (ValueError, KeyError, TypeError, RecursionError):
        raise FormatError(f"{path.name} is damaged: its second line does not say what it holds") from None
    if size != end - start:
        raise FormatError(f"{path.name} is damaged: it holds {end - start} bytes of data, not {size}; compute it anew")
    return Shard(path, run, number, of, str(found.get("kind")), about, start, size, checksum)


def read_shards(paths: Sequence[Path]) -> list[Shard]:
    """Read all shards of one run, in order. Raises FormatError if one is missing, twice or of another run."""
    shards = sorted((read_shard(path) for path in paths), key=lambda shard: shard.number)
    first = shards[0]
    for shard in shards[1:]:
        for name in sorted(first.run.keys() | shard.run.keys()):
            if first.run.get(name) != shard.run.get(name):
                raise FormatError(f"{shard.path.name} is of another run than {first.path.name}: its {name} differs")
        if (shard.of, shard.kind) != (first.of, first.kind):
            raise FormatError(f"{shard.path.name} is one of {shard.of}, {first.path.name} one of {first.of}")
    for one, next_one in pairwise(shards):
        if one.number == next_one.number:
            raise FormatError(f"shard {one.number} is there twice: {one.path.name} and {next_one.path.name}")
    if missing := sorted(set(range(1, first.of + 1)) - {shard.number for shard in shards}):
        listed = ", ".join(map(str, missing[:20])) + (", ..." if len(missing) > 20 else "")
        raise FormatError(f"of {first.of} shards, {len(missing)} are missing: {listed}")
    return shards


def join_shards(shards: Sequence[Shard], path: str | Path, start: bytes = b"") -> None:
    """Write first bytes and the data of the shards, in order, to a file atomically."""
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        stream.write(start)
        for shard in shards:
            for data in shard.chunks():
                stream.write(data)


def _checksum(manifest: Mapping[str, Any]) -> int:
    return zlib.crc32(json.dumps(manifest, sort_keys=True).encode())
