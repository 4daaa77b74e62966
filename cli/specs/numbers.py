"""Numbers as written on the command line: whole or real, within the range that some run can use."""

import math
from typing import Any

import click

from geomhw.options import MAX_STEPS

#: Magnitudes beyond these have no use at any scale of a mesh.
SMALLEST, LARGEST = 1e-100, 1e100
#: Digits of a whole number, at most: it fits into 64 bits.
_DIGITS = 18
_SHOWN = 60


class Number(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    """A number from low to high; with ``or_zero`` also zero below low, with ``whole`` without a fraction."""

    name = "number"

    def __init__(self, low: float, high: float, *, whole: bool = False, or_zero: bool = False) -> None:
        self.low, self.high, self.whole, self.or_zero = low, high, whole, or_zero

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number; a wrong one is a usage error."""
        try:
            number = whole_number(str(value)) if self.whole else float(value)
        except ValueError:
            number = math.nan
        if not (self.low <= number <= self.high or (self.or_zero and number == 0)):
            kind = "whole number" if self.whole else "number"
            zero = "0 or " if self.or_zero else ""
            bounds = f" from {self.low:.10g}" if self.low > -math.inf else ""
            bounds += f" to {self.high:.10g}" if self.high < math.inf else " on" if bounds else ""
            self.fail(f"'{excerpt(str(value))}' is not {zero}a {kind}{bounds}.")
        return number


POSITIVE = Number(SMALLEST, LARGEST)
COUNT = Number(1, MAX_STEPS, whole=True)


def whole_number(text: str) -> int:
    """Return a whole number of at most 18 digits; ValueError for anything else."""
    text = text.strip()
    sign, digits = text[: text.startswith(("+", "-"))], text.lstrip("+-")
    if not (digits.isascii() and digits.isdecimal() and len(digits) <= _DIGITS and text == sign + digits):
        raise ValueError(f"'{excerpt(text)}' is no whole number of at most {_DIGITS} digits")
    return int(text)


def excerpt(text: str) -> str:
    """Return a text shortened for a message."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}... ({len(text)} characters)"
