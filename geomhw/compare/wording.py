"""Findings as lines to read."""

from typing import Any

from geomhw.compare.findings import Comparison, Finding


def lines(comparison: Comparison) -> list[str]:
    """A line for each finding, in columns, and a last one with the verdict."""
    rows = [
        ("same" if f.same else "different", f.location, f.name, " x ".join(map(str, f.size)), _describe(f))
        for f in comparison.findings
    ]
    widths = [max((len(row[k]) for row in rows), default=0) for k in range(4)]
    told = ["  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[4]]) for row in rows]
    return [*(line.rstrip() for line in told), verdict(comparison)]


def verdict(comparison: Comparison) -> str:
    """The last line: of how many, how many differ."""
    count, different = len(comparison.findings), len(comparison.different)
    return f"different: {different} of {count} differ" if different else f"same: {count} compared"


def _describe(finding: Finding) -> str:
    """The worst deviation, where it is and what is there; or the note alone."""
    if finding.location == "picture" or not (finding.absolute or finding.values):
        return ": ".join(filter(None, (_frame(finding) if finding.note else "", finding.note or "equal")))
    parts = []
    if finding.absolute:
        parts.append(f"{finding.absolute:.3g} absolute, {finding.relative:.3g} relative")
    place = " ".join(part for part in (_frame(finding), _index(finding)) if part)
    if finding.values:
        a, b = (_value(value) for value in finding.values)
        parts.append(f"{f'at {place}: ' if place else ''}{a} in A, {b} in B")
    if finding.beyond > 1:
        parts.append(f"{finding.beyond} values beyond {finding.tolerance:.3g}")
    return "; ".join([*parts, *([finding.note] if finding.note else [])])


def _frame(finding: Finding) -> str:
    return "" if finding.frame is None else f"frame {finding.frame}"


def _index(finding: Finding) -> str:
    return f"[{', '.join(map(str, finding.index))}]" if finding.index else ""


def _value(value: Any) -> str:
    """With all its digits; long texts cut short."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
