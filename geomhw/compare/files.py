"""Comparison of two files, by the kind that their extensions name."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from geomhw.compare.arrays import compare_matrices, compare_named
from geomhw.compare.documents import compare_documents
from geomhw.compare.findings import Comparison, Finding
from geomhw.compare.meshes import compare_meshes, compare_series
from geomhw.compare.pictures import compare_pictures
from geomhw.compare.rules import DEFAULT_IGNORED, HEAVIEST_SPOT, Ignored, Tolerance
from geomhw.errors import FormatError, GeomhwError
from geomhw.io import READABLE, read
from geomhw.io.artifacts.images import read_png
from geomhw.io.artifacts.matrices import read_arrays
from geomhw.io.artifacts.tables import read_csv
from geomhw.io.file_content import read_json

#: Kind of a file by its extension; every other readable extension is a mesh.
KINDS = {
    ".pvd": "series",
    ".csv": "table",
    ".json": "document",
    ".npy": "arrays",
    ".npz": "arrays",
    ".mtx": "arrays",
    ".png": "picture",
}

_Content = TypeVar("_Content")


def compare_files(
    one: str | Path,
    other: str | Path,
    tolerance: Tolerance | None = None,
    ignored: Ignored | None = None,
    heaviest_spot: float = HEAVIEST_SPOT,
    everything: bool = False,
) -> Comparison:
    """Compare the values in two files of the same kind; their formats may differ.

    Parameters
    ----------
    one, other : path
        Meshes with arrays, time series (.pvd), tables (.csv), JSON documents, arrays (.npy .npz .mtx) or pictures
        (.png).
    tolerance : Tolerance, optional
    ignored : Ignored, optional
        Names of arrays, columns or JSON values to leave out.
    heaviest_spot : float
        Weight of the heaviest spot that passes in a picture; see `geomhw.compare.pictures`.
    everything : bool
        Compare values of a JSON document that differ from run to run, too, such as ``seconds``.

    Returns
    -------
    Comparison

    Raises
    ------
    FormatError
        If a file cannot be read or its extension is not known.
    GeomhwError
        If the files are of different kinds, or everything is ignored.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     for name, text in (("a.csv", "x,y"), ("b.csv", "y,x")):
    ...         _ = (Path(folder) / name).write_text(f"{text}\\n1,1\\n")
    ...     print(compare_files(Path(folder) / "a.csv", Path(folder) / "b.csv"))
    same  column  x  1  equal
    same  column  y  1  equal
    same: 2 compared
    """
    a, b = Path(one), Path(other)
    kind = kind_of(a)
    if kind != kind_of(b):
        raise GeomhwError(f"{a} ({kind}) and {b} ({kind_of(b)}) cannot be compared; give two files of one kind")
    tolerance, ignored = tolerance or Tolerance(), ignored or Ignored()
    if kind == "picture":
        return Comparison(kind, [compare_pictures(_load(read_png, a), _load(read_png, b), heaviest_spot)])
    defaults = DEFAULT_IGNORED if kind == "document" and not everything else ()
    findings = _compare(kind, a, b, tolerance, ignored + defaults)
    if not findings and ignored.patterns:
        raise GeomhwError(f"nothing is compared of {a} and {b}: all of it is ignored ({', '.join(ignored.patterns)})")
    return Comparison(kind, findings)


def kind_of(path: Path) -> str:
    """Return the kind of a file by its extension; raise FormatError for an unknown extension."""
    extension = path.suffix.lower()
    if extension in READABLE:
        return "mesh"
    if extension in KINDS:
        return KINDS[extension]
    raise FormatError(f"{path}: the extension '{extension}' is not compared; known are {' '.join([*KINDS, *READABLE])}")


def _compare(kind: str, a: Path, b: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    """Read and compare two files of a kind other than pictures."""
    if kind == "series":
        return compare_series(a, b, tolerance, ignored)
    if kind == "mesh":
        return compare_meshes(_load(read, a), _load(read, b), tolerance, ignored)
    if kind == "table":
        return compare_named("column", _load(read_csv, a), _load(read_csv, b), tolerance, ignored)
    if kind == "document":
        return compare_documents(_load(read_json, a), _load(read_json, b), tolerance, ignored)
    return compare_matrices(_load(read_arrays, a), _load(read_arrays, b), tolerance, ignored)


def _load(reader: Callable[[Path], _Content], path: Path) -> _Content:
    """Read a file; error messages name its whole path, since the two files often have the same name."""
    try:
        return reader(path)
    except GeomhwError as error:
        message = str(error)
        raise FormatError(message if str(path) in message else message.replace(path.name, str(path), 1)) from error
