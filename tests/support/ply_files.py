"""PLY files of one surface as text and as binary, with properties in unusual order."""

import struct
from pathlib import Path

from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5), (0, 2, 0)]
SQUARE = TriangleMesh(POINTS, [[0, 1, 2], [0, 2, 3], [0, 3, 4]])
FACES = [(0, 1, 2), (0, 2, 3, 4)]

HEADER = """ply
format {form} 1.0
comment made by hand
obj_info nothing
element material 1
property list uchar float shine
element face 2
property float area
property list uchar int vertex_indices
property uchar flag
element vertex 5
property float z
property double x
property short y
property float vel_x
property float vel_y
property float vel_z
element edge 1
property int vertex1
property int vertex2
end_header
"""


def ascii_body() -> bytes:
    rows = ["2 0.5 0.25", *(f"0.5 {len(f)} {' '.join(map(str, f))} {7 + i}" for i, f in enumerate(FACES))]
    rows += [f"{z} {x} {y} {i} 1 2" for i, (x, y, z) in enumerate(POINTS)]
    return "\n".join([*rows, "0 1", ""]).encode()


def binary_body(order: str) -> bytes:
    body = struct.pack(order + "Bff", 2, 0.5, 0.25)
    for i, f in enumerate(FACES):
        body += struct.pack(f"{order}fB{len(f)}iB", 0.5, len(f), *f, 7 + i)
    for i, (x, y, z) in enumerate(POINTS):
        body += struct.pack(order + "fdhfff", z, x, y, i, 1, 2)
    return body + struct.pack(order + "ii", 0, 1)


BODIES = {
    "ascii": ascii_body(),
    "binary_little_endian": binary_body("<"),
    "binary_big_endian": binary_body(">"),
}


def load(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "moo.ply"
    path.write_bytes(data)
    return path


def result_with(*fields: Field) -> Result:
    return Result(SQUARE, fields)
