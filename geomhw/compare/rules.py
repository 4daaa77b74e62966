"""Rules of a comparison: tolerances, and names to ignore."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from geomhw.errors import GeomhwError

#: Relative tolerance of arrays in double precision: larger than rounding on other machines, smaller than other results.
DOUBLE = 1e-9
#: Relative tolerance of arrays that a file stores in single precision, which rounds to 6e-8.
SINGLE = 1e-6
#: Weight of the heaviest spot that passes in a picture: two black pixels on white. Between one scene anti-aliased with
#: 4, 9 and 16 samples per pixel, spots weigh up to 170. An 8 in place of a 3 in a label 11 pixels high weighs 260, a
#: lost decimal point 280, a minus sign 380, an arrow 900 and more.
HEAVIEST_SPOT = 200.0
#: Entries of a report that differ between runs of one command.
DEFAULT_IGNORED = ("seconds", "files", "path", "file")


@dataclass(frozen=True)
class Tolerance:
    """Values a and b agree if |a - b| <= atol + rtol * scale, scale = largest finite magnitude in both arrays.

    One scale for a whole array: values near zero need the accuracy of the others. A value that blows up in one array
    does not pass, since it differs from the other by about the scale itself.

    Parameters
    ----------
    rtol : float, optional
        Relative tolerance. By default 1e-9, or 1e-6 if one of the arrays is stored in single precision.
    atol : float
        Absolute tolerance.

    Raises
    ------
    GeomhwError
        If a tolerance is negative or not finite.

    Examples
    --------
    >>> Tolerance(rtol=1e-6, atol=1e-3).allows(scale=1000.0)
    0.002
    """

    rtol: float | None = None
    atol: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("rtol", self.rtol), ("atol", self.atol)):
            if value is not None and not 0 <= value < float("inf"):
                raise GeomhwError(f"{name} is {value}; a tolerance is a number from 0 on")

    def allows(self, scale: float, single: bool = False) -> float:
        """Return the largest deviation that passes in arrays of that scale."""
        rtol = self.rtol if self.rtol is not None else (SINGLE if single else DOUBLE)
        return self.atol + rtol * scale


@dataclass(frozen=True)
class Ignored:
    """Patterns of names to leave out: ``*`` stands for any characters, ``?`` for one character.

    Examples
    --------
    >>> "heat_gradient" in Ignored(["heat*"])
    True
    >>> "answers[3].seconds" in Ignored(["answers[*].seconds"])
    True
    """

    patterns: tuple[str, ...]

    def __init__(self, patterns: Iterable[str] = ()) -> None:
        object.__setattr__(self, "patterns", tuple(patterns))

    def __contains__(self, name: object) -> bool:
        return any(re.fullmatch(_expression(pattern), str(name), re.DOTALL) for pattern in self.patterns)

    def __add__(self, patterns: Iterable[str]) -> "Ignored":
        return Ignored([*self.patterns, *patterns])


def _expression(pattern: str) -> str:
    """Convert to a regular expression; fnmatch would take the brackets of ``answers[0]`` for a set of characters."""
    return re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".")
