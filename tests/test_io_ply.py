"""PLY: every layout gives the same square; what was written comes back; broken files say where they break."""

import struct
from pathlib import Path

import numpy as np
import pytest
import pyvista

from geomhw.errors import FieldError, FormatError
from geomhw.io import read, write
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


@pytest.mark.parametrize("form", BODIES)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_any_layout(tmp_path, form, newline):
    header = HEADER.format(form=form).replace("\n", newline).encode()
    result = read(load(tmp_path, header + BODIES[form]))
    np.testing.assert_array_equal(result.mesh.vertices, SQUARE.vertices)
    np.testing.assert_array_equal(result.mesh.faces, SQUARE.faces)
    notes = {"polygons": 1, "ignored": ["material", "edge"], "single_precision": ["vel", "area"]}
    assert result.report == {"file": "moo.ply", "format": "PLY", **notes}
    assert [(field.name, field.location) for field in result.fields] == [
        ("vel", "vertex"),
        ("area", "face"),
        ("flag", "face"),
    ]
    np.testing.assert_array_equal(result["vel"], [[i, 1, 2] for i in range(5)])
    np.testing.assert_array_equal(result["flag"], [7, 8, 8])  # the quad's value on both of its triangles
    assert result["flag"].dtype == np.uint8


@pytest.mark.parametrize(
    ("rows", "faces"),
    [
        ("4 0 1 2 3 0\n3 0 3 4 2 .1 .2\n3 0 1 2 1 5\n", [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 1, 2]]),
        ("3 0 1 2 0\n3 0 2 3 2 3 5\n3 0 3 4 1 5\n", [[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
    ],
)
def test_lists_of_mixed_length_in_every_row(tmp_path, rows, faces):
    head = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 3\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n"
    body = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS) + rows
    result = read(load(tmp_path, (head + body).encode()))
    assert result.mesh.faces.tolist() == faces
    assert not result.fields


def result_with(*fields: Field) -> Result:
    return Result(SQUARE, fields)


FIELDS = [
    Field("heat", "vertex", np.array([1e-300, 0.1, -0.0, 3.0, np.pi])),
    Field("velocity", "vertex", np.arange(15.0).reshape(5, 3) / 7),
    Field("direction", "face", np.arange(9.0).reshape(3, 3) / 3),
    Field("label", "face", np.array([1, -2, 2**31 - 1], dtype=np.int32)),
    Field("flag", "vertex", np.arange(5, dtype=np.uint8)),
]


def test_written_comes_back_to_the_bit(tmp_path):
    path = tmp_path / "moo.ply"
    write(result_with(*FIELDS), path)
    again = read(path)
    assert again.mesh.vertices.tobytes() == SQUARE.vertices.tobytes()
    np.testing.assert_array_equal(again.mesh.faces, SQUARE.faces)
    by_name = {field.name: field for field in again.fields}
    for field in FIELDS:
        assert by_name[field.name].location == field.location
        assert by_name[field.name].values.tobytes() == field.values.tobytes()
        assert by_name[field.name].values.dtype == field.values.dtype


def test_other_programs_open_it(tmp_path):
    path = tmp_path / "moo.ply"
    write(result_with(*FIELDS), path)
    opened = pyvista.read(path)
    np.testing.assert_allclose(opened.points, SQUARE.vertices)
    np.testing.assert_array_equal(opened.faces.reshape(-1, 4)[:, 1:], SQUARE.faces)


def test_header_of_what_is_written(tmp_path):
    path = tmp_path / "moo.ply"
    pair = Field("a b", "vertex", np.ones((5, 2)))
    big = Field("big", "face", np.array([0, 1, 2**40]))
    small = Field("small", "face", np.array([0, 1, -2]))
    write(result_with(pair, big, small, Field("dt", "mesh", np.array([0.1, 2.0]))), path)
    header = path.read_bytes().split(b"end_header\n")[0].decode()
    assert header.splitlines() == [
        "ply",
        "format binary_little_endian 1.0",
        "comment geomhw",
        "comment dt 0.1 2.0",
        "element vertex 5",
        *(f"property double {name}" for name in ("x", "y", "z", "a_b_0", "a_b_1")),
        "element face 3",
        "property list uchar int vertex_indices",
        "property double big",
        "property int small",
    ]


@pytest.mark.parametrize("names", [("a_b_x", "a b"), ("x", "y"), ("v_z", "v")])
def test_names_that_would_clash_are_refused(tmp_path, names):
    fields = [Field(names[0], "vertex", np.ones(5)), Field(names[1], "vertex", np.ones((5, 3)))]
    with pytest.raises(FieldError, match="in PLY; rename field"):
        write(result_with(*fields), tmp_path / "moo.ply")
    assert not list(tmp_path.iterdir())


def broken(form: str, change: tuple[str, str] = ("", ""), cut: int | None = None, extra: bytes = b"") -> bytes:
    return HEADER.format(form=form).replace(*change).encode() + BODIES.get(form, b"")[:cut] + extra


LITTLE = "binary_little_endian"
WRONG = {
    "no ply": (b"plx\n", ["line 1", "'ply'"]),
    "no end": (b"ply\nformat ascii 1.0\n", ["inside its header"]),
    "format": (broken("utf8"), ["'utf8'", "ascii"]),
    "header line": (broken("ascii", ("property float z", "property float128 z")), ["line 12", "float128"]),
    "count": (broken("ascii", ("vertex 5", "vertex -5")), ["line 11", "element vertex -5"]),
    "no z": (broken(LITTLE, ("float z", "float w")), ["missing: z"]),
    "no faces": (broken(LITTLE, ("vertex_indices", "corners")), ["no faces"]),
    "cut in the faces": (broken(LITTLE, cut=20), ["ends after 0 of 2 rows", "'face'"]),
    "cut before a length": (broken(LITTLE, cut=12), ["ends after 0 of 2 rows", "'face'"]),
    "cut in the vertices": (broken(LITTLE, cut=100), ["ends after 1 of 5 rows", "'vertex'"]),
    "cut text": (broken("ascii", cut=60), ["moo.ply", "ends after 1 of 5 rows", "'vertex'"]),
    "too long": (broken(LITTLE, extra=b"abc"), ["goes on after"]),
    "huge": (broken(LITTLE, ("face 2", "face 999999999999")), ["rows of element 'face'"]),
    "not a number": (broken("ascii").replace(b"0.25", b"zero"), ["line 22", "'zero'"]),
    "not whole": (
        broken("ascii").replace(b"3 0 1 2 7", b"3 0 1 1.5 7"),
        ["'vertex_indices'", "1.5 is not an integer of 4 bytes"],
    ),
    "list length": (broken("ascii").replace(b"3 0 1 2 7", b"-3 0 1 2 7"), ["face 0", "-3 is no length"]),
    "out of range": (broken("ascii").replace(b"3 0 1 2 7", b"3 0 1 9 7"), ["face 0", "vertex 9", "there are 5"]),
    "twice": (broken("ascii").replace(b"3 0 1 2 7", b"3 0 1 1 7"), ["face 0", "vertex 1 twice"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(tmp_path, case):
    data, parts = WRONG[case]
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, data))
    for part in ["moo.ply", *parts]:
        assert part in str(caught.value)
