"""Damaged files: bytes flipped, lines and blocks moved, numbers made huge, ends cut off; the same for the same seed."""

import random
import re
from collections.abc import Callable

_NUMBER = re.compile(rb"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]{2,}")
#: What a count, an index or a coordinate may be that nobody thought of.
NUMBERS = [
    b"0", b"-1", b"1", b"2", b"3", b"4", b"127", b"128", b"255", b"256", b"65536", b"1000000", b"2147483647",
    b"2147483648", b"-2147483649", b"4294967295", b"4294967296", b"1000000000000", b"9223372036854775807",
    b"9223372036854775808", b"-9223372036854775808", b"18446744073709551616", b"9" * 40, b"9" * 5000, b"nan", b"-inf",
    b"1e308", b"1e400", b"-1e-320", b"0.5", b"1.5", b"0x10", b"1_000", b"1,5", b"", b"\xd9\xa3",
]  # fmt: skip
_BYTES = [bytes([letter]) for letter in b'\0\xff\n\r \t#/"<>&=\x1a'] + [b"\r\n", b"\\\n", b"\xef\xbb\xbf"]
_WIDTHS = (1, 2, 4, 8)


def mutated(seeds: list[bytes], random_: random.Random, most: int = 1 << 16) -> bytes:
    """One of the seeds, damaged once or several times."""
    data = random_.choice(seeds)
    for _ in range(1 + int(random_.expovariate(0.7))):
        data = random_.choice(_DAMAGES)(data, random_, seeds)
    return data[:most]


def _span(data: bytes, random_: random.Random, most: int = 64) -> tuple[int, int]:
    begin = random_.randrange(len(data) + 1)
    return begin, min(len(data), begin + random_.randint(0, most))


def _number(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    """A number of the file made another."""
    places = list(_NUMBER.finditer(data[:4096] if random_.random() < 0.8 else data))
    if not places:
        return data
    place = random_.choice(places)
    return data[: place.start()] + random_.choice(NUMBERS) + data[place.end() :]


def _word(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    """A word of the file in place of another."""
    places = list(_WORD.finditer(data[:8192]))
    others = list(_WORD.finditer(random_.choice(seeds)[:8192]))
    if not places or not others:
        return data
    place = random_.choice(places)
    return data[: place.start()] + random_.choice(others)[0] + data[place.end() :]


def _integer(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    """A binary integer of any width and order written over what is there."""
    width = random_.choice(_WIDTHS)
    value = random_.choice([0, 1, 2, 3, -1, 1 << (8 * width - 1), (1 << (8 * width - 1)) - 1, random_.getrandbits(16)])
    coded = (value % (1 << (8 * width))).to_bytes(width, random_.choice(["little", "big"]))
    at = random_.randrange(len(data) + 1)
    return data[:at] + coded + data[at + width :]


def _flip(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    if not data:
        return data
    changed = bytearray(data)
    changed[random_.randrange(len(data))] ^= 1 << random_.randrange(8)
    return bytes(changed)


def _insert(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    at = random_.randrange(len(data) + 1)
    return data[:at] + random_.choice(_BYTES) * random_.choice([1, 1, 1, 3, 50]) + data[at:]


def _delete(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    begin, end = _span(data, random_)
    return data[:begin] + data[end:]


def _repeat(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    begin, end = _span(data, random_)
    return data[:end] + data[begin:end] * random_.choice([1, 2, 30]) + data[end:]


def _cut(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    return data[: random_.randrange(len(data) + 1)]


def _line(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    """A line lost, doubled, moved, or taken from another file."""
    lines = data.split(b"\n")
    i, j = random_.randrange(len(lines)), random_.randrange(len(lines))
    match random_.randrange(4):
        case 0:
            del lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case _:
            lines.insert(i, random_.choice(random_.choice(seeds).split(b"\n")))
    return b"\n".join(lines)


def _splice(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    """The head of one file and the tail of another."""
    other = random_.choice(seeds)
    return data[: random_.randrange(len(data) + 1)] + other[random_.randrange(len(other) + 1) :]


def _noise(data: bytes, random_: random.Random, seeds: list[bytes]) -> bytes:
    begin, end = _span(data, random_)
    return data[:begin] + random_.randbytes(end - begin) + data[end:]


_Damage = Callable[[bytes, random.Random, list[bytes]], bytes]
_DAMAGES: list[_Damage] = [_number, _number, _number, _word, _integer, _flip, _flip, _insert, _delete, _repeat]
_DAMAGES += [_cut, _line, _splice, _noise]
