"""Reader of glTF 2.0, ``.glb`` and ``.gltf`` with its buffers: the triangles of the default scene, in its space.

Hand-written because trimesh and pygltflib trust the offsets and counts in a file. [glTF 2.0 Specification]
"""

import base64
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.file_content import read_bytes
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons, strip_triangles
from geomhw.mesh.welding import distinct_points
from geomhw.results import Result
from geomhw.wording import counted

_MAGIC, _JSON, _BINARY = b"glTF", b"JSON", b"BIN\0"
_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
#: Nodes and primitives in a scene, at most: one node may be used many times.
_MOST = 1 << 16
_DAMAGE = (ValueError, KeyError, IndexError, TypeError, AttributeError, OverflowError, RecursionError)


@dataclass
class _Part:
    """A primitive at its place in the scene."""

    points: Floats
    corners: Ints
    arrays: dict[str, NDArray[Any]]
    node: str
    material: int


@dataclass
class _Document:
    """The JSON tree and the buffers of a file."""

    tree: dict[str, Any]
    buffers: list[bytes]
    parts: list[_Part] = field(default_factory=list)
    ignored: set[str] = field(default_factory=set)


def read_glb(name: str, data: bytes) -> Result:
    """Return the triangles of a binary file."""
    try:
        version, size = int.from_bytes(data[4:8], "little"), int.from_bytes(data[8:12], "little")
        if data[:4] != _MAGIC:
            raise ValueError("it has no header of GLB")
        _check_version(name, version)
        if size > len(data):
            raise ValueError(f"it says {size} bytes, of which {len(data)} are there")
        chunks: dict[bytes, bytes] = {}
        begin = 12
        while begin + 8 <= size:
            length, kind = int.from_bytes(data[begin : begin + 4], "little"), data[begin + 4 : begin + 8]
            if begin + 8 + length > size:
                raise ValueError("a chunk ends after the file")
            chunks.setdefault(kind, data[begin + 8 : begin + 8 + length])
            begin += 8 + length
        return _result(name, "GLB", json.loads(chunks[_JSON].decode("utf-8")), chunks.get(_BINARY))
    except _DAMAGE as error:
        raise _damaged(name, error) from error


def read_gltf(name: str, data: bytes, folder: Path | None = None) -> Result:
    """Return the triangles of a text file whose buffers are in it, or in files that it names relative to the folder."""
    try:
        tree = json.loads(data.decode("utf-8-sig"))
        _check_version(name, int(float(tree["asset"]["version"])))
        return _result(name, "glTF", tree, None, folder)
    except _DAMAGE as error:
        raise _damaged(name, error) from error


def _check_version(name: str, version: int) -> None:
    if version != 2:
        raise FormatError(f"{name} is in version {version} of glTF; only version 2 is read: convert it")


def _damaged(name: str, error: Exception) -> FormatError:
    reason = " ".join(str(error).split())[:120]
    return FormatError(f"{name} is not a whole glTF file: {f'no {reason}' if isinstance(error, KeyError) else reason}")


def _result(name: str, kind: str, tree: dict[str, Any], binary: bytes | None, folder: Path | None = None) -> Result:
    for extension in tree.get("extensionsRequired", ()):
        if extension != "KHR_mesh_quantization" and "compression" in extension:
            raise FormatError(f"{name} is compressed by {extension[:60]}, which is not read; save it without")
    buffers = []
    for i, entry in enumerate(tree.get("buffers", ())):
        if "uri" not in entry:
            buffers.append(binary or b"")
        elif entry["uri"].startswith("data:"):
            buffers.append(base64.b64decode(entry["uri"].partition(",")[2], validate=True))
        else:
            buffers.append(_external(name, folder, entry["uri"], _index(entry["byteLength"])))
        if len(buffers[i]) < entry["byteLength"]:
            raise ValueError(f"buffer {i} says {entry['byteLength']} bytes, of which {len(buffers[i])} are there")
    document = _Document(tree, buffers)
    scenes = tree.get("scenes", [])
    roots = scenes[tree.get("scene", 0)].get("nodes", []) if scenes else range(len(tree.get("nodes", ())))
    _collect(document, [(node, np.eye(4), 1) for node in roots])
    if not document.parts:
        raise FormatError(f"{name} holds no triangles in its scene")
    return build_result(name, kind, _joined(document))


def _external(name: str, folder: Path | None, uri: str, size: int) -> bytes:
    """The first bytes of a file that is named relative to the folder of the glTF file."""
    parts = urlsplit(uri)
    if folder is None or parts.scheme or parts.netloc or parts.path.startswith(("/", "\\")):
        raise FormatError(f"{name} keeps its data in {uri[:60]}; save it as one .glb file")
    try:
        return read_bytes(folder / unquote(parts.path), limit=size)
    except FormatError as error:
        raise FormatError(f"{name} keeps its data in another file: {error}") from error


def _collect(document: _Document, waiting: list[tuple[int, Floats, int]]) -> None:
    """Walk over the nodes of the scene, given the roots with their transforms and their depth, 1."""
    tree, visited = document.tree, 0
    while waiting:
        number, outer, depth = waiting.pop(0)
        if number < 0 or depth > len(tree["nodes"]) or (visited := visited + 1) > _MOST:
            raise ValueError("its nodes form a circle, or are too many")
        node = tree["nodes"][number]
        with np.errstate(all="ignore"):
            place = outer @ _matrix(node)
        if not np.isfinite(place).all():
            raise ValueError(f"the transform of node {number} is not finite")
        waiting += [(child, place, depth + 1) for child in node.get("children", ())]
        if "mesh" in node:
            mesh = tree["meshes"][_index(node["mesh"])]
            for primitive in mesh["primitives"]:
                title = str(node.get("name") or mesh.get("name") or f"node {number}")
                _add(document, primitive, place, title)


