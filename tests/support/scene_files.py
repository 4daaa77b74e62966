"""Scenes of glTF and 3MF: two squares at different places, made by trimesh or by hand."""

import base64
import io
import json
import zipfile
from itertools import pairwise

import numpy as np

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]], "<f4")
FACES = np.array([[0, 1, 2], [0, 2, 3]])
ORDERS = {4: [0, 1, 2, 0, 2, 3], 5: [1, 2, 0, 3], 6: [0, 1, 2, 3]}


def of_trimesh(kind: str) -> bytes:
    """The square and a copy of it moved by 5 along x, by trimesh, which needs lxml and networkx for 3MF."""
    import trimesh

    scene = trimesh.Scene()
    for k, name in enumerate(("near", "far")):
        mesh = trimesh.Trimesh(POINTS.astype(float), FACES, process=False)
        scene.add_geometry(
            mesh, node_name=name, geom_name=name, transform=trimesh.transformations.translation_matrix([5 * k, 0, 0])
        )
    return scene.export(file_type=kind)


def gltf(mode: int = 4, **changes: object) -> bytes:
    """A scene with one square, mirrored in x and moved, and a line, with its data in the text."""
    order = np.array(ORDERS[mode], "<u2")
    colors = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [0, 0, 0, 0]], "u1")
    heat = np.array([1.5, 2, -1, 0.25], "<f4")
    blob = POINTS.tobytes() + colors.tobytes() + heat.tobytes() + order.tobytes()
    ends = np.cumsum([0, 48, 16, 16, order.nbytes]).tolist()
    views = [{"buffer": 0, "byteOffset": a, "byteLength": b - a} for a, b in pairwise(ends)]
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [-1, 1, 1]}, {"mesh": 0, "translation": [2, 0, 0], "name": "square"}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "COLOR_0": 1, "_HEAT": 2}, "indices": 3, "mode": mode},
                    {"attributes": {"POSITION": 0}, "mode": 1},
                ]
            }
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": True},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5123, "count": len(order), "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [
            {"byteLength": len(blob), "uri": f"data:application/octet-stream;base64,{base64.b64encode(blob).decode()}"}
        ],
    }
    return json.dumps(tree | changes).encode()


CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
MAIN = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
TWO_PLACES = (
    '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>',
    '<component objectid="1"/><component objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 3"/>',
)


def model(resources: str, build: str = "", head: str = "") -> str:
    """A file of a 3MF model."""
    head = f'<?xml version="1.0"?>{head}<model unit="inch" xmlns="{CORE}" xmlns:p="{PRODUCTION}">'
    return f"{head}<resources>{resources}</resources><build>{build}</build></model>"


def square_object() -> str:
    """The square as object 1 of a 3MF model."""
    vertices = "".join('<vertex x="{}" y="{}" z="{}"/>'.format(*point) for point in POINTS.tolist())
    triangles = "".join('<triangle v1="{}" v2="{}" v3="{}"/>'.format(*face) for face in FACES.tolist())
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    return f'<object id="1" name="square">{mesh}</object>'


def archive(files: dict[str, str]) -> bytes:
    """The bytes of a ZIP archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, text in files.items():
            packed.writestr(zipfile.ZipInfo(name), text)
    return stream.getvalue()


def threemf(item: str = TWO_PLACES[0], head: str = "") -> bytes:
    """An archive with an object of two copies of the square."""
    resources = f'{square_object()}<object id="2"><components>{TWO_PLACES[1]}</components></object>'
    return archive({"3D/3dmodel.model": model(resources, item, head)})
