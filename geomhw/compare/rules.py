"""How far apart numbers may be, and which names do not count."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from geomhw.errors import GeomhwError

#: Relative tolerance of what is held in double precision: rounding of other machines passes, other results do not.
DOUBLE = 1e-9
#: The same of what one of the files holds in single precision, which is rounded to 6e-8.
SINGLE = 1e-6
#: Of a report, what differs between runs of one command: how long it took, and where its files are.
DEFAULT_IGNORED = ("seconds", "files", "path", "file")


@dataclass(frozen=True)
class Tolerance:
    """a and b agree where |a - b| <= atol + rtol * scale, ``scale`` being the largest finite magnitude in the arrays.

    One scale for a whole array, so that values which pass through zero are held to the accuracy of the others. It is
    taken from both arrays; that one of them blows up does not let it pass, since the blown-up value itself is then a
    whole scale away from the other.

    rtol: None takes ``DOUBLE``, or ``SINGLE`` where one of the arrays is stored in single precision.
    """

    rtol: float | None = None
    atol: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("rtol", self.rtol), ("atol", self.atol)):
            if value is not None and not 0 <= value < float("inf"):
                raise GeomhwError(f"{name} is {value}; a tolerance is a number from 0 on")

    def allows(self, scale: float, single: bool = False) -> float:
        """The largest deviation that passes in arrays of that scale."""
        rtol = self.rtol if self.rtol is not None else (SINGLE if single else DOUBLE)
        return self.atol + rtol * scale


@dataclass(frozen=True)
class Ignored:
    """Names that are left out, with ``*`` and ``?`` for any letters and any letter.

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
    """As a regular expression. Not fnmatch, to which the brackets of ``answers[0]`` are a choice of letters."""
    return re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".")
