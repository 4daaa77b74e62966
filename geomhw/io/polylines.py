"""Reading polylines: VTP, lines of OBJ files, tables with the columns x, y and z, and borders of Workbench."""

from pathlib import Path

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FormatError
from geomhw.io.artifacts.tables import read_csv
from geomhw.io.file_content import read_bytes, read_lines
from geomhw.io.formats.border_read import read_border
from geomhw.io.reading import read_cloud
from geomhw.results import Cloud, Field

#: Extensions of files of polylines.
POLYLINES = (".vtp", ".obj", ".csv", ".border")
#: Names of columns that number the curve of a row.
_CURVE = ("path", "id", "curve", "line")


def read_polylines(path: str | Path, vertices: Floats | None = None) -> Cloud:
    """Read polylines with their points in order.

    Parameters
    ----------
    path
        A ``.vtp`` with lines, an ``.obj`` with ``l`` elements, or a ``.csv`` with the columns x, y, z, and for several
        curves one of path, id, curve or line. Lines that continue each other, such as single segments, are joined.

    Returns
    -------
    Cloud with polylines; with the fields of a ``.vtp`` file and the columns of a table.

    Raises
    ------
    FormatError
        If the file cannot be read or holds no polyline.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "c.obj").write_text("v 0 0 0\\nv 1 0 0\\nv 1 1 0\\nl 1 2\\nl 2 3\\n")
    ...     read_polylines(f"{folder}/c.obj").lines.tolist()
    [0, 3]
    """
    path = Path(path)
    extension = path.suffix.lower()
    if extension == ".vtp":
        cloud = read_cloud(path)
        if cloud.lines is None or not len(cloud.points):
            raise FormatError(f"{path.name} holds no polyline; it needs cells of lines")
        return cloud
    if extension == ".obj":
        return _from_obj(path)
    if extension == ".csv":
        return _from_table(path)
    if extension == ".border" and vertices is not None:
        return read_border(path.name, read_bytes(path), vertices)
    raise FormatError(f"{path}: curves are read from {' '.join(POLYLINES)}, not from '{extension}'")


def _from_obj(path: Path) -> Cloud:
    """Return the lines of an OBJ file, single segments joined."""
    points: list[list[float]] = []
    lines: list[list[int]] = []
    for number, line in read_lines(path):
        key, *words = line.split()
        try:
            if key == "v":
                points.append([float(word) for word in words[:3]])
            elif key == "l":
                indices = [int(word.split("/")[0]) for word in words]
                lines.append([i - 1 if i > 0 else len(points) + i for i in indices])
        except ValueError:
            raise FormatError(f"{path.name}, line {number}: '{line[:60]}' is no point or line") from None
    if any(i < 0 or i >= len(points) for item in lines for i in item):
        raise FormatError(f"{path.name}: a line names a point that does not exist; there are {len(points)}")
    return _cloud(path, np.array(points, dtype=float).reshape(-1, 3), _chained(lines))


def _from_table(path: Path) -> Cloud:
    """Return the curves of a table: consecutive rows of one number."""
    columns = read_csv(path)
    if not {"x", "y", "z"} <= set(columns):
        raise FormatError(f"{path.name} needs the columns x, y and z; it has {', '.join(columns)}")
    try:
        points = np.stack([np.asarray(columns[name], dtype=float) for name in "xyz"], axis=1)
    except ValueError:
        raise FormatError(f"{path.name}: a coordinate is not a number") from None
    key = next((name for name in _CURVE if name in columns), None)
    names = columns[key] if key else np.zeros(len(points))
    lines = [np.flatnonzero(names == name).tolist() for name in dict.fromkeys(names.tolist())]
    cloud = _cloud(path, points, lines)
    order = np.concatenate(lines).astype(np.int64)
    wanted = ["face", "b0", "b1", "b2"]
    if not set(wanted) <= set(columns):
        return cloud
    weights = np.stack([np.asarray(columns[name], dtype=float) for name in wanted[1:]], axis=1)[order]
    fields = [Field("face", "vertex", np.asarray(columns["face"])[order]), Field("barycentric", "vertex", weights)]
    return Cloud(cloud.points, fields, cloud.lines)


def _cloud(path: Path, points: Floats, lines: list[list[int]]) -> Cloud:
    """Return points as polylines by their indices."""
    lines = [line for line in lines if line]
    if not lines:
        raise FormatError(f"{path.name} holds no polyline")
    order = np.concatenate([np.array(line, dtype=np.int64) for line in lines])
    return Cloud(points[order], (), np.append(0, np.cumsum([len(line) for line in lines])))


def _chained(lines: list[list[int]]) -> list[list[int]]:
    """Join lines where one starts at the end of the one before."""
    joined: list[list[int]] = []
    for line in lines:
        if joined and line and joined[-1][-1] == line[0] and joined[-1][0] != joined[-1][-1]:
            joined[-1] += line[1:]
        else:
            joined.append(list(line))
    return joined
