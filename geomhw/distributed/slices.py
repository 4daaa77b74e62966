"""Open a mesh file that ranks read in slices, by its format."""

from collections.abc import Callable
from pathlib import Path

from geomhw.distributed.off_slices import open_off
from geomhw.distributed.ply_slices import SlicedPly
from geomhw.distributed.ranks import Ranks
from geomhw.distributed.sliced_file import SlicedFile, unsliceable
from geomhw.distributed.vtk_slices import SlicedVtk

KINDS: dict[str, Callable[[Path], SlicedFile]] = {
    ".ply": SlicedPly,
    ".off": open_off,
    ".vtu": SlicedVtk,
    ".vtp": SlicedVtk,
}


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
    path = Path(path)
    with ranks.agreeing():
        if path.suffix.lower() not in KINDS:
            raise unsliceable(path, f"'{path.suffix}' files are not read in slices")
        file = KINDS[path.suffix.lower()](path)
    file.index(ranks)
    return file
