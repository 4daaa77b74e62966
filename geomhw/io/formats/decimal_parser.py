"""Numbers out of text, many at once: integers by numpy, decimals as integers over powers of ten.

Of ``-12.345`` the digits are the integer -12345, and the point says 10^3. The quotient is computed to twice the working
precision and then rounded; where that leaves two doubles to choose from, and for exponents and long numbers, Python's
own ``float`` decides. So each number is the double nearest to what is written, at a quarter of the usual time.
"""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.io.formats.uniform_lines import parse_regular

_SPACE, _POINT, _MINUS, _PLUS = 32, ord("."), ord("-"), ord("+")
#: Bytes parsed at a time: what is made of them stays in the processor's cache.
BLOCK = 1 << 17
#: All powers of ten that are doubles.
_POWERS = np.array([float(10**k) for k in range(23)])
#: Integers below this came whole out of a parser of 8 bytes, which stops at its largest.
_WHOLE = 10**18
#: Parts a double in two of 26 bits [Dekker 1971, eq. 5.6].
_SPLITTER = 2.0**27 + 1
#: More than the relative error of the second part of a quotient.
_DOUBT = 2.0**-50
#: Where more of the numbers than this are for ``float``, another parser is faster.
_FEW = 1 / 8


def parse_numbers(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    """Every number of a text that has some; None where one is none."""
    parts, regular = [], True
    for part in _blocks(text):
        values = parse_regular(part, kind) if regular else None
        regular = values is not None  # what has failed once would again
        if values is None and kind is np.float64:
            values = _decimals(part)
        values = _by_numpy(part, kind) if values is None else values
        if values is None:
            return None
        parts.append(values)
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


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


def _blocks(text: bytes) -> Iterator[bytes]:
    """The text in parts that end where a line does, if lines are of usual length."""
    begin = 0
    while len(text) - begin > BLOCK:
        end = text.find(b"\n", begin + BLOCK) + 1
        if not end:
            break
        yield text[begin:end]
        begin = end
    if begin < len(text):
        yield text[begin:] if begin else text


def _by_numpy(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # as numpy before 2.3 says that it stopped early
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except (ValueError, DeprecationWarning):
            return None


def _decimals(text: bytes) -> Floats | None:
    """The numbers of a text; None where one is none, and where most are such that this is not the way to read them."""
    if b"." not in text and b"-0" not in text:  # of which the integer 0 has no sign
        integers = _by_numpy(text, np.int64)
        if integers is not None and -_WHOLE < integers.min() <= integers.max() < _WHOLE:
            return integers.astype(np.float64)
    letters = np.frombuffer(text, np.uint8)
    starts, ends = _token_bounds(letters)
    plain, rare = text, np.empty(0, np.intp)
    if b"e" in text or b"E" in text:
        exponents = np.flatnonzero((letters | 32) == ord("e"))
        rare = np.unique(np.searchsorted(ends, exponents, side="right"))
        if len(rare) > _FEW * len(starts):
            return None
        plain = _zeroed(text, starts[rare], ends[rare])
    places = _decimal_places(np.frombuffer(plain, np.uint8), ends)
    integers = _by_numpy(plain.replace(b".", b""), np.int64) if places is not None else None
    if places is None or integers is None or len(integers) != len(ends):
        return None
    values, doubtful = _quotients(integers, places)
    doubtful |= (integers == 0) & (letters[starts] == _MINUS)  # -0.0
    doubtful[rare] = True
    return _decided(text, values, starts, ends, np.flatnonzero(doubtful))


def _token_bounds(letters: Ints) -> tuple[Ints, Ints]:
    """Where tokens begin, and where they end."""
    filled = np.zeros(len(letters) + 2, dtype=bool)
    np.greater(letters, _SPACE, out=filled[1:-1])
    bounds = np.flatnonzero(filled[1:] != filled[:-1])
    return bounds[::2], bounds[1::2]


def _zeroed(text: bytes, starts: Ints, ends: Ints) -> bytes:
    """The text with a zero in place of each of a few tokens."""
    changed = bytearray(text)
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        changed[start:end] = b"0".ljust(end - start)
    return bytes(changed)


def _decimal_places(letters: Ints, ends: Ints) -> Ints | None:
    """How many digits follow the point of each token; None where one has two points, or a sign after its point."""
    points = np.flatnonzero(letters == _POINT)
    places = np.zeros(len(ends), dtype=np.intp)
    if not len(points):
        return places
    after = letters[np.minimum(points + 1, len(letters) - 1)]
    if ((after == _MINUS) | (after == _PLUS)).any():
        return None
    if len(points) == len(ends) and (points < ends).all() and (points[1:] >= ends[:-1]).all():
        return np.asarray(ends - points - 1)
    owners = np.searchsorted(ends, points, side="right")
    if (owners[1:] == owners[:-1]).any():
        return None
    places[owners] = ends[owners] - points - 1
    return places


def _quotients(integers: Ints, places: Ints) -> tuple[Floats, NDArray[np.bool_]]:
    """integers / 10^places, to the nearest double, and where that is not certain.

    The integer is the sum of two doubles; the quotient of the first leaves a remainder that is a double too, and found
    exactly by Dekker's product [Dekker 1971, eq. 5.12]; remainder and second double give what is to be added.
    """
    d = _POWERS[np.minimum(places, len(_POWERS) - 1)]
    whole = np.clip(integers, -_WHOLE, _WHOLE)
    high = whole.astype(np.float64)
    low = (whole - high.astype(np.int64)).astype(np.float64)
    q = high / d
    product, error = _product(q, d)
    rest = ((high - product) - error + low) / d
    spread = rest * _DOUBT
    values = q + rest
    doubtful = (q + (rest - spread) != q + (rest + spread)) | (places >= len(_POWERS)) | (np.abs(whole) == _WHOLE)
    return values, doubtful


def _product(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """a b as a double and the rest of it, exactly."""
    p = a * b
    a1, b1 = _upper(a), _upper(b)
    a2, b2 = a - a1, b - b1
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


def _upper(a: Floats) -> Floats:
    """The 26 upper bits of doubles."""
    scaled = _SPLITTER * a
    return np.asarray(scaled - (scaled - a))


def _decided(text: bytes, values: Floats, starts: Ints, ends: Ints, doubted: Ints) -> Floats | None:
    """The values with those of a few tokens replaced by what ``float`` makes of them."""
    if len(doubted) > _FEW * len(values):
        return None
    try:
        for i in doubted.tolist():
            token = text[starts[i] : ends[i]]
            if b"_" in token:  # which Python takes, and files do not
                return None
            values[i] = float(token)
    except ValueError:
        return None
    return values
