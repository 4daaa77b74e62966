"""PLY files: any layout is read, and written files read back exactly."""

import numpy as np
import pytest
import pyvista

from geomhw.errors import FormatError
from geomhw.io import read, write
from geomhw.results import Field
from support.ply_files import BODIES, HEADER, POINTS, SQUARE, load, result_with


@pytest.mark.parametrize("form", BODIES)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_any_layout(tmp_path, form, newline):
    """Properties in any order, as text and as binary of both byte orders, give the same mesh and fields."""
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
    """Lists of varying length are read in every row."""
    head = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 3\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n"
    body = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS) + rows
    result = read(load(tmp_path, (head + body).encode()))
    assert result.mesh.faces.tolist() == faces
    assert not result.fields


FIELDS = [
    Field("heat", "vertex", np.array([1e-300, 0.1, -0.0, 3.0, np.pi])),
    Field("velocity", "vertex", np.arange(15.0).reshape(5, 3) / 7),
    Field("direction", "face", np.arange(9.0).reshape(3, 3) / 3),
    Field("label", "face", np.array([1, -2, 2**31 - 1], dtype=np.int32)),
    Field("flag", "vertex", np.arange(5, dtype=np.uint8)),
]


def test_written_comes_back_to_the_bit(tmp_path):
    """Mesh and fields read back to the last bit, with their types."""
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
    """pyvista reads the same mesh."""
    path = tmp_path / "moo.ply"
    write(result_with(*FIELDS), path)
    opened = pyvista.read(path)
    np.testing.assert_allclose(opened.points, SQUARE.vertices)
    np.testing.assert_array_equal(opened.faces.reshape(-1, 4)[:, 1:], SQUARE.faces)


def test_header_of_what_is_written(tmp_path):
    """The header has the expected lines."""
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


def test_lines_before_the_elements(tmp_path):
    """Lines of other words before the elements are left out, with a remark; the first word may be in capitals."""
    text = "PLY\nformat ascii 1.0\nCreated by hand\nelement vertex 3\nproperty float x\nproperty float y\n"
    text += "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    text += "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    result = read(load(tmp_path, text.encode()))
    assert result.mesh.n_faces == 1
    assert "line 3" in result.report["remarks"][0]
    with pytest.raises(FormatError, match="line 5"):
        read(load(tmp_path, text.replace("element vertex", "elements vertex").replace("Created", "comment").encode()))
    with pytest.raises(FormatError, match="line 7"):
        read(load(tmp_path, text.replace("property float z", "propertx float z").encode()))
