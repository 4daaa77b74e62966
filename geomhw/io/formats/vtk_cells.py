"""VTK cell types in readers: which are faces of a surface, which are ignored, and which are refused."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, ranges
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, plane_pieces, strip_triangles
from geomhw.results import Result
from geomhw.wording import counted

#: Cells that are polygons with their corners in order: triangle, polygon, quad.
POLYGON = 7
_FACES = (5, POLYGON, 9)
#: The cells of polydata that come before and after its polygons.
VERTEX, LINE, STRIP = 2, 4, 6
#: A quad whose last two corners are exchanged.
_PIXEL = 8
#: Faces of second order: triangles of 6 and 7 nodes, quads of 8 and 9, and the number of nodes.
_CURVED = {22: 6, 34: 7, 23: 8, 28: 9}
_NAMES = {0: "empty", 1: "vertex", 2: "vertex", 3: "line", 4: "line", 6: "triangle strip", 8: "pixel", 10: "tetra"}
_NAMES |= {11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid", 21: "quadratic edge"}
#: Cells beside which faces are read.
_VOLUMES = {10, 11, 12, 13, 14, 15, 16, 24, 25, 26, 27, 29, 32, 33, 42, 71, 72, 73, 74}
_IGNORED = {0, 1, 2, 3, 4, 21} | _VOLUMES


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
    remarks: list[str] = field(default_factory=list)


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


def joined(name: str, parts: Sequence[Dataset]) -> Dataset:
    """Return the pieces of a file as one dataset, with the arrays that all of them have in one width."""
    if len(parts) == 1:
        return parts[0]
    if any(part.points is None for part in parts):
        raise FormatError(f"{name} has no points in some of its pieces")
    points = [part.points.reshape(-1, 3) for part in parts if part.points is not None]
    begins = np.cumsum([0, *(len(piece) for piece in points)])
    dataset = Dataset(points=np.concatenate(points), remarks=[remark for part in parts for remark in part.remarks])
    for part, begin, size in zip(parts, begins, map(len, points), strict=False):
        for cells in part.cells:
            if len(cells.corners) and not 0 <= cells.corners.min() <= cells.corners.max() < size:
                raise FormatError(f"{name}: a cell names a vertex beyond the {size} of its piece")
            dataset.cells.append(Cells(cells.corners + begin, cells.sizes, cells.types))
    for kind in ("vertex_arrays", "cell_arrays"):
        found = [getattr(part, kind) for part in parts]
        every = {key: [arrays[key] for arrays in found if key in arrays] for arrays in found for key in arrays}
        for key, values in every.items():
            if len(values) == len(parts) and len({piece.shape[1:] for piece in values}) == 1:
                getattr(dataset, kind)[key] = np.concatenate(values)
            else:
                dataset.remarks.append(f"left out array '{key}', which is not alike in all pieces")
    return dataset


def surface(name: str, kind: str, data: Dataset) -> Result:
    """Return the triangles, quads and polygons of a VTK file, with their rows of the cell arrays."""
    if data.points is None or not data.cells:
        raise FormatError(f"{name} has no {'points' if data.points is None else 'cells'}")
    if data.points.size % 3:
        raise FormatError(f"{name} has points of {data.points.size} coordinates, which is not three for each")
    corners = np.concatenate([cells.corners for cells in data.cells])
    sizes = np.concatenate([cells.sizes for cells in data.cells])
    types = np.concatenate([cells.types for cells in data.cells])
    present = types[:1] if (types == types[:1]).all() else np.unique(types)
    other = ~np.isin(present, (*_FACES, _PIXEL, STRIP, *_CURVED))
    others = {int(t): _NAMES.get(int(t), f"type {t}") for t in present[other]}
    names = ", ".join(dict.fromkeys(others.values()))
    refused = [label for t, label in others.items() if t not in _IGNORED]
    if refused or (others.keys() & _VOLUMES and other.all()):
        raise FormatError(
            f"{name} holds {', '.join(refused) or names} cells"
            + ("" if refused else " and no faces")
            + "; a surface is "
            "made of triangles and polygons: extract it first"
        )
    if other.all():
        raise FormatError(f"{name} has no faces" + (f", only {names} cells" if others else ""))
    for key, array in data.cell_arrays.items():
        if len(array) != len(types):
            raise FormatError(f"{name}: array '{key}' has {len(array)} rows for {len(types)} cells")
    for curved in _CURVED.keys() & set(present.tolist()):
        if (bad := (types == curved) & (sizes != _CURVED[curved])).any():
            at = int(np.argmax(bad))
            raise FormatError(f"{name}: cell {at} has {sizes[at]} nodes, but cells of its type have {_CURVED[curved]}")
    cells = np.arange(len(sizes))
    if others or not np.isin(present, _FACES).all():
        corners, sizes, cells = _faces(corners, sizes, types)
    content = Polygons(
        points=data.points.reshape(-1, 3),
        corners=corners,
        sizes=sizes,
        vertex_arrays=data.vertex_arrays,
        face_arrays={key: array[cells] for key, array in data.cell_arrays.items()},
        mesh_arrays=data.mesh_arrays,
        notes={"ignored": sorted(set(others.values()))} if others else {},
        remarks=[*data.remarks, *_remarks(types, names if others.keys() & _VOLUMES else "")],
    )
    return build_result(name, kind, content)


def _remarks(types: Ints, left_out: str) -> Iterator[str]:
    """Remarks on faces of second order and on cells that are left out."""
    if curved := int(np.isin(types, list(_CURVED)).sum()):
        yield f"divided {counted(curved, 'face')} of second order into plane pieces at their nodes"
    if left_out:
        yield f"left out cells that are no faces: {left_out}"


def _faces(corners: Ints, sizes: Ints, types: Ints) -> tuple[Ints, Ints, Ints]:
    """The faces among cells, in their order, with strips and curved faces divided: corners, sizes, cell of each."""
    begins = np.cumsum(sizes) - sizes
    pixels = begins[(types == _PIXEL) & (sizes == 4)]
    corners = corners.copy()
    corners[pixels + 2], corners[pixels + 3] = corners[pixels + 3], corners[pixels + 2]
    strips, plain = np.flatnonzero(types == STRIP), np.flatnonzero(np.isin(types, (*_FACES, _PIXEL)))
    triangles, strip = strip_triangles(corners[ranges(begins[strips], sizes[strips])], sizes[strips])
    parts = [
        (corners[ranges(begins[plain], sizes[plain])], sizes[plain], plain),
        (triangles, np.full(len(strip), 3), strips[strip]),
    ]
    for kind, nodes in _CURVED.items():
        curved = np.flatnonzero(types == kind)
        pieces, counts, face = plane_pieces(corners[begins[curved, None] + np.arange(nodes)])
        parts.append((pieces, counts, curved[face]))
    flat, counts, cells = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(cells, kind="stable")
    return flat[ranges((np.cumsum(counts) - counts)[order], counts[order])], counts[order], cells[order]
