"""Writer of binary glTF 2.0: triangles, vertex colors of the array that viewers show first, all arrays on vertices.

glTF has single precision and no arrays on faces.
"""

import json
import re
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.io.formats.vtk_write import active_arrays, arrays_at
from geomhw.results import Result

_ARRAY_BUFFER, _INDICES, _FLOAT, _UNSIGNED = 34962, 34963, 5126, 5125
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
#: Color of vertices without a finite value.
_GRAY = 0.5


def write_glb(result: Result, stream: BinaryIO) -> None:
    """Write one mesh; arrays of vertices of one to four components are attributes ``_NAME``."""
    mesh = result.mesh
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        attributes: dict[str, NDArray[Any]] = {"POSITION": mesh.vertices.astype("<f4")}
        if (colors := vertex_colors(result)) is not None:
            attributes["COLOR_0"] = colors.astype("<f4")
        for name, values in kept_arrays(result):
            attributes[_key(name, attributes)] = values.astype("<f4")
    blobs: list[bytes] = []
    views: list[dict[str, int]] = []
    accessors: list[dict[str, Any]] = []
    for key, values in [*attributes.items(), ("", mesh.faces.astype("<u4").ravel())]:
        begin = sum(len(blob) for blob in blobs)
        blobs.append(np.ascontiguousarray(values).tobytes())
        target = _ARRAY_BUFFER if key else _INDICES
        views.append({"buffer": 0, "byteOffset": begin, "byteLength": len(blobs[-1]), "target": target})
        width = 1 if values.ndim == 1 else values.shape[1]
        kind = _FLOAT if key else _UNSIGNED
        entry = {"bufferView": len(accessors), "componentType": kind, "count": len(values), "type": _TYPES[width]}
        if key == "POSITION":
            entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        accessors.append(entry)
    places = {key: k for k, key in enumerate(attributes)}
    primitive = {"attributes": places, "indices": len(places), "mode": 4, "material": 0}
    surface = {"metallicFactor": 0.0, "roughnessFactor": 0.8}
    tree = {
        "asset": {"version": "2.0", "generator": "geomhw"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [{"pbrMetallicRoughness": surface, "doubleSided": True}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": sum(len(blob) for blob in blobs)}],
    }
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = b"".join(blobs)  # all of four bytes a number
    stream.write(b"glTF" + _words(2, 28 + len(text) + len(body)) + _words(len(text)) + b"JSON" + text)
    stream.write(_words(len(body)) + b"BIN\0" + body)


def kept_arrays(result: Result) -> list[tuple[str, NDArray[Any]]]:
    """Return the arrays of vertices that the format holds."""
    return [(name, values) for name, values in arrays_at(result, "vertex") if values.ndim == 1 or values.shape[1] <= 4]


def vertex_colors(result: Result) -> Floats | None:
    """Return (n, 3) or (n, 4) numbers from 0 to 1: the array ``color``, or another one by a color map; None without.

    Colors of glTF are linear, so those of the color map are converted from sRGB.
    """
    named = dict(arrays_at(result, "vertex"))
    given = named.get("color")
    if given is not None and given.ndim == 2 and given.shape[1] in (3, 4) and 0 <= given.min() <= given.max() <= 1:
        return given
    scalar, _ = active_arrays([item for item in named.items() if item[1].ndim == 1])
    if scalar is None:
        return None
    import matplotlib

    values = scalar[1].astype(float)
    finite = np.isfinite(values)
    low, high = (values[finite].min(), values[finite].max()) if finite.any() else (0.0, 0.0)
    with np.errstate(all="ignore"):
        share = np.where(finite & (high > low), (values / 2 - low / 2) / (high / 2 - low / 2), 0.5)
    colors = matplotlib.colormaps["viridis"](share)[:, :3]
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return np.where(finite[:, None], linear, _GRAY)


def _key(name: str, taken: dict[str, NDArray[Any]]) -> str:
    key = "_" + re.sub(r"[^A-Z0-9_]", "_", name.upper())
    return key if key not in taken else f"{key}_{len(taken)}"


def _words(*numbers: int) -> bytes:
    return b"".join(number.to_bytes(4, "little") for number in numbers)
