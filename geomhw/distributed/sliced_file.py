"""What ranks read of a mesh file: any range of vertices, and any range of triangles, by seek."""

from abc import ABC, abstractmethod
from pathlib import Path

from geomhw.arrays import Floats, Ints
from geomhw.distributed.ranks import Ranks
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

    def index(self, ranks: Ranks) -> None:
        """Find where rows of the file begin, if that needs more than the header; every rank calls it."""
        del ranks

    @abstractmethod
    def read_vertices(self, begin: int, end: int) -> Floats:
        """Return the coordinates of a range of vertices, (end - begin, 3)."""

    @abstractmethod
    def read_faces(self, begin: int, end: int) -> Ints:
        """Return the vertices of a range of triangles, (end - begin, 3)."""


def unsliceable(path: Path, reason: str) -> FormatError:
    """Return the error of a file that cannot be read in slices."""
    return FormatError(f"{path.name} cannot be read in slices: {reason}; convert it to a binary PLY file of triangles")
