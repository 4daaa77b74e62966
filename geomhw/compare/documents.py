"""Comparison of JSON documents, value by value."""

import math
from collections.abc import Iterator
from typing import Any

from geomhw.compare.arrays import compare_arrays
from geomhw.compare.findings import Finding
from geomhw.compare.rules import Ignored, Tolerance
from geomhw.errors import FormatError


def compare_documents(one: Any, other: Any, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    """Return a finding for each value, named by its path, such as ``mesh.vertices`` or ``answers[0].distance``.

    A list of numbers, or of lists of numbers of equal length, is an array with one scale; any other number has its own
    scale. Patterns of ``ignored`` match names or paths, and leave out everything inside.
    """
    try:
        return list(_compare("", one, other, tolerance, ignored))
    except RecursionError:
        raise FormatError("the documents are nested too deeply to be compared") from None


def _compare(path: str, one: Any, other: Any, tolerance: Tolerance, ignored: Ignored) -> Iterator[Finding]:
    """Yield the findings of the values at a path and below."""
    name = path or "document"
    if isinstance(one, dict) and isinstance(other, dict):
        for key in [*one, *(key for key in other if key not in one)]:
            inner = f"{path}.{key}" if path else key
            if key in ignored or inner in ignored:
                continue
            if key in one and key in other:
                yield from _compare(inner, one[key], other[key], tolerance, ignored)
            else:
                yield Finding(inner, "value", False, note=f"only in {'A' if key in one else 'B'}")
    elif _shape(one) is not None and _shape(other) is not None:
        yield compare_arrays(name, "value", one, other, tolerance)
    elif isinstance(one, list) and isinstance(other, list):
        if len(one) != len(other):
            yield Finding(name, "value", False, note=f"{len(one)} entries in A, {len(other)} in B")
        for i, (a, b) in enumerate(zip(one, other, strict=False)):
            if f"{path}[{i}]" not in ignored:
                yield from _compare(f"{path}[{i}]", a, b, tolerance, ignored)
    else:
        same = type(one) is type(other) and one == other
        yield Finding(name, "value", same, values=None if same else (_short(one), _short(other)))


def _shape(value: Any) -> tuple[int, ...] | None:
    """Return the shape of a number or of nested lists of numbers; None if ragged or of anything else."""
    if isinstance(value, list):
        shapes = {_shape(item) for item in value}
        inner = shapes.pop() if len(shapes) == 1 else None
        return None if inner is None else (len(value), *inner)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return () if is_number and (isinstance(value, float) or abs(value) < 2**63) else None


def _short(value: Any) -> Any:
    """Return a plain value as it is, a list or an object by its length."""
    if isinstance(value, dict | list):
        return f"{'an object' if isinstance(value, dict) else 'a list'} of {len(value)}"
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value
