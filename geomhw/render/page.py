"""A page for the browser: one HTML file with a mesh, its arrays, a time series, curves and points, and the viewer.

The file needs no network and no server. Arrays are stored in single precision relative to their largest value, or as
integers, compressed by zlib and written in base64.
"""

import base64
import html
import json
import zlib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.sampling import spread_samples
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.colors import color_table
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.view import choose_view
from geomhw.results import Cloud, Result, answer_rank

#: Color maps of the menu; the first is taken for numbers of one sign, the second for both signs.
MAPS = ("viridis", "RdBu_r", "twilight", "cividis", "magma", "gray")
#: Scripts of the viewer, in the order in which they are read.
SCRIPTS = ("data.js", "camera.js", "drawing.js", "viewer.js")
#: Arrows at most, and the length of the longest, over the radius of the mesh.
ARROWS, LONGEST_ARROW = 1200, 0.09


def page(
    frames: Sequence[Result],
    times: Sequence[float] = (0.0,),
    *,
    title: str = "geomhw",
    active: str = "",
    clouds: Mapping[str, Cloud | Sequence[Cloud]] | None = None,
    look: Look = AUTOMATIC,
) -> str:
    """Return an HTML page that shows results in a browser.

    Parameters
    ----------
    frames
        Results on one mesh, one for each time. Arrays that all of them have change with time. The sources of the first
        are drawn as points.
    times
        Time of each frame, ascending.
    title
        Title of the page.
    active
        Name of the array that is shown first; by default the one that answers the question of a command.
    clouds
        Points or polylines by name; points that move are a list, one for each frame.
    look
        Its ``view``, ``up`` and ``zoom`` are those at the start.

    Raises
    ------
    FieldError
        If there is no frame, or a frame has another mesh than the first.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> from geomhw.results import Field
    >>> ball = icosphere(2)
    >>> text = page([Result(ball, [Field("height", "vertex", ball.vertices[:, 2])])])
    >>> text.startswith("<!DOCTYPE html>"), "https://" in text
    (True, False)
    """
    mesh = _mesh_of(frames, times)
    view = choose_view(mesh, look=look)
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) / 2 or 1.0
    center = mesh.vertices.min(axis=0) / 2 + mesh.vertices.max(axis=0) / 2

    def placed(positions: Floats) -> Floats:
        return np.asarray((np.asarray(positions, dtype=float) - center) / size)

    store = _Store()
    arrays = _arrays(frames, store, placed)
    layers = {name: [item] if isinstance(item, Cloud) else list(item) for name, item in (clouds or {}).items()}
    if (sources := frames[0].sources) is not None:
        layers["sources"] = [Cloud(sources.positions(mesh))]
    scene = {
        "n_vertices": mesh.n_vertices,
        "n_faces": mesh.n_faces,
        "center": center.tolist(),
        "size": size,
        "axes": view.axes.tolist(),
        "middle": (view.axes[:2] @ placed(view.center)).tolist(),
        "extent": (view.extent / size).tolist(),
        "positions": store.add(placed(mesh.vertices).astype("<f4")),
        "normals": store.add(np.round(127 * mesh.vertex_normals).astype("i1").view("u1")),
        "faces": store.add(mesh.faces.astype("<i4")),
        "times": [float(time) for time in times],
        "active": active or min((item["name"] for item in arrays), key=answer_rank, default=""),
        "arrays": arrays,
        "curves": [
            _curves(name, cloud, store, placed) for name, (cloud, *_) in layers.items() if cloud.lines is not None
        ],
        "points": [_points(name, steps, store, placed) for name, steps in layers.items() if steps[0].lines is None],
        "maps": {name: _base64(color_table(name)[:, :3].tobytes()) for name in MAPS},
    }
    folder = files("geomhw.render") / "viewer"
    parts = {
        "title": html.escape(title),
        "scene": json.dumps(scene, allow_nan=False).replace("<", "\\u003c"),
        "buffers": "\n".join(store.elements),
        "script": "\n".join((folder / name).read_text(encoding="utf-8") for name in SCRIPTS),
    }
    text = (folder / "page.html").read_text(encoding="utf-8")
    pieces = text.split("@")
    return "".join(parts.get(piece, piece) if k % 2 else piece for k, piece in enumerate(pieces))


class _Store:
    """Script elements that hold the bytes of arrays."""

    def __init__(self) -> None:
        self.elements: list[str] = []

    def add(self, values: NDArray[Any]) -> dict[str, str]:
        """Add an array; return its element and its type."""
        name = f"buffer-{len(self.elements)}"
        text = _base64(zlib.compress(np.ascontiguousarray(values).tobytes(), 6))
        self.elements.append(f'<script type="application/octet-stream" id="{name}">{text}</script>')
        return {"id": name, "type": values.dtype.str[1:]}


