"""Two files: what they are by their names, and the comparison for that."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from geomhw.compare.findings import Comparison, Finding
from geomhw.compare.rules import DEFAULT_IGNORED, Ignored, Tolerance
from geomhw.errors import FormatError, GeomhwError

#: Extensions of what is no mesh, and what it is.
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
_Comparing = Callable[[Path, Path, Tolerance, Ignored], list[Finding]]


def compare_files(
    one: str | Path,
    other: str | Path,
    tolerance: Tolerance | None = None,
    ignored: Ignored | None = None,
    heaviest_spot: float | None = None,
    everything: bool = False,
) -> Comparison:
    """All that two files of one kind differ in, whatever their formats.

    ignored: names of arrays, columns, values. heaviest_spot: of pictures, see ``pictures``. everything: of JSON also
    what differs from run to run, which is left out otherwise.
    GeomhwError where a file cannot be read, where the files are of two kinds, and where nothing is left to compare.
    """
    a, b = Path(one), Path(other)
    kind = kind_of(a)
    if kind != kind_of(b):
        raise GeomhwError(f"{a} ({kind}) and {b} ({kind_of(b)}) cannot be compared; give two files of one kind")
    tolerance, ignored = tolerance or Tolerance(), ignored or Ignored()
    if kind == "picture":
        return Comparison(kind, [_pictures(a, b, heaviest_spot)])
    defaults = DEFAULT_IGNORED if kind == "document" and not everything else ()
    findings = _COMPARING[kind](a, b, tolerance, ignored + defaults)
    if not findings and ignored.patterns:
        raise GeomhwError(f"nothing is compared of {a} and {b}: all of it is ignored ({', '.join(ignored.patterns)})")
    return Comparison(kind, findings)


def kind_of(path: Path) -> str:
    """What a file is, by its extension; FormatError where nothing of that name is compared."""
    from geomhw.io import READABLE

    extension = path.suffix.lower()
    if extension in READABLE:
        return "mesh"
    if extension in KINDS:
        return KINDS[extension]
    raise FormatError(f"{path}: what ends in '{extension}' is not compared; known are {' '.join([*KINDS, *READABLE])}")


def _load(read: Callable[[Path], _Content], path: Path) -> _Content:
    """What is in the file; a failure is told with its whole path, since the two files often have one name."""
    try:
        return read(path)
    except GeomhwError as error:
        told = str(error)
        raise FormatError(told if str(path) in told else told.replace(path.name, str(path), 1)) from error


def _meshes(a: Path, b: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    from geomhw.compare.meshes import compare_meshes
    from geomhw.io import read

    return compare_meshes(_load(read, a), _load(read, b), tolerance, ignored)


def _series(a: Path, b: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    from geomhw.compare.meshes import compare_series

    return compare_series(a, b, tolerance, ignored)


def _tables(a: Path, b: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    from geomhw.compare.arrays import compare_named
    from geomhw.io import read_csv

    return compare_named("column", _load(read_csv, a), _load(read_csv, b), tolerance, ignored)


def _documents(a: Path, b: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    from geomhw.compare.documents import compare_documents
    from geomhw.io import read_json

    return compare_documents(_load(read_json, a), _load(read_json, b), tolerance, ignored)


def _arrays(a: Path, b: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    from geomhw.compare.matrices import compare_matrices
    from geomhw.io import read_arrays

    return compare_matrices(_load(read_arrays, a), _load(read_arrays, b), tolerance, ignored)


def _pictures(a: Path, b: Path, heaviest_spot: float | None) -> Finding:
    from geomhw.compare.pictures import HEAVIEST_SPOT, compare_pictures
    from geomhw.io import read_png

    limit = HEAVIEST_SPOT if heaviest_spot is None else heaviest_spot
    return compare_pictures(_load(read_png, a), _load(read_png, b), limit)


_COMPARING: dict[str, _Comparing] = {
    "mesh": _meshes,
    "series": _series,
    "table": _tables,
    "document": _documents,
    "arrays": _arrays,
}
