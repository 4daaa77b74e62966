"""Sparse matrices to files: scipy's ``.npz``, or Matrix Market ``.mtx``."""

from pathlib import Path
from typing import Any

import numpy as np

from geomhw.io.atomic import replacing

#: Extensions that ``write_matrix`` knows.
WRITABLE_MATRICES = (".npz", ".mtx")


def write_matrix(path: str | Path, matrix: Any) -> None:
    """Write a sparse matrix, whole or not at all; equal matrices give equal bytes."""
    from scipy.sparse import csr_array

    matrix = matrix.tocsr()
    matrix.sum_duplicates()  # sorts, too
    index = np.int32 if max(matrix.nnz, *matrix.shape) < 2**31 else np.int64  # whatever it was built with
    places = matrix.indices.astype(index), matrix.indptr.astype(index)
    matrix = csr_array((matrix.data, *places), shape=matrix.shape)
    # Streams, not names: scipy would write to another file where an extension is in capitals.
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        if Path(path).suffix.lower() == ".npz":
            from scipy.sparse import save_npz

            save_npz(stream, matrix)
        else:
            from scipy.io import mmwrite

            mmwrite(stream, matrix, comment="geomhw", precision=17, symmetry="general")
