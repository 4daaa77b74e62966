"""NumPy's ``.npy`` and ``.npz`` files, read only where the file is large enough for the arrays that it announces.

Hand-written because np.load allocates what a header announces before it reads: 0.8 GB for a damaged file of 128 bytes.
"""

import io
import math
import zipfile
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

#: Largest factor by which deflate compresses [RFC 1951: 258 bytes for two bits], and bytes added for a header.
_DEFLATED, _HEADER = 1032, 1 << 16


def read_numpy(data: bytes) -> NDArray[Any] | dict[str, NDArray[Any]]:
    """Return the array of a ``.npy``, or the arrays of a ``.npz`` by name.

    Raises
    ------
    ValueError, zipfile.BadZipFile and other errors of numpy and zipfile
        If the data are damaged, hold Python objects, or are smaller than their headers say.
    """
    if data.startswith(np.lib.format.MAGIC_PREFIX):
        return _read_array(io.BytesIO(data), len(data))
    found = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for member in archive.infolist():
            if member.filename.endswith(".npy"):
                if not 0 <= member.compress_size <= len(data) or member.file_size > _largest(member):
                    raise ValueError(f"'{member.filename}' is declared larger than its packed bytes can be")
                with archive.open(member) as stream:
                    found[member.filename.removesuffix(".npy")] = _read_array(stream, member.file_size)
    return found


def npy_header(shape: tuple[int, ...], kind: str) -> bytes:
    """Return the header of a ``.npy`` file of that shape, in C order, and type, such as ``<f8`` or ``<f4``."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": False, "shape": shape})
    return stream.getvalue()


def _largest(member: zipfile.ZipInfo) -> int:
    """Most bytes that a member can unpack to."""
    if member.compress_type == zipfile.ZIP_STORED:
        return member.compress_size
    if member.compress_type == zipfile.ZIP_DEFLATED:
        return _DEFLATED * member.compress_size + _HEADER
    raise ValueError(f"'{member.filename}' is packed in a way that numpy does not use")


def _read_array(stream: IO[bytes], size: int) -> NDArray[Any]:
    """One array from a stream of some size [NumPy Enhancement Proposal 1]."""
    version = np.lib.format.read_magic(stream)
    read_header = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    if version not in read_header:
        raise ValueError(f"version {version[0]}.{version[1]} of the format is not read")
    shape, by_columns, kind = read_header[version](stream)
    if kind.hasobject:
        raise ValueError("it holds Python objects, not numbers")
    if min(shape, default=0) < 0 or math.prod(shape) * kind.itemsize > size:
        raise ValueError(f"an array of {' x '.join(map(str, shape))} is promised, but there are {size} bytes")
    raw = bytearray(stream.read(math.prod(shape) * kind.itemsize))
    return np.frombuffer(raw, kind, math.prod(shape)).reshape(shape, order="F" if by_columns else "C")
