"""What a comparison found, array by array."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Finding:
    """Two arrays of one name, and where they are farthest apart.

    location: ``vertex``, ``face``, ``mesh``, ``column``, ``value``, ``array``, ``picture`` ...
    size: shape of both arrays. absolute, relative: the worst |a - b|, and that over the scale of the array.
    tolerance: what would have passed. beyond: how many values are farther apart than that.
    index, values: where the worst deviation is, and the value in A and in B there. frame: the frame of a series.
    note: what there is to say beyond, or in place of, numbers. details: of a picture.
    """

    name: str
    location: str
    same: bool
    size: tuple[int, ...] = ()
    absolute: float = 0.0
    relative: float = 0.0
    tolerance: float = 0.0
    beyond: int = 0
    index: tuple[int, ...] | None = None
    values: tuple[Any, Any] | None = None
    frame: int | None = None
    note: str = ""
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def badness(self) -> tuple[bool, float]:
        """For the worst of several: those that differ first, then by how many times the tolerance is used up."""
        if self.absolute == 0:
            return not self.same, 0.0
        return not self.same, self.absolute / self.tolerance if self.tolerance else math.inf

    def as_json(self) -> dict[str, Any]:
        """Plain values for a report; what is not finite as the words nan, inf and -inf, what is complex as [re, im]."""
        return {key: _plain(value) for key, value in asdict(self).items() if value not in (None, "", {})}


@dataclass(frozen=True)
class Comparison:
    """All findings on two files. kind: what the files are."""

    kind: str
    findings: Sequence[Finding]

    @property
    def different(self) -> list[Finding]:
        """Those that say no."""
        return [finding for finding in self.findings if not finding.same]

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.different


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value
