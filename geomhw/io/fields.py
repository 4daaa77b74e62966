"""Fields on a mesh from files: ``moo.vtp:heat``, ``u.npy``, ``all.npz:u``, ``t.csv:x,y,z``."""

import csv
import os
import warnings
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.errors import FieldError
from geomhw.io.artifacts.arrays import read_numpy
from geomhw.io.file_content import read_bytes
from geomhw.io.formats.freesurfer_read import read_freesurfer_arrays
from geomhw.io.formats.gifti_read import parse_gifti
from geomhw.io.reading import READABLE, mesh_extension, read
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Location
from geomhw.results import Field


def read_field(spec: str, mesh: TriangleMesh, *, finite: bool = True) -> Field:
    """Read one array on the vertices or the faces of a mesh.

    Parameters
    ----------
    spec
        ``FILE:ARRAY``, where FILE is a mesh with arrays, a ``.npz``, or a ``.csv`` (ARRAY is a column, or several
        separated by commas); or the name of a ``.npy`` file. In files of GIFTI (``.func.gii``, ``.label.gii``) and of
        FreeSurfer (curv, ``.annot``, ``.label``, ``.mgh``, ``.mgz``), ARRAY is a name, a number from 0, or the name of
        a label, which gives 1 on its vertices and 0 elsewhere; it may be left away if there is one array.
    mesh
        Mesh that the array belongs to. The number of rows decides between vertices and faces. If the mesh has as
        many vertices as faces, the location in the file decides, or, without one, the array is on the faces.
    finite
        Whether infinite values and NaN are errors.

    Returns
    -------
    Field of shape (rows,) or (rows, components), floats in double precision.

    Raises
    ------
    FieldError
        If the file or the array does not exist, has another number of rows, or values that are not real numbers, or
        not finite.
    FormatError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from geomhw.io import read_field
    >>> from geomhw.mesh.primitives import icosphere
    >>> mesh = icosphere(1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.save(f"{folder}/u.npy", np.zeros(mesh.n_faces))
    ...     read_field(f"{folder}/u.npy", mesh).location
    'face'
    """
    path, key = _split(spec)
    extension = mesh_extension(path) or path.suffix.lower()
    location: Location | None = None
    labels = None
    if extension == ".npy" and key:
        raise FieldError(f"{path.name} holds one array without a name; leave ':{key}' away")
    if extension in (".npy", ".npz"):
        name, values = key or path.stem, _from_numpy(path, key)
    elif extension == ".csv":
        name, values = key, _from_csv(path, key)
    else:
        is_mesh = extension in READABLE and extension != ".gii"
        field = _from_mesh(path, key, mesh) if is_mesh else _one_of(path, key, _on_vertices(path, extension, mesh))
        name, values, location, labels = field.name, np.asarray(field.values), field.location, field.labels
    values = _checked(spec, values, finite)
    return Field(name, _location(spec, len(values), location, mesh), values, labels)


def field_file(spec: str) -> Path:
    """Return the file in the specification of a field; FieldError if it does not exist."""
    return _split(spec)[0]


def field_parts(spec: str) -> tuple[Path, str]:
    """Return the file and the name of the array, "" without one, in the specification of a field or of a mesh.

    Raises
    ------
    FieldError
        If the file does not exist.
    """
    return _split(spec)


def _split(spec: str) -> tuple[Path, str]:
    """File and array; a path may contain colons, so the file is the longest part that is a file."""
    cuts = [len(spec), *(i for i in reversed(range(len(spec))) if spec[i] == ":")]
    for cut in cuts:
        if cut and os.path.isfile(spec[:cut]):
            return Path(spec[:cut]), spec[cut + 1 :]
    # For the message: the part before the last colon, unless that is the colon of a drive.
    head = spec.rpartition(":")[0]
    shown = Path(head if len(head) > 1 else spec)
    reason = "it is a folder" if os.path.isdir(shown) else "there is no such file"
    if os.path.exists(shown) and not os.path.isdir(shown):
        reason = "it is no regular file"
    raise FieldError(f"{shown}: {reason}, in the field '{spec}'")


def _on_vertices(path: Path, extension: str, mesh: TriangleMesh) -> list[Field]:
    """All arrays of a file of GIFTI or FreeSurfer."""
    data = read_bytes(path) if path.stat().st_size else b""
    if extension == ".gii":
        return parse_gifti(path.name, data).arrays
    if found := read_freesurfer_arrays(path.name, data, mesh.n_vertices):
        return found
    known = " ".join((".npy", ".npz", ".csv", *READABLE))
    raise FieldError(
        f"{path.name}: no arrays are read from '{extension}'; known are {known} and files of FreeSurfer (curv, .annot, "
        ".label, .mgh, .mgz)"
    )


