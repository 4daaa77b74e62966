"""Findings of a comparison, as data, as JSON and as text."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Finding:
    """The comparison of two arrays of one name: the largest deviation and its place.

    Attributes
    ----------
    name : str
    location : str
        ``vertex``, ``face``, ``mesh``, ``column``, ``value``, ``array``, ``matrix``, ``series`` or ``picture``.
    same : bool
    size : tuple of int
        Shape of both arrays.
    absolute, relative : float
        Largest |a - b|, and its ratio to the scale of the arrays.
    tolerance : float
        Largest absolute deviation that passes.
    beyond : int
        Number of values that deviate by more.
    index, values : tuple or None
        Index of the largest deviation, and the values of A and B there.
    frame : int or None
        Frame of a time series.
    note : str
        Difference that is not a number, such as unequal shapes.
    details : dict
        Spots of a picture.
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
        """Sort key, the worst last: whether it differs, then the ratio of the deviation to the tolerance."""
        if self.absolute == 0:
            return not self.same, 0.0
        return not self.same, self.absolute / self.tolerance if self.tolerance else math.inf

    def as_json(self) -> dict[str, Any]:
        """Return plain JSON values: nan, inf and -inf as text, complex numbers as [re, im]."""
        return {key: _plain(value) for key, value in asdict(self).items() if value not in (None, "", {})}

    def describe(self) -> str:
        """Return the largest deviation, its place and the two values as text; without these, the note."""
        frame = "" if self.frame is None else f"frame {self.frame}"
        if self.location == "picture" or not (self.absolute or self.values):
            return ": ".join(filter(None, (frame if self.note else "", self.note or "equal")))
        parts = []
        if self.absolute:
            parts.append(f"{self.absolute:.3g} absolute, {self.relative:.3g} relative")
        place = " ".join(filter(None, (frame, f"[{', '.join(map(str, self.index))}]" if self.index else "")))
        if self.values:
            a, b = map(_shortened, self.values)
            parts.append(f"{f'at {place}: ' if place else ''}{a} in A, {b} in B")
        if self.beyond > 1:
            parts.append(f"{self.beyond} values beyond {self.tolerance:.3g}")
        return "; ".join([*parts, *([self.note] if self.note else [])])


@dataclass(frozen=True)
class Comparison:
    """All findings of the comparison of two files; ``print`` it for a table of them and the verdict.

    Attributes
    ----------
    kind : str
        ``mesh``, ``series``, ``table``, ``document``, ``arrays`` or ``picture``.
    findings : sequence of Finding

    Examples
    --------
    >>> print(Comparison("table", [Finding("x", "column", True, (4,))]))
    same  column  x  4  equal
    same: 1 compared
    """

    kind: str
    findings: Sequence[Finding]

    @property
    def different(self) -> list[Finding]:
        """The findings that differ."""
        return [finding for finding in self.findings if not finding.same]

    @property
    def same(self) -> bool:
        """Whether no finding differs."""
        return not self.different

    def __str__(self) -> str:
        rows = [
            ("same" if f.same else "different", f.location, f.name, " x ".join(map(str, f.size)), f.describe())
            for f in self.findings
        ]
        widths = [max((len(row[k]) for row in rows), default=0) for k in range(4)]
        lines = ["  ".join([*map(str.ljust, row, widths), row[4]]).rstrip() for row in rows]
        different = len(self.different)
        verdict = f"different: {different} of {len(rows)} differ" if different else f"same: {len(rows)} compared"
        return "\n".join([*lines, verdict])


def _plain(value: Any) -> Any:
    """Convert to what JSON can hold."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _shortened(value: Any) -> str:
    """Return ``repr`` with all digits of a number; long texts are cut."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
