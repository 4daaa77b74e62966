"""Mesh files that ranks read in slices: any range of vertices, and any range of triangles, by seek."""

from abc import ABC, abstractmethod
from pathlib import Path

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError

#: Bytes from the start of a file in which its header ends.
LONGEST_HEADER = 1 << 16


class SlicedFile(ABC):
    """A mesh file of n vertices and m triangles, of which any range can be read.

    Attributes
    ----------
    path : Path
    n_vertices, n_faces : int
    """

    path: Path
    n_vertices: int
    n_faces: int

    @abstractmethod
    def read_vertices(self, begin: int, end: int) -> Floats:
        """Return the coordinates of a range of vertices, (end - begin, 3)."""

    @abstractmethod
    def read_faces(self, begin: int, end: int) -> Ints:
        """Return the vertices of a range of triangles, (end - begin, 3)."""


def open_sliced(path: str | Path) -> SlicedFile:
    """Open a mesh file for reading in slices.

    Parameters
    ----------
    path : a binary ``.ply`` file of triangles, of either byte order.

    Raises
    ------
    FormatError
        If the file is damaged, or cannot be read in slices; the message says how to convert it.
    """
    from geomhw.distributed.ply_slices import SlicedPly

    path = Path(path)
    kinds = {".ply": SlicedPly}
    if path.suffix.lower() not in kinds:
        raise unsliceable(path, f"'{path.suffix}' files are not read in slices")
    return kinds[path.suffix.lower()](path)


def unsliceable(path: Path, reason: str) -> FormatError:
    """Return the error of a file that cannot be read in slices."""
    return FormatError(f"{path.name} cannot be read in slices: {reason}; convert it to a binary PLY file of triangles")