def _mesh_of(frames: Sequence[Result], times: Sequence[float]) -> TriangleMesh:
    """The mesh that all frames share."""
    if not frames or len(frames) != len(times):
        raise FieldError(f"a page needs frames with a time each; there are {len(frames)} frames and {len(times)} times")
    mesh = frames[0].mesh
    for k, frame in enumerate(frames):
        if not np.array_equal(frame.mesh.faces, mesh.faces) or not np.array_equal(frame.mesh.vertices, mesh.vertices):
            raise FieldError(f"frame {k} has another mesh than the first frame; a page shows one mesh")
    return mesh


def _arrays(frames: Sequence[Result], store: _Store, placed: Any) -> list[dict[str, Any]]:
    """Descriptions of the arrays per vertex and face that all frames have."""
    first, mesh = frames[0], frames[0].mesh
    samples: dict[str, tuple[Ints, Floats]] = {}
    described = []
    for item in first.fields:
        if item.location == "mesh" or np.ndim(item.values) > 2:
            continue
        values = [field.values for frame in frames for field in frame.fields if field.name == item.name]
        if len(values) < len(frames) or len({np.shape(array) for array in values}) > 1:
            continue
        constant = all(np.array_equal(array, values[0], equal_nan=True) for array in values[1:])
        stack = np.stack(values[:1] if constant else values)
        components = stack.shape[2] if stack.ndim == 3 else 1
        is_rgb = components == 3 and (stack.dtype == np.uint8 or item.name == "color")
        stored, scale = _single(stack)
        entry = {
            "name": item.name,
            "location": item.location,
            "components": components,
            "frames": len(stack),
            "scale": scale,
            "rgb": is_rgb,
            "kind": (kind := _kind(stack, components)),
            "map": MAPS[kind == "diverging"],
            "data": store.add(stored),
        }
        if components == 3 and not is_rgb:
            if item.location not in samples:
                samples[item.location] = _arrow_places(mesh, item.location)
            rows, places = samples[item.location]
            longest = float(np.nanmax(np.linalg.norm(stored[:, rows].astype(float), axis=2), initial=0.0)) or 1.0
            length = LONGEST_ARROW / longest
            entry["arrows"] = {"rows": rows.tolist(), "places": placed(places).ravel().tolist(), "length": length}
        described.append(entry)
    return described


def _single(values: NDArray[Any]) -> tuple[NDArray[Any], float]:
    """Values as the page stores them, and what they are multiplied by to give the values."""
    if values.dtype.kind in "iub":
        if values.dtype == np.uint8:
            return values, 1.0
        if -(2**31) <= values.min(initial=0) <= values.max(initial=0) < 2**31:
            return values.astype("<i4"), 1.0
        values = values.astype(float)
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    scale = 2.0 ** float(np.clip(np.frexp(largest)[1], -1000, 1000)) if largest else 1.0
    return (values / scale).astype("<f4"), scale


def _kind(values: NDArray[Any], components: int) -> str:
    """Whether numbers have both signs, to a tenth of the larger side."""
    if components > 1 or values.dtype.kind not in "fi":
        return "sequential"
    known = values[np.isfinite(values)]
    low, high = float(known.min(initial=0)), float(known.max(initial=0))
    return "diverging" if min(-low, high) > 0.1 * max(-low, high) else "sequential"


def _arrow_places(mesh: TriangleMesh, location: str) -> tuple[Ints, Floats]:
    """Rows of an array that have an arrow, spread evenly over the surface, and where the arrows start."""
    faces, weights = spread_samples(mesh, ARROWS)
    if location == "face":
        rows = np.unique(faces)
        return rows, mesh.face_centers[rows]
    rows = np.unique(mesh.faces[faces, weights.argmax(axis=1)])
    return rows, mesh.vertices[rows]


def _curves(name: str, cloud: Cloud, store: _Store, placed: Any) -> dict[str, Any]:
    """Description of polylines: both ends of each segment."""
    return {"name": name, "data": store.add(placed(cloud.segments.reshape(-1, 3)).astype("<f4"))}


def _points(name: str, steps: Sequence[Cloud], store: _Store, placed: Any) -> dict[str, Any]:
    """Description of points that stay, or of as many points in each frame."""
    positions = np.stack([cloud.points for cloud in steps])
    size = 12 if positions.shape[1] < 50 else 5
    return {"name": name, "frames": len(steps), "size": size, "data": store.add(placed(positions).astype("<f4"))}


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
