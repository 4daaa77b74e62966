"""Mesh files that ranks read in slices: any range of vertices, and any range of triangles, by seek."""

from abc import ABC, abstractmethod
from collections.abc import Callable
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


def open_sliced(ranks: Ranks, path: str | Path) -> SlicedFile:
    """Open a mesh file for reading in slices; every rank calls it.

    Parameters
    ----------
    path : a binary ``.ply`` of either byte order, a binary or text ``.off``, or a ``.vtu`` or ``.vtp`` with arrays
        appended as raw bytes, of triangles.

    Raises
    ------
    FormatError
        If the file is damaged, or cannot be read in slices; the message says how to convert it.
    """
    from geomhw.distributed.off_slices import open_off
    from geomhw.distributed.ply_slices import SlicedPly
    from geomhw.distributed.vtk_slices import SlicedVtk

    path = Path(path)
    kinds: dict[str, Callable[[Path], SlicedFile]] = {".ply": SlicedPly, ".off": open_off}
    kinds |= {".vtu": SlicedVtk, ".vtp": SlicedVtk}
    with ranks.agreeing():
        if path.suffix.lower() not in kinds:
            raise unsliceable(path, f"'{path.suffix}' files are not read in slices")
        file = kinds[path.suffix.lower()](path)
    file.index(ranks)
    return file


def unsliceable(path: Path, reason: str) -> FormatError:
    """Return the error of a file that cannot be read in slices."""
    return FormatError(f"{path.name} cannot be read in slices: {reason}; convert it to a binary PLY file of triangles")
