"""Numbers in text: each value is the nearest double, or the exact integer of 8 bytes.

numpy parses short texts. Compiled loops parse long ones in a third of the time, but take a while to load.
"""

import re
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Bytes of a text from which on compiled loops pay.
LONG = 1 << 22
#: Smaller integers were not clipped by the integer parser, which stops at its largest value.
_LIMIT = 10**18
#: The integer parser would read "- 2" as one number, and "-" as 0.
_LONE_SIGN = re.compile(rb"[+-](\s|$)")


def parse_numbers(text: bytes, kind: type[Any], size: int = 0) -> NDArray[Any] | None:
    """Return all numbers of a text as ``kind``, float64 or int64, one for each token; None where a token is no number.

    size: bytes of the whole text, of which this is a part.
    """
    if not text or text.isspace():
        return np.empty(0, kind)
    if max(size, len(text)) >= LONG:
        from geomhw.io.formats.decimal_numbers import parse_long

        if (values := parse_long(text, kind)) is not None:
            return values
    # Integers parse three times as fast as decimals; only -0 needs the other parser.
    if kind is np.float64 and b"." not in text and b"-0" not in text:
        integers = _from_text(text, np.int64)
        if integers is not None and -_LIMIT < integers.min() <= integers.max() < _LIMIT:
            return integers.astype(np.float64)
    return _from_text(text, kind)


def parse_array(text: bytes, kind: np.dtype[Any]) -> NDArray[Any]:
    """Return all numbers of a text in a declared type; ValueError where one is not a number or does not fit."""
    values = parse_numbers(text, np.int64) if kind.kind in "iu" else None
    if values is None:
        values = parse_numbers(text, np.float64)
    if values is None:
        raise ValueError("something among its numbers is not a number")
    return cast_exactly(values, kind)


def cast_exactly(values: NDArray[Any], kind: np.dtype[Any]) -> NDArray[Any]:
    """Cast parsed numbers to a declared type; ValueError where an integer type cannot hold one.

    Values beyond the range of a float type become infinite.
    """
    if kind.kind in "iu":
        limits = np.iinfo(kind)
        bad = (values != np.floor(values)) | (values < limits.min) | (values > limits.max)
        if bad.any():
            raise ValueError(f"{values[np.argmax(bad)]:.20g} is not an integer of {kind.itemsize} bytes")
    with np.errstate(over="ignore"):
        return values.astype(kind, copy=False)


def _from_text(text: bytes, kind: type[Any]) -> NDArray[Any] | None:
    """Parse with numpy; None where it stops early."""
    if kind is np.int64 and (b"-" in text or b"+" in text) and _LONE_SIGN.search(text):
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # numpy before 2.3 warns and returns what it has
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except (ValueError, DeprecationWarning):
            return None