def _one_of(path: Path, key: str, fields: list[Field]) -> Field:
    """The array of a name or a number, the only one, or the vertices with the label of a name as 1 among 0."""
    if len(fields) == 1 and not key:
        return fields[0]
    for field in fields:
        if field.name == key:
            return field
    if key.isdecimal() and int(key) < len(fields):
        return fields[int(key)]
    tables = [field for field in fields if field.labels and key in field.labels.values()]
    if not tables:
        names = [field.name for field in fields]
        labels = [label for field in fields for label in (field.labels or {}).values()]
        known = f"{path.name} has no array or label '{key}'; there are {', '.join([*names, *labels])}"
        raise FieldError(known) if key and names else FieldError(_which(path, key, names))
    numbers = [number for number, label in (tables[0].labels or {}).items() if label == key]
    return Field(key, tables[0].location, np.isin(tables[0].values, numbers).astype(np.uint8))


def _choose(path: Path, key: str, names: list[str]) -> str:
    if key in names:
        return key
    raise FieldError(_which(path, key, names))


def _which(path: Path, key: str, names: list[str]) -> str:
    """The message about a missing or unknown name."""
    known = f"there are {', '.join(names)}" if names else "it holds none"
    if not key:
        return f"{path.name}: say which array, as in '{path.name}:NAME'; {known}"
    return f"{path.name} has no array '{key}'; {known}"


def _from_numpy(path: Path, key: str) -> NDArray[Any]:
    data = read_bytes(path)
    try:
        stored = read_numpy(data)
    except Exception as error:  # zipfile, struct and numpy each have their own errors
        raise FieldError(f"{path.name} cannot be read as a numpy file: {' '.join(str(error).split())[:150]}") from error
    is_npz = path.suffix.lower() == ".npz"
    if isinstance(stored, np.ndarray):
        if is_npz:
            raise FieldError(f"{path.name} is not an archive of arrays; is it a .npy file?")
        return stored
    if not is_npz:
        raise FieldError(f"{path.name} is an archive of arrays; is it a .npz file?")
    return stored[_choose(path, key, list(stored))]


def _from_csv(path: Path, key: str) -> NDArray[Any]:
    """Columns by the names in the first line."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            header = [name.strip() for name in next(csv.reader(stream), [])]
            wanted = [key] if key in header else key.split(",")
            columns = [header.index(_choose(path, name.strip(), header)) for name in wanted]
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", UserWarning)  # of no rows, whose number is checked later
                    values = np.loadtxt(stream, delimiter=",", usecols=columns, ndmin=2, quotechar='"', comments=None)
            except ValueError as error:
                raise FieldError(f"{path.name}: {_bad_cell(path, header, columns) or error}") from error
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FieldError(f"{path.name} cannot be read as a table: {error}") from error
    return values[:, 0] if len(columns) == 1 else values


def _bad_cell(path: Path, header: list[str], columns: list[int]) -> str:
    """Describe the first cell of some columns that is not a number; slow, and only for a message."""
    with path.open(newline="", encoding="utf-8-sig") as stream:
        for number, row in enumerate(islice(filter(None, csv.reader(stream)), 1, None)):
            for column in columns:
                if column >= len(row):
                    return f"row {number} ends before column '{header[column]}'"
                try:
                    float(row[column])
                except ValueError:
                    return f"row {number} of column '{header[column]}' is '{row[column]}', which is not a number"
    return ""


def _from_mesh(path: Path, key: str, mesh: TriangleMesh) -> Field:
    fields = [field for field in read(path).fields if field.location != "mesh"]
    if key and key not in [field.name for field in fields] and any(field.labels for field in fields):
        return _one_of(path, key, fields)
    _choose(path, key, list(dict.fromkeys(field.name for field in fields)))
    rows = {"vertex": mesh.n_vertices, "face": mesh.n_faces}
    same = [field for field in fields if field.name == key]
    # Of arrays with this name on vertices and on faces, the one that fits.
    return next((field for field in same if len(field.values) == rows[field.location]), same[0])


def _checked(spec: str, values: Any, must_be_finite: bool) -> NDArray[Any]:
    """Real numbers in rows, finite ones on demand, in native types."""
    values = np.asarray(values)
    if values.dtype.kind not in "fiub":
        raise FieldError(f"{spec}: the array is of {values.dtype}, not of real numbers")
    if values.ndim not in (1, 2) or values.shape[1:] == (0,):
        raise FieldError(f"{spec}: an array of shape {values.shape} has no rows to lay on a mesh")
    finite = np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
    if must_be_finite and not finite.all():
        bad = int(np.argmin(finite))
        shown = " ".join(map(str, np.atleast_1d(values[bad]).tolist()))
        raise FieldError(f"{spec}: row {bad} is not a finite number ({shown})")
    kinds: dict[str, Any] = {"f": np.float64, "b": np.uint8}
    return values.astype(kinds.get(values.dtype.kind, values.dtype.newbyteorder("=")))


def _location(spec: str, rows: int, location: Location | None, mesh: TriangleMesh) -> Location:
    n, m = mesh.n_vertices, mesh.n_faces
    if rows not in (n, m):
        raise FieldError(f"{spec} has {rows} rows; the mesh has {n} vertices and {m} faces")
    if n == m:
        return location or "face"
    return "vertex" if rows == n else "face"
