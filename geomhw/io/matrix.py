"""Sparse matrices to files: scipy's ``.npz``, or Matrix Market ``.mtx``."""

from pathlib import Path
from typing import Any

from geomhw.io.atomic import replacing

#: Extensions that ``write_matrix`` knows.
WRITABLE_MATRICES = (".npz", ".mtx")


def write_matrix(path: str | Path, matrix: Any) -> None:
    """Write a sparse matrix, whole or not at all; equal matrices give equal bytes."""
    matrix = matrix.tocsr()
    matrix.sum_duplicates()  # sorts, too
    with replacing([path]) as (temporary,):
        if temporary.suffix.lower() == ".npz":
            from scipy.sparse import save_npz

            save_npz(temporary, matrix)
        else:
            from scipy.io import mmwrite

            mmwrite(temporary, matrix, comment="geomhw", precision=17, symmetry="general")
