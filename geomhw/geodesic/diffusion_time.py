"""How long heat flows: the one place that turns ``--time`` and ``--dt`` into a number."""

import math
import re
from dataclasses import dataclass

from geomhw.errors import FieldError

_MULTIPLE = re.compile(r"(?:(?P<factor>[^*]+)\*)?h2")


@dataclass(frozen=True)
class TimeStep:
    """A diffusion time t (length²), how it was asked for, and why it came out so."""

    t: float
    asked: str
    reason: str

    def report(self, h: float) -> dict[str, float | str]:
        """Plain values for a report: t, t/h², and the reason."""
        return {"t": self.t, "t_over_h2": self.t / h**2, "asked": self.asked, "reason": self.reason}


def time_step(asked: str | float, h: float) -> TimeStep:
    """The time for a mesh of mean edge length h.

    asked: ``auto``, ``sqrt-h`` (t = √h, as in the course handout), ``h2`` (t = h² [GIH, sec. 3.2.4]), a multiple such
    as ``0.5*h2``, or a positive number. ``auto`` is √h while that is a short time, 0.1 h² ≤ √h ≤ 4 h², else h²: √h has
    no meaning for lengths in other units. FieldError for anything else.
    """
    text = str(asked).strip()
    if text == "auto":
        ratio = math.sqrt(h) / h**2
        if 0.1 <= ratio <= 4:
            return TimeStep(math.sqrt(h), text, f"√h, which is {ratio:.3g} h² here, a short time")
        return TimeStep(h**2, text, f"h², since √h is {ratio:.3g} h² here, not a short time")
    if text == "sqrt-h":
        return TimeStep(math.sqrt(h), text, "√h, as asked")
    if match := _MULTIPLE.fullmatch(text):
        factor = _positive(match["factor"] or "1", text)
        return TimeStep(factor * h**2, text, f"{factor:g} h², as asked")
    return TimeStep(_positive(text, text), text, "as asked")


def _positive(number: str, text: str) -> float:
    try:
        value = float(number)
    except ValueError:
        known = "auto, sqrt-h, h2, a multiple such as 0.5*h2, or a number"
        raise FieldError(f"'{text}' is no time step; give {known}") from None
    if not (0 < value < math.inf):
        raise FieldError(f"the time step must be positive and finite, not {text}")
    return value
