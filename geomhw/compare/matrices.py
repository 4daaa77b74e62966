"""Two collections of numpy arrays and sparse matrices."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from geomhw.compare.arrays import compare_arrays, missing
from geomhw.compare.findings import Finding
from geomhw.compare.rules import Ignored, Tolerance


def compare_matrices(
    one: Mapping[str, Any], other: Mapping[str, Any], tolerance: Tolerance, ignored: Ignored
) -> list[Finding]:
    """A finding for each name; an array beside a sparse matrix is one with all its entries."""
    findings = [
        _compare(name, one[name], other[name], tolerance) for name in one if name in other and name not in ignored
    ]
    return findings + missing("array", one, other, ignored)


def _compare(name: str, a: Any, b: Any, tolerance: Tolerance) -> Finding:
    from scipy.sparse import issparse

    if issparse(a) or issparse(b):
        if np.ndim(a) == np.ndim(b) == 2:
            return compare_sparse(name, a, b, tolerance)
        return Finding(name, "matrix", False, note=f"{np.ndim(a)} dimensions in A, {np.ndim(b)} in B")
    return compare_arrays(name, "array", a, b, tolerance)


def compare_sparse(name: str, one: Any, other: Any, tolerance: Tolerance) -> Finding:
    """Matrices entry by entry; one that is not stored is zero. The index is row and column."""
    a, b = _entries(one), _entries(other)
    if a.shape != b.shape:
        shapes = [" x ".join(map(str, matrix.shape)) for matrix in (a, b)]
        return Finding(name, "matrix", False, note=f"{shapes[0]} in A, {shapes[1]} in B")
    keys = [matrix.row.astype(np.int64) * a.shape[1] + matrix.col for matrix in (a, b)]
    places = np.union1d(*keys)
    x, y = (np.zeros(len(places), dtype=matrix.dtype) for matrix in (a, b))
    for full, matrix, key in zip((x, y), (a, b), keys, strict=True):
        full[np.searchsorted(places, key)] = matrix.data
    finding = compare_arrays(name, "matrix", x, y, tolerance)
    at = finding.index and tuple(int(i) for i in divmod(int(places[finding.index[0]]), a.shape[1]))
    return replace(finding, size=a.shape, index=at, note=_stored(a.nnz, b.nnz))


def _entries(matrix: Any) -> Any:
    """Rows, columns and values, each place once."""
    from scipy.sparse import coo_array

    entries = coo_array(matrix)
    entries.sum_duplicates()
    return entries


def _stored(a: int, b: int) -> str:
    return f"{a} entries" if a == b else f"{a} entries in A, {b} in B"
