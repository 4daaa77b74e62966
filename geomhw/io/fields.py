"""Arrays on a mesh, read from files of several kinds: ``moo.vtp:heat``, ``u.npy``, ``all.npz:u``, ``t.csv:x,y,z``."""

import csv
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FieldError
from geomhw.io.artifacts.numpy_file import read_numpy
from geomhw.io.file_bytes import content
from geomhw.io.reading import READABLE, read
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.results import Field

_UNREADABLE = (OSError, UnicodeDecodeError, csv.Error)
_KNOWN = ".npy .npz .csv"


def read_field(spec: str, mesh: TriangleMesh) -> Field:
    """One array for the vertices or the faces of a mesh, from ``FILE:ARRAY``.

    FILE is a mesh with arrays, ``.npz``, ``.csv`` (ARRAY is a column, or several with commas between) or ``.npy``
    (which has one array and needs no name). The number of rows decides the place. Where the mesh has as many vertices
    as faces, it is the place that the array has in its file, or, if the file knows none, the faces.
    """
    path, key = _split(spec)
    extension = path.suffix.lower()
    place: Location | None = None
    if extension == ".npy":
        if key:
            raise FieldError(f"{path.name} holds one array without a name; leave ':{key}' away")
        name, values = path.stem, _from_npy(path)
    elif extension == ".npz":
        name, values = key, _from_npz(path, key)
    elif extension == ".csv":
        name, values = key, _from_csv(path, key)
    elif extension in READABLE:
        name, values, place = _from_mesh(path, key, mesh)
    else:
        raise FieldError(f"{path.name}: no arrays are read from '{extension}'; known are {_KNOWN} {' '.join(READABLE)}")
    values = _checked(spec, values)
    return Field(name, _location(spec, len(values), place, mesh), values)


def field_file(spec: str) -> Path:
    """The file that a field is read from; FieldError if it is not there."""
    return _split(spec)[0]


def _split(spec: str) -> tuple[Path, str]:
    """File and array; a path may have colons of its own, so the file is the longest part that is one."""
    cuts = [len(spec), *(i for i in reversed(range(len(spec))) if spec[i] == ":")]
    for cut in cuts:
        if cut and Path(spec[:cut]).is_file():
            return Path(spec[:cut]), spec[cut + 1 :]
    # Nothing is there: what stands before the last colon (but not that of a drive) is what was meant.
    head = spec.rpartition(":")[0]
    shown = Path(head if len(head) > 1 else spec)
    raise FieldError(
        f"{shown}: {'it is a folder' if shown.is_dir() else 'there is no such file'}, in the field '{spec}'"
    )


def _choose(path: Path, key: str, names: list[str]) -> str:
    if key in names:
        return key
    there = f"there are {', '.join(names)}" if names else "it holds none"
    if not key:
        raise FieldError(f"{path.name}: say which array, as in '{path.name}:NAME'; {there}")
    raise FieldError(f"{path.name} has no array '{key}'; {there}")


def _load(path: Path) -> NDArray[Any] | dict[str, NDArray[Any]]:
    data = content(path)
    try:
        return read_numpy(data)
    except Exception as error:  # zipfile, pickle, struct and numpy each have their own
        raise FieldError(f"{path.name} cannot be read as a numpy file: {' '.join(str(error).split())[:150]}") from error


def _from_npz(path: Path, key: str) -> NDArray[Any]:
    archive = _load(path)
    if isinstance(archive, np.ndarray):
        raise FieldError(f"{path.name} is not an archive of arrays, whatever its name says; is it a .npy file?")
    return archive[_choose(path, key, list(archive))]


def _from_npy(path: Path) -> NDArray[Any]:
    array = _load(path)
    if isinstance(array, dict):
        raise FieldError(f"{path.name} is an archive of arrays, whatever its name says; is it a .npz file?")
    return array


def _from_csv(path: Path, key: str) -> NDArray[Any]:
    """Columns by the names in the first line."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            header = [name.strip() for name in next(csv.reader(stream), [])]
            wanted = [key] if key in header else key.split(",")
            columns = [header.index(_choose(path, name.strip(), header)) for name in wanted]
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # no rows: the count of rows is checked later
                values = np.loadtxt(stream, delimiter=",", usecols=columns, ndmin=2, quotechar='"', comments=None)
    except _UNREADABLE as error:
        raise FieldError(f"{path.name} cannot be read as a table: {error}") from error
    except ValueError as error:
        try:
            told = _cell(path, header, columns)
        except _UNREADABLE as worse:
            raise FieldError(f"{path.name} cannot be read as a table: {worse}") from worse
        raise FieldError(f"{path.name}: {told or error}") from error
    return values[:, 0] if len(columns) == 1 else values


def _cell(path: Path, header: list[str], columns: list[int]) -> str:
    """Which cell of the columns is not a number; slow, and only for a message."""
    with path.open(newline="", encoding="utf-8-sig") as stream:
        for number, row in enumerate(csv.reader(stream)):
            for column in columns if number and row else ():
                if column >= len(row):
                    return f"row {number - 1} ends before column '{header[column]}'"
                try:
                    float(row[column])
                except ValueError:
                    return f"row {number - 1} of column '{header[column]}' is '{row[column]}', which is not a number"
    return ""


def _from_mesh(path: Path, key: str, mesh: TriangleMesh) -> tuple[str, NDArray[Any], Location]:
    fields = [field for field in read(path).fields if field.location != "mesh"]
    _choose(path, key, list(dict.fromkeys(field.name for field in fields)))
    rows = {"vertex": mesh.n_vertices, "face": mesh.n_faces}
    same = [field for field in fields if field.name == key]
    # A file may have the name on vertices and on faces: then the one that fits.
    best = next((field for field in same if len(field.values) == rows[field.location]), same[0])
    return best.name, np.asarray(best.values), best.location


def _checked(spec: str, values: Any) -> NDArray[Any]:
    """Real, finite numbers in rows."""
    values = np.asarray(values)
    if values.dtype.kind not in "fiub":
        raise FieldError(f"{spec}: the array is of {values.dtype}, not of real numbers")
    if values.ndim not in (1, 2) or values.shape[1:] == (0,):
        raise FieldError(f"{spec}: an array of shape {values.shape} has no rows to lay on a mesh")
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    if values.dtype.kind != "f":
        return values.astype(values.dtype.newbyteorder("="))
    finite = np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
    if not finite.all():
        bad = int(np.argmin(finite))
        shown = " ".join(map(str, np.atleast_1d(values[bad]).tolist()))
        raise FieldError(f"{spec}: row {bad} is not a finite number ({shown})")
    return values.astype(np.float64)


def _location(spec: str, rows: int, place: Location | None, mesh: TriangleMesh) -> Location:
    n, m = mesh.n_vertices, mesh.n_faces
    if n == m == rows:
        return place or "face"
    if rows == n:
        return "vertex"
    if rows == m:
        return "face"
    raise FieldError(f"{spec} has {rows} rows; the mesh has {n} vertices and {m} faces")
