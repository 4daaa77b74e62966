"""How long heat flows: from what a user writes to a diffusion time t."""

import math
import re
from dataclasses import dataclass

from geomhw.errors import ArgumentError

#: Diffusion times in h². Longer ones leave u constant up to rounding; shorter ones give the same directions of ∇u.
SHORTEST, LONGEST = 1e-60, 1e8
_MULTIPLE = re.compile(r"(?:(?P<factor>[^*]+)\*)?h2")


@dataclass(frozen=True)
class TimeStep:
    """A diffusion time t (length²), as it was asked for, and the reason for its value."""

    t: float
    asked: str
    reason: str

    def report(self, h: float) -> dict[str, float | str]:
        """Return plain values for a report: t/h², t, what was asked for, and the reason."""
        return {"t_over_h2": self.t / h**2, "t": self.t, "asked": self.asked, "reason": self.reason}


def given_time(asked: str | float, h: float) -> TimeStep:
    """Return the diffusion time on a surface of mean edge length h; as `time_step`, without ``auto``."""
    text = str(asked).strip()
    if text == "sqrt-h":
        step = TimeStep(math.sqrt(h), text, "√h, as asked")
    elif match := _MULTIPLE.fullmatch(text):
        factor = _positive(match["factor"] or "1", text)
        step = TimeStep(_positive(factor * h**2, text), text, f"{factor:g} h², as asked")
    else:
        step = TimeStep(_positive(text, text), text, "as asked")
    if not SHORTEST <= (multiple := step.t / h / h) <= LONGEST:
        raise ArgumentError(f"t = {step.t:g} is {multiple:.3g} h² on this mesh; give {SHORTEST:g} h² to {LONGEST:g} h²")
    return step


def _positive(number: str | float, text: str) -> float:
    """The number, if it is a time."""
    if len(text) > 100:
        text = f"{text[:40]} ... ({len(text)} characters)"
    try:
        value = float(number)
    except ValueError:
        known = "auto, sqrt-h, h2, a multiple such as 0.5*h2, or a number"
        raise ArgumentError(f"'{text}' is no time step; give {known}") from None
    if not 0 < value < math.inf:
        raise ArgumentError(f"the time step must be positive and finite, not {text}")
    return value
