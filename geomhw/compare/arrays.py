"""Two arrays, and two collections of arrays by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geomhw.compare.findings import Finding
from geomhw.compare.rules import Ignored, Tolerance

_EXACT = "iub"
_NUMBERS = "iubfc"


def compare_arrays(
    name: str,
    location: str,
    one: ArrayLike,
    other: ArrayLike,
    tolerance: Tolerance,
    *,
    scale: float | None = None,
    single: bool = False,
) -> Finding:
    """Where arrays are farthest apart, and whether that passes. NaN equals NaN, inf equals inf of the same sign.

    Whole numbers and texts pass only if they are equal; whole numbers beside others count as numbers.

    scale: what ``rtol`` refers to; None takes the largest finite magnitude in the arrays. single: one of them comes
    from single precision, whatever its type is now.
    """
    a, b = _column(np.asarray(one)), _column(np.asarray(other))
    if a.shape != b.shape:
        return Finding(name, location, False, note=f"{_shape(a)} in A, {_shape(b)} in B")
    numbers = [array.dtype.kind in _NUMBERS for array in (a, b)]
    if not all(numbers):
        return _compare_texts(name, location, a, b, numbers)
    single = single or _is_single(a) or _is_single(b)
    exact = a.dtype.kind in _EXACT and b.dtype.kind in _EXACT
    scale = _magnitude(a, b) if scale is None else scale
    allowed = 0.0 if exact else tolerance.allows(scale, single)
    deviation = _deviation(a, b, exact)
    beyond = (deviation > allowed) | np.isinf(deviation)
    if not deviation.size or not (worst := float(deviation.max())):
        return Finding(name, location, True, a.shape, tolerance=allowed)
    index = tuple(int(i) for i in np.unravel_index(int(deviation.argmax()), a.shape))
    return Finding(
        name,
        location,
        not beyond.any(),
        a.shape,
        worst,
        worst / scale if scale else float("inf"),
        allowed,
        int(np.count_nonzero(beyond)),
        index,
        (a[index].item(), b[index].item()),
    )


def compare_named(
    location: str,
    one: Mapping[str, ArrayLike],
    other: Mapping[str, ArrayLike],
    tolerance: Tolerance,
    ignored: Ignored,
    single: frozenset[str] = frozenset(),
) -> list[Finding]:
    """A finding for each name, in the order of the first collection; a name that only one of them has is a difference.

    single: names of arrays that come from single precision.
    """
    findings = [
        compare_arrays(name, location, one[name], other[name], tolerance, single=name in single)
        for name in one
        if name in other and name not in ignored
    ]
    return findings + missing(location, one, other, ignored)


def missing(location: str, one: Mapping[str, Any], other: Mapping[str, Any], ignored: Ignored) -> list[Finding]:
    """A finding for each name that is on one side only."""
    sides = (("A", [n for n in one if n not in other]), ("B", [n for n in other if n not in one]))
    return [
        Finding(name, location, False, note=f"only in {side}")
        for side, names in sides
        for name in names
        if name not in ignored
    ]


def _column(array: NDArray[Any]) -> NDArray[Any]:
    """(n, 1) as (n,): formats differ in which of them they write."""
    return array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array


def _shape(array: NDArray[Any]) -> str:
    return " x ".join(map(str, array.shape)) or "one value"


def _is_single(array: NDArray[Any]) -> bool:
    return array.dtype in (np.float16, np.float32, np.complex64)


def _magnitude(*arrays: NDArray[Any]) -> float:
    """The largest finite magnitude."""
    tops = []
    for array in arrays:
        size = np.abs(_doubled(array, array.dtype.kind == "c"))
        tops.append(float(size.max(initial=0.0, where=np.isfinite(size))))
    return max(tops)


def _deviation(a: NDArray[Any], b: NDArray[Any], exact: bool) -> NDArray[np.float64]:
    """|a - b|; zero where both are the same infinity or NaN, infinite where only one of them is finite."""
    wide = "c" in (a.dtype.kind, b.dtype.kind)
    x, y = _doubled(a, wide), _doubled(b, wide)
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(x - y)
    if exact:  # doubles run out of whole numbers at 2^53
        return np.where(a == b, 0.0, np.maximum(apart, 1.0))
    equal = (x == y) | (np.isnan(x) & np.isnan(y))
    return np.where(equal, 0.0, np.where(np.isfinite(x) & np.isfinite(y), apart, np.inf))


def _doubled(array: NDArray[Any], wide: bool) -> NDArray[Any]:
    """In double precision, complex if wide; a signaling NaN, which numpy would warn of, is a NaN as any other."""
    with np.errstate(invalid="ignore"):
        return array.astype(np.complex128 if wide else np.float64)


def _compare_texts(name: str, location: str, a: NDArray[Any], b: NDArray[Any], numbers: list[bool]) -> Finding:
    if any(numbers):
        kinds = ["numbers" if number else "text" for number in numbers]
        return Finding(name, location, False, a.shape, note=f"{kinds[0]} in A, {kinds[1]} in B")
    if a.dtype.kind != b.dtype.kind or (a.dtype.kind == "V" and a.dtype != b.dtype):  # records, dates
        return Finding(name, location, False, a.shape, note=f"{a.dtype} in A, {b.dtype} in B")
    apart = a != b
    if not apart.any():
        return Finding(name, location, True, a.shape)
    index = tuple(int(i) for i in np.unravel_index(int(apart.argmax()), a.shape))
    values = (str(a[index]), str(b[index]))
    return Finding(name, location, False, a.shape, beyond=int(np.count_nonzero(apart)), index=index, values=values)
