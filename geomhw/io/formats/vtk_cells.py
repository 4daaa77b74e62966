"""VTK cell types in readers: which are faces of a surface, which are ignored, and which are refused."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, ranges
from geomhw.results import Result

#: Cells that are polygons with their corners in order: triangle, polygon, quad.
POLYGON = 7
_FACES = (5, POLYGON, 9)
#: The cells of polydata that come before and after its polygons.
VERTEX, LINE, STRIP = 2, 4, 6
_NAMES = {0: "empty", 1: "vertex", 2: "vertex", 3: "line", 4: "line", 6: "triangle strip", 8: "pixel", 10: "tetra"}
_NAMES |= {11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid", 21: "quadratic edge", 22: "quadratic triangle"}
_IGNORED = (0, 1, 2, 3, 4, 21)


@dataclass(frozen=True)
class Cells:
    """Cells: vertex indices, flat; the number of them in each cell; the VTK type of each cell."""

    corners: Ints
    sizes: Ints
    types: Ints


@dataclass
class Dataset:
    """Contents of a VTK file, filled while it is read."""

    points: Floats | None = None
    cells: list[Cells] = field(default_factory=list)
    vertex_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    cell_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    mesh_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)


def cells_from_offsets(name: str, connectivity: Ints, offsets: Ints, types: Ints | int) -> Cells:
    """Return cells given by the offsets in the connectivity at which they end."""
    for what, array in (("offsets", offsets), ("connectivity", connectivity), ("types", np.asarray(types))):
        if array.dtype.kind not in "iu" or array.ndim > 1:
            raise FormatError(f"{name}: the {what} of the cells are not a list of whole numbers")
    # Before differences, which may overflow.
    if (offsets[1:] < offsets[:-1]).any() or (len(offsets) and offsets[0] < 0):
        raise FormatError(f"{name}: the offsets of the cells do not ascend")
    if (int(offsets[-1]) if len(offsets) else 0) != len(connectivity):
        raise FormatError(f"{name}: the offsets of the cells do not fit their connectivity")
    sizes = np.diff(offsets.astype(np.int64), prepend=0)
    kinds = np.full(len(sizes), types) if isinstance(types, int) else types
    if len(kinds) != len(sizes):
        raise FormatError(f"{name} has {len(kinds)} cell types for {len(sizes)} cells")
    return Cells(connectivity.astype(np.int64), sizes, kinds)


def surface(name: str, kind: str, data: Dataset) -> Result:
    """Return the triangles, quads and polygons of a VTK file, with their rows of the cell arrays."""
    if data.points is None or not data.cells:
        raise FormatError(f"{name} has no {'points' if data.points is None else 'cells'}")
    if data.points.size % 3:
        raise FormatError(f"{name} has points of {data.points.size} coordinates, which is not three for each")
    corners = np.concatenate([cells.corners for cells in data.cells])
    sizes = np.concatenate([cells.sizes for cells in data.cells])
    types = np.concatenate([cells.types for cells in data.cells])
    is_face = np.isin(types, _FACES)
    others = {int(t): _NAMES.get(int(t), f"type {t}") for t in np.unique(types[~is_face])}
    if refused := [label for t, label in others.items() if t not in _IGNORED]:
        raise FormatError(f"{name} holds {', '.join(refused)} cells; a surface is made of triangles and polygons")
    if not is_face.any():
        raise FormatError(f"{name} has no faces" + (f", only {', '.join(others.values())} cells" if others else ""))
    for key, array in data.cell_arrays.items():
        if len(array) != len(is_face):
            raise FormatError(f"{name}: array '{key}' has {len(array)} rows for {len(is_face)} cells")
    content = Polygons(
        points=data.points.reshape(-1, 3),
        corners=corners[ranges((np.cumsum(sizes) - sizes)[is_face], sizes[is_face])] if others else corners,
        sizes=sizes[is_face],
        vertex_arrays=data.vertex_arrays,
        face_arrays={key: array[is_face] for key, array in data.cell_arrays.items()},
        mesh_arrays=data.mesh_arrays,
        notes={"ignored": sorted(set(others.values()))} if others else {},
    )
    return build_result(name, kind, content)
