"""How long heat flows: from what a user writes to a diffusion time t."""

import math
import re
from dataclasses import dataclass

from geomhw.errors import FieldError
from geomhw.mesh.polyhedral import PolyhedralSurface

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


def time_step(asked: str | float, surface: PolyhedralSurface) -> TimeStep:
    """Return the diffusion time on a surface of mean edge length h.

    Parameters
    ----------
    asked : ``h2`` (t = h², [GIH, sec. 3.2.4]), ``sqrt-h`` (t = √h, the course handout's, which depends on the unit of
        length), a multiple such as ``0.5*h2``, a positive number (length²), or ``auto``: √h where that is near h² and
        at least as accurate on this surface (`auto_time`), else h².

    Raises
    ------
    FieldError
        For anything else, and for a time that is zero, infinite or out of the range of numbers.
    """
    text, h = str(asked).strip(), surface.mean_edge_length
    if text == "auto":
        from geomhw.geodesic.auto_time import auto_time

        return auto_time(surface)
    if text == "sqrt-h":
        return TimeStep(math.sqrt(h), text, "√h, as asked")
    if match := _MULTIPLE.fullmatch(text):
        factor = _positive(match["factor"] or "1", text)
        return TimeStep(_positive(factor * h**2, text), text, f"{factor:g} h², as asked")
    return TimeStep(_positive(text, text), text, "as asked")


def _positive(number: str | float, text: str) -> float:
    """The number, if it is a time."""
    if len(text) > 100:
        text = f"{text[:40]} ... ({len(text)} characters)"
    try:
        value = float(number)
    except ValueError:
        known = "auto, sqrt-h, h2, a multiple such as 0.5*h2, or a number"
        raise FieldError(f"'{text}' is no time step; give {known}") from None
    if not 0 < value < math.inf:
        raise FieldError(f"the time step must be positive and finite, not {text}")
    return value
