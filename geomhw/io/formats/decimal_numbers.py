"""Decimal numbers and tokens of long texts, as compiled loops; each number is the nearest double.

Clinger: How to Read Floating Point Numbers Accurately. PLDI 1990 (exact powers of ten).
Lemire: Number Parsing at a Gigabyte per Second. Software: Practice and Experience 51(8), 2021 (all others).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.compiled import compiled, compiled_in_place

#: Exponents of ten for which a product with 128 bits of the power of five is accurate enough.
_LEAST, _MOST = -342, 308
#: Digits that fit into 64 bits, and into a signed integer of 64 bits.
_DIGITS, _INTEGER_DIGITS = 19, 18
_EXACT_TENS = 10.0 ** np.arange(23)
_LOW_32, _ROUNDING = np.uint64(0xFFFFFFFF), np.uint64(0x1FF)
_ONE, _THREE, _SHIFT, _HALF = np.uint64(1), np.uint64(3), np.uint64(9), np.uint64(32)
_IMPLICIT, _ONES = np.uint64(1 << 52), np.uint64(2**64 - 1)


def _power_of_five(q: int) -> int:
    """The leading 128 bits of 5^q: rounded down, or up for negative q."""
    five = 5 ** abs(q)
    if q >= 0:
        return five << (128 - five.bit_length()) if five.bit_length() <= 128 else five >> (five.bit_length() - 128)
    bits = (five - 1).bit_length()
    power = (1 << (bits + 127 if q >= -27 else 2 * bits + 128)) // five + 1
    return power >> max(power.bit_length() - 128, 0)


_FIVES = np.array([divmod(_power_of_five(q), 1 << 64) for q in range(_LEAST, _MOST + 1)], np.uint64)


def parse_long(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    """Return all numbers of a text as float64 or int64; None where one token is no number, or needs another parser."""
    values = np.empty(len(text) // 2 + 1, kind)
    letters = np.frombuffer(text, np.uint8)
    count = _integers(letters, values) if kind is np.int64 else _decimals(letters, values, values.view(np.uint64))
    return None if count < 0 else values[:count].copy()


@compiled
def token_lines(letters: NDArray[np.uint8]) -> tuple[Ints, Ints]:
    """Return for each line with tokens the offset of the first one, and the number of them."""
    size = len(letters) // 2 + 1
    heads, counts = np.empty(size, np.int64), np.empty(size, np.int64)
    lines, tokens, is_inside = 0, 0, False
    for i, letter in enumerate(letters):
        if letter > 32:
            if not is_inside:
                if tokens == 0:
                    heads[lines] = i
                tokens += 1
            is_inside = True
        else:
            is_inside = False
            if letter == 10 and tokens:
                counts[lines] = tokens
                lines, tokens = lines + 1, 0
    if tokens:
        counts[lines] = tokens
        lines += 1
    return heads[:lines].copy(), counts[:lines].copy()


@compiled_in_place
def _is_blank(letter: int) -> bool:
    return letter == 32 or 9 <= letter <= 13


@compiled_in_place
def _integers(letters: Ints, values: Ints) -> int:
    """Parse integers; return their number, or -1 at a token that is no integer or has too many digits."""
    count, i, n = 0, 0, len(letters)
    while i < n:
        if _is_blank(letters[i]):
            i += 1
            continue
        negative = letters[i] == 45
        if negative or letters[i] == 43:
            i += 1
        value, begin = np.int64(0), i
        while i < n and 48 <= letters[i] <= 57:
            value = 10 * value + np.int64(letters[i]) - 48
            i += 1
        if not 0 < i - begin <= _INTEGER_DIGITS or (i < n and not _is_blank(letters[i])):
            return -1
        values[count] = -value if negative else value
        count += 1
    return count


@compiled_in_place
def _decimals(letters: Ints, values: NDArray[np.float64], bits: NDArray[np.uint64]) -> int:
    """Parse decimals into values, which share memory with bits; return their number, or -1 as `parse_long` does."""
    count, i, n = 0, 0, len(letters)
    while i < n:
        if _is_blank(letters[i]):
            i += 1
            continue
        negative = letters[i] == 45
        if negative or letters[i] == 43:
            i += 1
        mantissa, digits, seen, exponent, is_fraction = np.uint64(0), 0, 0, 0, False
        while i < n:
            letter = letters[i]
            if 48 <= letter <= 57:
                mantissa = np.uint64(10) * mantissa + np.uint64(letter - 48)
                digits += mantissa > 0
                seen += 1
                exponent -= is_fraction
            elif letter == 46 and not is_fraction:
                is_fraction = True
            else:
                break
            i += 1
        if i < n and (letters[i] | 32) == 101 and seen > 0:
            i += 1
            is_down = i < n and letters[i] == 45
            if is_down or (i < n and letters[i] == 43):
                i += 1
            power, begin = 0, i
            while i < n and 48 <= letters[i] <= 57 and i - begin < 5:
                power = 10 * power + letters[i] - 48
                i += 1
            if i == begin:
                return -1
            exponent += -power if is_down else power
        if seen == 0 or digits > _DIGITS or (i < n and not _is_blank(letters[i])):
            return -1
        if mantissa >> np.uint64(53) == 0 and -22 <= exponent <= 22:
            value = np.float64(mantissa)
            value = value / _EXACT_TENS[-exponent] if exponent < 0 else value * _EXACT_TENS[exponent]
            values[count] = -value if negative else value
        elif mantissa == 0:
            values[count] = -0.0 if negative else 0.0
        else:
            double = _nearest_double(mantissa, exponent)
            if double == _ONES:
                return -1
            bits[count] = double | (np.uint64(negative) << np.uint64(63))
        count += 1
    return count


@compiled_in_place
def _nearest_double(w: np.uint64, q: int) -> np.uint64:
    """The bits of the double nearest to w 10^q; all ones if it is not normal, or if 128 bits do not decide."""
    if not _LEAST <= q <= _MOST:
        return _ONES
    zeros = 0
    while w >> np.uint64(63) == 0:
        w <<= _ONE
        zeros += 1
    high, low = _product(w, _FIVES[q - _LEAST, 0])
    if high & _ROUNDING == _ROUNDING:
        more, _ = _product(w, _FIVES[q - _LEAST, 1])
        low += more
        high += np.uint64(low < more)
        if low == _ONES and not -27 <= q <= 55:
            return _ONES
    top = high >> np.uint64(63)
    shift = top + _SHIFT
    m = high >> shift
    exponent = ((217706 * q) >> 16) + 63 + np.int64(top) - zeros + 1023
    if exponent <= 0:
        return _ONES
    if low <= _ONE and -4 <= q <= 23 and m & _THREE == _ONE and m << shift == high:
        m ^= _ONE  # halfway between two doubles: to the even one
    m = (m + (m & _ONE)) >> _ONE
    if m >> np.uint64(53):
        m, exponent = _IMPLICIT, exponent + 1
    if exponent >= 2047:
        return _ONES
    return (m ^ _IMPLICIT) | (np.uint64(exponent) << np.uint64(52))


@compiled_in_place
def _product(a: np.uint64, b: np.uint64) -> tuple[np.uint64, np.uint64]:
    """The higher and lower half of a product of 128 bits."""
    a1, a0, b1, b0 = a >> _HALF, a & _LOW_32, b >> _HALF, b & _LOW_32
    middle = a1 * b0 + ((a0 * b0) >> _HALF)
    cross = a0 * b1 + (middle & _LOW_32)
    return a1 * b1 + (middle >> _HALF) + (cross >> _HALF), a * b
