"""Numpy and Matrix Market files of every kind are read as numpy and scipy read them."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from geomhw.io.artifacts.arrays import read_numpy
from geomhw.io.artifacts.matrix_market import read_matrix_market


@pytest.mark.parametrize("packing", [np.savez, np.savez_compressed])
def test_arrays_of_numpy(tmp_path: Path, packing: object) -> None:
    """Arrays of any order, type and size are read, compressed or not."""
    made = {
        "u": np.arange(6.0).reshape(2, 3),
        "by columns": np.asfortranarray(np.arange(6, dtype=">i4").reshape(2, 3)),
        "none": np.empty((0, 3)),
        "one": np.array(7.0),
        "zeros": np.zeros(100_000),
    }
    packing(tmp_path / "a.npz", **made)  # type: ignore[operator]
    found = read_numpy((tmp_path / "a.npz").read_bytes())
    assert isinstance(found, dict)
    assert found.keys() == made.keys()
    for name, array in made.items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)


@pytest.mark.parametrize(
    ("field", "symmetry"),
    [
        *product(["real", "integer", "complex"], ["general", "symmetric", "skew-symmetric"]),
        ("complex", "hermitian"),
        *product(["pattern"], ["general", "symmetric"]),  # which has no sign
    ],
)
def test_market_as_scipy_reads_it(tmp_path: Path, field: str, symmetry: str) -> None:
    """Every kind of Matrix Market file is read as scipy reads it."""
    values = {"real": "0.5 -1e-3 7", "integer": "5 -1 7", "complex": "1;2 0;-1 3;0", "pattern": ". . ."}[field].split()
    places = ["2 1", "3 1", "3 2"] if symmetry == "skew-symmetric" else ["1 1", "2 1", "3 2"]
    if field == "complex" and symmetry == "hermitian":
        values[0] = "1;0"
    rows = [f"{place} {value.replace(';', ' ').strip('.')}\n" for place, value in zip(places, values, strict=True)]
    text = f"%%MatrixMarket matrix coordinate {field} {symmetry}\n% a comment\n\n3 3 3\n{''.join(rows)}"
    (tmp_path / "a.mtx").write_text(text)
    np.testing.assert_array_equal(
        read_matrix_market(text.encode()).toarray(),
        sp.coo_array(scipy.io.mmread(tmp_path / "a.mtx", spmatrix=False)).toarray(),
    )


def test_market_with_all_entries(tmp_path: Path) -> None:
    """Dense Matrix Market files are read column by column."""
    made = np.arange(6.0).reshape(2, 3) / 7
    scipy.io.mmwrite(tmp_path / "a.mtx", made, precision=17)
    np.testing.assert_array_equal(read_matrix_market((tmp_path / "a.mtx").read_bytes()), made)
