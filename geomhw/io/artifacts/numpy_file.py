"""numpy's ``.npy`` and ``.npz`` files, whose headers may promise no more than the file can hold."""

import io
import math
import zipfile
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

#: What deflate makes of a byte at most [RFC 1951: 258 bytes a match of two bits], and a header's worth more.
_DEFLATED, _HEADER = 1032, 1 << 16


def read_numpy(data: bytes) -> NDArray[Any] | dict[str, NDArray[Any]]:
    """The array of a ``.npy``, or those of a ``.npz`` by name; ValueError and others where they are not whole."""
    if data.startswith(np.lib.format.MAGIC_PREFIX):
        return _array(io.BytesIO(data), len(data))
    found = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for member in archive.infolist():
            if not member.filename.endswith(".npy"):
                continue
            if not 0 <= member.compress_size <= len(data) or member.file_size > _most(member):
                raise ValueError(f"'{member.filename}' is said to be larger than it can be")
            with archive.open(member) as stream:
                found[member.filename.removesuffix(".npy")] = _array(stream, member.file_size)
    return found


def npy_header(shape: tuple[int, ...], kind: str) -> bytes:
    """The beginning of a ``.npy`` of that shape, by rows, and kind of numbers, ``<f8`` or ``<f4``."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": False, "shape": shape})
    return stream.getvalue()


def _most(member: zipfile.ZipInfo) -> int:
    """Bytes that a member can unpack to."""
    if member.compress_type == zipfile.ZIP_STORED:
        return member.compress_size
    if member.compress_type == zipfile.ZIP_DEFLATED:
        return _DEFLATED * member.compress_size + _HEADER
    raise ValueError(f"'{member.filename}' is packed in a way that numpy does not use")


def _array(stream: IO[bytes], size: int) -> NDArray[Any]:
    """One array of a stream of so many bytes [NumPy Enhancement Proposal 1]."""
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