def _index(number: Any) -> int:
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise ValueError(f"{str(number)[:30]} is no index")
    return number


def _matrix(node: dict[str, Any]) -> Floats:
    """The transform of a node: a matrix by columns, or translation, rotation (a quaternion x y z w) and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", [0, 0, 0, 1]), dtype=float)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]), dtype=float).reshape(3)
    matrix[:3, 3] = np.array(node.get("translation", [0, 0, 0]), dtype=float).reshape(3)
    return matrix


def _add(document: _Document, primitive: dict[str, Any], place: Floats, title: str) -> None:
    """Add a primitive of triangles."""
    mode = primitive.get("mode", _TRIANGLES)
    if mode not in (_TRIANGLES, _STRIP, _FAN):
        document.ignored.add("points" if mode == 0 else "lines")
        return
    if len(document.parts) >= _MOST:
        raise ValueError("it has too many primitives")
    attributes = primitive["attributes"]
    with np.errstate(invalid="ignore"):  # a signaling NaN
        local = _accessor(document, attributes["POSITION"]).astype(float)
    if local.ndim != 2 or local.shape[1] != 3:
        raise ValueError("positions have no three coordinates")
    corners = np.arange(len(local))
    if "indices" in primitive:
        corners = _accessor(document, primitive["indices"])
        if corners.ndim != 1 or corners.dtype.kind == "f":
            raise ValueError("indices are no whole numbers")
    corners = corners.astype(np.int64)
    if mode == _STRIP:
        corners, _ = strip_triangles(corners, np.array([len(corners)]))
    elif mode == _FAN:
        middle = corners[1:-1]
        corners = np.stack([np.broadcast_to(corners[:1], middle.shape), middle, corners[2:]], axis=1).ravel()
    if len(corners) % 3 or corners.max(initial=-1) >= len(local):
        raise ValueError("indices do not form triangles of its vertices")
    with np.errstate(all="ignore"):
        is_mirrored = np.linalg.det(place[:3, :3]) < 0
    if is_mirrored:
        corners = corners.reshape(-1, 3)[:, ::-1].ravel()
    arrays = {}
    for key, accessor in attributes.items():
        if key == "COLOR_0" or key.startswith("_"):
            values = _accessor(document, accessor)
            if len(values) != len(local):
                raise ValueError(f"{key[:40]} has {len(values)} rows where there are {len(local)} vertices")
            arrays["color" if key == "COLOR_0" else key[1:].lower()] = values
    with np.errstate(all="ignore"):
        points = local if np.array_equal(place, np.eye(4)) else local @ place[:3, :3].T + place[:3, 3]
    material = primitive.get("material", -1)
    document.parts.append(_Part(points, corners, arrays, title, material if isinstance(material, int) else -1))


def _accessor(document: _Document, number: Any) -> NDArray[Any]:
    """The values of an accessor, (count,) or (count, width)."""
    entry = document.tree["accessors"][_index(number)]
    if "sparse" in entry:
        raise ValueError("it has a sparse accessor, which is not read")
    kind, width = np.dtype(_TYPES[entry["componentType"]]), _WIDTHS[entry["type"]]
    view = document.tree["bufferViews"][_index(entry["bufferView"])]
    buffer = document.buffers[_index(view["buffer"])]
    count, row = _index(entry["count"]), kind.itemsize * width
    stride = _index(view.get("byteStride", row))
    begin, offset = _index(view.get("byteOffset", 0)), _index(entry.get("byteOffset", 0))
    end = min(begin + _index(view["byteLength"]), len(buffer))
    if stride < row or count < 1 or begin + offset + stride * (count - 1) + row > end:
        raise ValueError(f"accessor {number} reaches beyond its buffer")
    shape, strides = (count, width), (stride, kind.itemsize)
    values = np.ndarray(shape, kind, buffer, begin + offset, strides)
    if entry.get("normalized") and kind.kind in "iu":
        values = np.maximum(values / np.iinfo(kind).max, -1.0)
    return values[:, 0] if width == 1 else values


def _joined(document: _Document) -> Polygons:
    """All primitives as one mesh; vertices of one position, which seams of normals and textures repeat, are joined."""
    parts = document.parts
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    points = np.concatenate([part.points for part in parts])
    corners = np.concatenate([part.corners + start for part, start in zip(parts, starts[:-1], strict=True)])
    first, joined = distinct_points(points)
    remarks = []
    if repeated := len(points) - len(first):
        remarks.append(f"joined {counted(repeated, 'vertex', 'vertices')} with others of the same position")
    arrays = {}
    for key, values in parts[0].arrays.items():
        if all(key in part.arrays and part.arrays[key].shape[1:] == values.shape[1:] for part in parts):
            arrays[key] = np.concatenate([part.arrays[key] for part in parts])[first]
    sizes = [len(part.corners) // 3 for part in parts]
    face_arrays, labels = {}, {}
    materials = document.tree.get("materials", [])
    names = [materials[p.material].get("name", f"material {p.material}") if p.material >= 0 else "none" for p in parts]
    for key, titles in (("group", [part.node for part in parts]), ("material", names)):
        numbers = {title: k for k, title in enumerate(dict.fromkeys(titles))}
        if len(numbers) > 1:
            face_arrays[key] = np.repeat(np.array([numbers[title] for title in titles], np.int32), sizes)
            labels[key] = {k: str(title) for title, k in numbers.items()}
    notes = {"ignored": sorted(document.ignored)} if document.ignored else {}
    count = len(corners) // 3
    return Polygons(
        points[first],
        joined[corners],
        np.full(count, 3),
        arrays,
        face_arrays,
        labels=labels,
        notes=notes,
        remarks=remarks,
    )
