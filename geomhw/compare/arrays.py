"""Comparison of arrays and sparse matrices, alone or in collections by name."""

from collections.abc import Mapping
from dataclasses import replace
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
    """Compare two arrays: find the largest deviation and whether it passes.

    NaN equals NaN, and an infinity equals the same infinity. Integers, booleans and texts must be equal; integers
    compared with other numbers need the tolerance only.

    Parameters
    ----------
    name, location : str
        Copied to the finding.
    one, other : array
        Arrays of the same shape; (n, 1) is the same as (n,).
    tolerance : Tolerance
    scale : float, optional
        Scale of the relative tolerance; by default the largest finite magnitude in both arrays.
    single : bool
        Whether the values were stored in single precision, independent of their present type.

    Returns
    -------
    Finding

    Examples
    --------
    >>> found = compare_arrays("x", "vertex", [1.0, 2.0], [1.0, 2.1], Tolerance())
    >>> found.same, found.index, found.values
    (False, (1,), (2.0, 2.1))
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
    """Compare two collections of arrays by name.

    Parameters
    ----------
    location : str
        Copied to the findings.
    one, other : mapping of name to array
    tolerance : Tolerance
    ignored : Ignored
        Names to leave out.
    single : set of str
        Names of arrays that were stored in single precision.

    Returns
    -------
    list of Finding
        In the order of ``one``; then names that only one collection has, which differ.

    Examples
    --------
    >>> found = compare_named("column", {"x": [1.0], "y": [2.0]}, {"x": [1.0]}, Tolerance(), Ignored())
    >>> [(finding.name, finding.same) for finding in found]
    [('x', True), ('y', False)]
    """
    findings = [
        compare_arrays(name, location, one[name], other[name], tolerance, single=name in single)
        for name in one
        if name in other and name not in ignored
    ]
    return findings + missing(location, one, other, ignored)


def missing(location: str, one: Mapping[str, Any], other: Mapping[str, Any], ignored: Ignored) -> list[Finding]:
    """Return a finding for each name that only one collection has."""
    sides = (("A", [n for n in one if n not in other]), ("B", [n for n in other if n not in one]))
    return [
        Finding(name, location, False, note=f"only in {side}")
        for side, names in sides
        for name in names
        if name not in ignored
    ]


def compare_matrices(
    one: Mapping[str, Any], other: Mapping[str, Any], tolerance: Tolerance, ignored: Ignored
) -> list[Finding]:
    """Compare two collections of arrays and sparse matrices by name; a dense array may match a sparse matrix."""
    findings = [
        _compare_matrix(name, one[name], other[name], tolerance)
        for name in one
        if name in other and name not in ignored
    ]
    return findings + missing("array", one, other, ignored)


def _compare_matrix(name: str, a: Any, b: Any, tolerance: Tolerance) -> Finding:
    from scipy.sparse import issparse

    if issparse(a) or issparse(b):
        if np.ndim(a) == np.ndim(b) == 2:
            return compare_sparse(name, a, b, tolerance)
        return Finding(name, "matrix", False, note=f"{np.ndim(a)} dimensions in A, {np.ndim(b)} in B")
    return compare_arrays(name, "array", a, b, tolerance)


def compare_sparse(name: str, one: Any, other: Any, tolerance: Tolerance) -> Finding:
    """Compare sparse matrices entry by entry; entries that are not stored are zero. The index is row and column."""
    a, b = _entries(one), _entries(other)
    if a.shape != b.shape:
        return Finding(name, "matrix", False, note=f"{_shape(a)} in A, {_shape(b)} in B")
    keys = [matrix.row.astype(np.int64) * a.shape[1] + matrix.col for matrix in (a, b)]
    places = np.union1d(*keys)
    x, y = (np.zeros(len(places), dtype=matrix.dtype) for matrix in (a, b))
    for full, matrix, key in zip((x, y), (a, b), keys, strict=True):
        full[np.searchsorted(places, key)] = matrix.data
    finding = compare_arrays(name, "matrix", x, y, tolerance)
    at = finding.index and tuple(int(i) for i in divmod(int(places[finding.index[0]]), a.shape[1]))
    note = f"{a.nnz} entries" + (f" in A, {b.nnz} in B" if a.nnz != b.nnz else "")
    return replace(finding, size=a.shape, index=at, note=note)


def _entries(matrix: Any) -> Any:
    """Return rows, columns and values, each place once."""
    from scipy.sparse import coo_array

    entries = coo_array(matrix)
    entries.sum_duplicates()
    return entries


def _column(array: NDArray[Any]) -> NDArray[Any]:
    """Return (n, 1) as (n,): file formats differ in which of them they store."""
    return array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array


def _shape(array: Any) -> str:
    return " x ".join(map(str, array.shape)) or "one value"


def _is_single(array: NDArray[Any]) -> bool:
    return array.dtype in (np.float16, np.float32, np.complex64)


def _magnitude(*arrays: NDArray[Any]) -> float:
    """Return the largest finite magnitude."""
    tops = []
    for array in arrays:
        size = np.abs(_doubled(array, array.dtype.kind == "c"))
        tops.append(float(size.max(initial=0.0, where=np.isfinite(size))))
    return max(tops)


def _deviation(a: NDArray[Any], b: NDArray[Any], exact: bool) -> NDArray[np.float64]:
    """Return |a - b|: 0 where both are the same infinity or NaN, inf where only one of them is finite."""
    wide = "c" in (a.dtype.kind, b.dtype.kind)
    x, y = _doubled(a, wide), _doubled(b, wide)
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(x - y)
    if exact:  # doubles hold integers up to 2^53 only
        return np.where(a == b, 0.0, np.maximum(apart, 1.0))
    equal = (x == y) | (np.isnan(x) & np.isnan(y))
    return np.where(equal, 0.0, np.where(np.isfinite(x) & np.isfinite(y), apart, np.inf))


def _doubled(array: NDArray[Any], wide: bool) -> NDArray[Any]:
    """Convert to double precision, complex if ``wide``, without numpy's warning about signaling NaN."""
    with np.errstate(invalid="ignore"):
        return array.astype(np.complex128 if wide else np.float64)


def _compare_texts(name: str, location: str, a: NDArray[Any], b: NDArray[Any], numbers: list[bool]) -> Finding:
    """Compare arrays of which at least one does not hold numbers."""
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
