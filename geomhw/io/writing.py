"""Writing results: all of the files, or none of them."""

import os
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from geomhw.errors import FieldError, FormatError
from geomhw.io.atomic import replacing, why_not_writable
from geomhw.io.formats import gifti_write
from geomhw.io.formats.csv_write import row_location, write_table
from geomhw.io.formats.gifti_write import write_func, write_gii, write_label, write_surface
from geomhw.io.formats.gltf_write import kept_arrays, write_glb
from geomhw.io.formats.ply_write import write_ply
from geomhw.io.formats.vtk_write import write_vtk
from geomhw.io.formats.vtk_xml_write import write_vtp, write_vtp_cloud, write_vtu
from geomhw.options import Location
from geomhw.results import Cloud, Result

_WRITERS = {".vtk": write_vtk, ".vtp": write_vtp, ".vtu": write_vtu, ".ply": write_ply, ".gii": write_gii}
_WRITERS |= {".glb": write_glb, ".csv": write_table}
_WRITERS_OF_GIFTI = {".gii": write_gii, ".surf.gii": write_surface, ".func.gii": write_func, ".label.gii": write_label}
#: Extensions that ``write`` knows.
WRITABLE = tuple(_WRITERS)


def write(result: Result, paths: str | Path | Sequence[str | Path], *, compress: bool = False) -> None:
    """Write a mesh and its fields to one or several files; equal results give equal bytes.

    Parameters
    ----------
    result
        Mesh, fields of real numbers; the report is not written.
    paths
        Files with the extensions ``WRITABLE``. On any error, all of them stay as they were.
    compress
        Compress the arrays of ``.vtp`` files by zlib.

    Raises
    ------
    FormatError
        If a file cannot be written; see `check_outputs`.
    FieldError
        If a field has no name, the name of another field at the same location, or values that are not real numbers.

    Examples
    --------
    >>> import tempfile
    >>> from geomhw.io import read, write
    >>> from geomhw.mesh.primitives import icosphere
    >>> from geomhw.results import Field, Result
    >>> mesh = icosphere(1)
    >>> result = Result(mesh, [Field("height", "vertex", mesh.vertices[:, 2])])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(result, [f"{folder}/ball.vtp", f"{folder}/ball.ply"])
    ...     read(f"{folder}/ball.ply")["height"].shape
    (42,)
    """
    targets = [paths] if isinstance(paths, str | Path) else list(paths)
    check_outputs(targets)
    _check_fields(result)
    with replacing(targets) as temporaries:
        for target, temporary in zip(map(Path, targets), temporaries, strict=True):
            extension = target.suffix.lower()
            with temporary.open("wb") as stream:
                if compress and extension == ".vtp":
                    write_vtp(result, stream, compress=True)
                elif extension == ".gii":
                    _WRITERS_OF_GIFTI[gifti_write.ending(target)](result, stream)
                else:
                    _WRITERS[extension](result, stream)


def writing_remarks(result: Result, path: str | Path) -> list[str]:
    """Return sentences on what a file of this name does not hold of a result, or holds in another form.

    Examples
    --------
    >>> from geomhw.io import writing_remarks
    >>> from geomhw.mesh.primitives import icosphere
    >>> from geomhw.results import Field, Result
    >>> mesh = icosphere(1)
    >>> writing_remarks(Result(mesh, [Field("area", "face", mesh.face_areas)]), "ball.gii")
    ['ball.gii is without area (per face), for it holds arrays on vertices']
    """
    path = Path(path)
    extension = path.suffix.lower()
    if extension == ".gii":
        return gifti_write.remarks_on(result, path)
    if extension not in (".glb", ".csv"):
        return []
    if extension == ".glb":
        kept, what = [name for name, _ in kept_arrays(result)], "vertices, of four components at most"
        location: Location = "vertex"
    else:
        location = row_location(result)
        kept, what = [item.name for item in result.fields], "vertices" if location == "vertex" else "faces"
    left = [f"{f.name} (per {f.location})" for f in result.fields if f.location != location or f.name not in kept]
    remarks = [f"{path.name} is without {', '.join(left)}, for it holds arrays on {what}"] if left else []
    return remarks + [f"{path.name} is in single precision, as glTF is"] * (extension == ".glb")


def write_stream(result: Result, stream: BinaryIO, extension: str) -> None:
    """Write a mesh and its fields to a stream of bytes, in the format of an extension of ``WRITABLE``.

    Raises
    ------
    FieldError
        As `write` does.
    """
    _check_fields(result)
    _WRITERS[extension](result, stream)


def write_cloud(cloud: Cloud, path: str | Path, *, compress: bool = False) -> None:
    """Write points and their fields to a ``.vtp`` file atomically; arguments and errors are those of `write`."""
    check_outputs([path], extensions=[".vtp"])
    _check_fields(cloud)
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        write_vtp_cloud(cloud, stream, compress)


def check_outputs(
    paths: Sequence[str | Path], inputs: Sequence[str | Path] = (), *, extensions: Collection[str] = WRITABLE
) -> None:
    """Check that files can be written, before the computation that fills them.

    Parameters
    ----------
    paths
        Files to write.
    inputs
        Files that must not be overwritten, under any name.
    extensions
        Allowed extensions, lower case.

    Raises
    ------
    FormatError
        If an extension is not allowed, a folder does not exist, a target is a folder or a device, two targets are the
        same file, or a target is an input.
    """
    for i, path in enumerate(paths):
        suffix = Path(path).suffix
        reason = why_not_writable(Path(path))
        if os.path.isdir(path):
            reason = "it is a folder; give a file in it"
        elif suffix.lower() not in extensions:
            kind = f"'{suffix}' is not a format that is written here" if suffix else "the name has no extension"
            reason = f"{kind}; known are {' '.join(extensions)}"
        elif not reason and any(_same(path, other) for other in paths[:i]):
            reason = "two of the outputs would be this one file"
        elif not reason and (clash := next((source for source in inputs if _same(path, source)), None)):
            reason = f"it is the input {clash}, which would be lost"
        if reason:
            raise FormatError(f"cannot write {path}: {reason}")


def _same(one: str | Path, other: str | Path) -> bool:
    try:
        return os.path.samefile(one, other)
    except OSError:  # one of them does not exist
        return os.path.realpath(one) == os.path.realpath(other)


def _check_fields(result: Result | Cloud) -> None:
    names = set()
    for field in result.fields:
        values = np.asarray(field.values)
        if values.dtype.kind not in "fiub":
            raise FieldError(f"field '{field.name}' cannot be written: its values are {values.dtype}, not real numbers")
        if not field.name or (field.location, field.name) in names:
            what = f"two {field.location} fields are named '{field.name}'" if field.name else "a field has no name"
            raise FieldError(f"cannot write the result: {what}")
        names.add((field.location, field.name))
