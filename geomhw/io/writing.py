"""The one way out: a result, and the files to write it to, all of them or none."""

import os
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

import numpy as np

from geomhw.errors import FieldError, FormatError
from geomhw.io.atomic import replacing, why_not_written
from geomhw.io.formats.ply_write import write_ply
from geomhw.io.formats.vtk_write import write_legacy_vtk, write_vtp, write_vtp_cloud, write_vtu
from geomhw.results import Cloud, Result

_WRITERS: dict[str, Callable[[Result, Path], None]] = {
    ".vtk": write_legacy_vtk,
    ".vtp": write_vtp,
    ".vtu": write_vtu,
    ".ply": write_ply,
}

#: Extensions that ``write`` knows.
WRITABLE = tuple(_WRITERS)


def write(result: Result, paths: str | Path | Sequence[str | Path]) -> None:
    """Write the mesh and its fields to every path, or, on any failure, leave all of them as they were."""
    targets = [paths] if isinstance(paths, str | Path) else list(paths)
    check_outputs(targets)
    _check_fields(result)
    with replacing(targets) as temporaries:
        for temporary in temporaries:
            _WRITERS[temporary.suffix.lower()](result, temporary)


def write_cloud(cloud: Cloud, path: str | Path) -> None:
    """Write points and their fields to a ``.vtp``, whole or not at all."""
    check_outputs([path], extensions=[".vtp"])
    _check_fields(cloud)
    with replacing([path]) as (temporary,):
        write_vtp_cloud(cloud, temporary)


def check_outputs(
    paths: Sequence[str | Path], inputs: Sequence[str | Path] = (), *, extensions: Collection[str] = WRITABLE
) -> None:
    """FormatError where writing to ``paths`` could not end well, to be found out before hours of computing.

    An extension that is not among ``extensions``, a folder that does not exist, a target that is a folder or a device,
    two targets that are one file, a target that is an input (under whatever name).
    """
    for i, path in enumerate(paths):
        target = Path(path)
        if target.suffix.lower() not in extensions:
            said = (
                f"'{target.suffix}' is not a format that is written" if target.suffix else "the name has no extension"
            )
            raise FormatError(f"cannot write {path}: {said} here; known are {' '.join(extensions)}")
        if reason := why_not_written(target):
            raise FormatError(f"cannot write {path}: {reason}")
        if any(_same(path, other) for other in paths[:i]):
            raise FormatError(f"cannot write {path}: two of the outputs would be this one file")
        if clash := next((source for source in inputs if _same(path, source)), None):
            raise FormatError(f"cannot write {path}: it is the input {clash}, which would be lost")


def _same(one: str | Path, other: str | Path) -> bool:
    try:
        return os.path.samefile(one, other)
    except OSError:  # one of them does not exist
        return os.path.realpath(one) == os.path.realpath(other)


def _check_fields(result: Result | Cloud) -> None:
    taken = set()
    for field in result.fields:
        values = np.asarray(field.values)
        if values.dtype.kind not in "fiub":
            raise FieldError(f"field '{field.name}' cannot be written: its values are {values.dtype}, not real numbers")
        if not field.name or (field.location, field.name) in taken:
            what = f"two {field.location} fields are named '{field.name}'" if field.name else "a field has no name"
            raise FieldError(f"cannot write the result: {what}")
        taken.add((field.location, field.name))
