"""Sparse matrices to files, scipy's ``.npz`` or Matrix Market ``.mtx``; these and numpy's arrays back from them."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.errors import FormatError
from geomhw.io.artifacts.matrix_market import read_market
from geomhw.io.artifacts.numpy_file import read_numpy
from geomhw.io.atomic import replacing
from geomhw.io.file_bytes import content

#: Extensions that ``write_matrix`` knows.
WRITABLE_MATRICES = (".npz", ".mtx")
#: The name of what has none in its file: a sparse matrix, the array of a ``.npy``.
UNNAMED = "values"
#: Rows and columns of a matrix that is read are fewer.
_MOST = 2**31


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


def read_arrays(path: str | Path) -> dict[str, Any]:
    """Arrays and sparse matrices of a ``.npy``, ``.npz`` or ``.mtx`` file by name; ``UNNAMED`` where it has none."""
    path = Path(path)
    data = content(path)
    try:
        return {UNNAMED: read_market(data)} if path.suffix.lower() == ".mtx" else _of_numpy(data)
    except Exception as error:  # zip, pickle, struct, numpy and scipy each have their own
        what = "Matrix Market" if path.suffix.lower() == ".mtx" else "a numpy file"
        reason = " ".join(str(error).split())[:150]
        raise FormatError(f"{path.name} cannot be read as {what}: {reason}") from error


def _of_numpy(data: bytes) -> dict[str, Any]:
    stored = read_numpy(data)  # which finds out whether the file holds what its headers promise
    if isinstance(stored, np.ndarray):
        return {UNNAMED: stored}
    if not {"format", "shape", "data"} <= stored.keys():
        return stored
    from scipy.sparse import load_npz

    if (stored["shape"].astype(np.float64) >= _MOST).any():
        raise ValueError(f"a matrix of {stored['shape'].tolist()} is too large")
    matrix = load_npz(io.BytesIO(data))
    matrix.check_format() if hasattr(matrix, "check_format") else None
    return {UNNAMED: matrix}
