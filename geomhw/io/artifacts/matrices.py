"""Sparse matrices in scipy's ``.npz`` or Matrix Market ``.mtx`` files, and arrays in ``.npy`` and ``.npz`` files."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.errors import FormatError
from geomhw.io.artifacts.arrays import read_numpy
from geomhw.io.artifacts.matrix_market import LARGEST, read_matrix_market
from geomhw.io.atomic import replacing
from geomhw.io.file_content import read_bytes

#: Extensions that ``write_matrix`` knows.
WRITABLE_MATRICES = (".npz", ".mtx")
#: Name of an array without one in its file: a sparse matrix, the array of a ``.npy``.
UNNAMED = "values"


def write_matrix(path: str | Path, matrix: Any, *, compress: bool = True) -> None:
    """Write a sparse matrix atomically; equal matrices give equal bytes.

    Parameters
    ----------
    path
        File with one of the extensions ``WRITABLE_MATRICES``: ``.npz`` of `scipy.sparse.save_npz`, or ``.mtx``
        with 17 digits, which give every double back.
    matrix
        Sparse matrix or array of scipy.
    compress
        Whether to compress a ``.npz``. Distances shrink by a third only, and take ten times as long.

    Examples
    --------
    >>> import tempfile
    >>> import scipy.sparse as sp
    >>> from geomhw.io import read_arrays, write_matrix
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_matrix(f"{folder}/identity.mtx", sp.eye_array(3))
    ...     read_arrays(f"{folder}/identity.mtx")["values"].nnz
    3
    """
    from scipy.sparse import csr_array

    matrix = matrix.tocsr()
    matrix.sum_duplicates()  # sorts, too
    # The type of the indices depends on how the matrix was made.
    kind = np.int32 if max(matrix.nnz, *matrix.shape) < 2**31 else np.int64
    matrix = csr_array((matrix.data, matrix.indices.astype(kind), matrix.indptr.astype(kind)), shape=matrix.shape)
    # Streams, not names: scipy adds an extension to a name that ends in capitals.
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        if Path(path).suffix.lower() == ".npz":
            from scipy.sparse import save_npz

            save_npz(stream, matrix, compressed=compress)
        else:
            from scipy.io import mmwrite

            mmwrite(stream, matrix, comment="geomhw", precision=17, symmetry="general")


def read_arrays(path: str | Path) -> dict[str, Any]:
    """Read the arrays or the sparse matrix of a ``.npy``, ``.npz`` or ``.mtx`` file.

    Returns
    -------
    Arrays by name; a sparse matrix and the array of a ``.npy`` under the name ``UNNAMED``.

    Raises
    ------
    FormatError
        If the file cannot be read, is damaged, or holds Python objects.
    """
    path = Path(path)
    data = read_bytes(path)
    is_market = path.suffix.lower() == ".mtx"
    try:
        return {UNNAMED: read_matrix_market(data)} if is_market else _read_numpy_or_sparse(data)
    except Exception as error:  # zipfile, struct, numpy and scipy each have their own errors
        reason = " ".join(str(error).split())[:150]
        kind = "Matrix Market" if is_market else "a numpy file"
        raise FormatError(f"{path.name} cannot be read as {kind}: {reason}") from error


def _read_numpy_or_sparse(data: bytes) -> dict[str, Any]:
    stored = read_numpy(data)  # checks that the file holds what its headers announce
    if isinstance(stored, np.ndarray):
        return {UNNAMED: stored}
    if not {"format", "shape", "data"} <= stored.keys():
        return stored
    from scipy.sparse import load_npz

    if (stored["shape"].astype(np.float64) >= LARGEST).any():
        raise ValueError(f"a matrix of {stored['shape'].tolist()} is too large")
    matrix = load_npz(io.BytesIO(data))
    if hasattr(matrix, "check_format"):
        matrix.check_format()
    return {UNNAMED: matrix}
