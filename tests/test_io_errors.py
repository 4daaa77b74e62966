"""Files that cannot be opened, STL, and the formats that are read by meshio, which must not print or exit."""

import os
import struct
import sys
import time

import meshio
import numpy as np
import pytest
import pyvista

from geomhw.errors import FormatError, GeomhwError, MeshError
from geomhw.io import READABLE, read, read_mesh
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.meshio_worker import extract, surface

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])


def message(path) -> str:
    with pytest.raises(GeomhwError) as caught:
        read(path)
    return str(caught.value)


@pytest.mark.parametrize("extension", READABLE)
def test_files_that_cannot_be_opened(tmp_path, extension):
    path = tmp_path / f"moo{extension}"
    assert message(path) == f"{path}: there is no such file"
    path.touch()
    assert message(path) == f"{path} is an empty file"
    path.unlink()
    path.mkdir()
    assert message(path) == f"{path} cannot be read: it is a folder"


def test_extensions(tmp_path):
    assert ".xyz' is not a mesh format that is read; known are .off .obj" in message(tmp_path / "moo.xyz")
    assert "the name has no extension; known are" in message(tmp_path / "moo")
    (tmp_path / "MOO.OFF").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert read_mesh(str(tmp_path / "MOO.OFF")).n_faces == 1


def test_no_permission(tmp_path, monkeypatch):
    def refuse(self, mode):
        raise PermissionError(13, "Permission denied", os.fspath(self))

    monkeypatch.setattr("pathlib.Path.open", refuse)
    assert message(tmp_path / "moo.off").endswith("moo.off cannot be read: permission denied")


@pytest.mark.parametrize("extension", READABLE)
@pytest.mark.parametrize("data", [b"\0\xff\x80" * 50, b"hello world\n1 2 3\n", b"solid\n", b"$MeshFormat\n4.1 0 8\n"])
def test_rubbish_is_one_quiet_sentence(tmp_path, capfd, extension, data):
    path = tmp_path / f"moo{extension}"
    path.write_bytes(data)
    said = message(path)
    assert path.name in said
    assert "\n" not in said
    assert capfd.readouterr() == ("", "")


def test_meshio_that_exits_is_caught(tmp_path, capfd, monkeypatch):
    def leave(*_):
        print("chatter")
        print("chatter", file=sys.stderr)
        sys.exit(1)

    monkeypatch.setattr(meshio, "read", leave)
    with pytest.raises(FormatError, match=r"^moo\.msh cannot be read as Gmsh$"):
        extract(tmp_path / "moo.msh", "Gmsh")
    assert capfd.readouterr() == ("", "")


def test_meshio_that_finds_no_end_is_ended(tmp_path):
    """After BEGIN BULK, meshio's Nastran reader waits for a line for ever, at the end of the file too."""
    (tmp_path / "moo.bdf").write_text("BEGIN BULK\n")
    submit = time.monotonic()
    told = message(tmp_path / "moo.bdf")
    assert time.monotonic() - submit < 30
    assert told.startswith("moo.bdf cannot be read as Nastran: not done after 1 s of computing")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits on memory are Linux's")
def test_meshio_that_asks_for_all_memory_gets_none(tmp_path):
    """A header that promises 2⁴⁰ points."""
    (tmp_path / "moo.mesh").write_text(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{2**40}\n0 0 0 0\n")
    assert message(tmp_path / "moo.mesh").startswith("moo.mesh cannot be read as Medit: ")


def test_modules_of_the_users_folder_are_none_of_ours(tmp_path, monkeypatch):
    """A file there that is named as a module is not run."""
    monkeypatch.chdir(tmp_path)
    for name in ("meshio", "numpy", "json", "geomhw"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('taken')")
    meshio.Mesh(POINTS, [("triangle", [[0, 1, 2]])]).write("moo.mesh")
    assert read_mesh("moo.mesh").n_faces == 1


@pytest.mark.parametrize("extension", [".msh", ".inp", ".bdf", ".vol"])
def test_through_meshio_in_file_order(tmp_path, capfd, extension):
    cells = [("triangle", [[0, 1, 2]]), ("line", [[0, 1]]), ("triangle", [[0, 2, 3], [3, 1, 0]])]
    if extension == ".inp":
        del cells[1]
    path = tmp_path / f"moo{extension}"
    meshio.Mesh(POINTS, cells).write(path, file_format="gmsh22" if extension == ".msh" else None)
    capfd.readouterr()
    result = read(path)
    np.testing.assert_allclose(result.mesh.vertices, POINTS)
    assert result.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [3, 1, 0]]
    assert result.report.get("ignored") == (None if extension == ".inp" else ["line"])
    assert capfd.readouterr() == ("", "")


GMSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 .5
$EndNodes
$Elements
3
1 15 0 1
2 3 0 1 2 3 4
3 2 0 1 2 3
$EndElements
$NodeData
1
"heat"
1
0.0
3
0
1
4
1 0
2 1
3 2
4 3
$EndNodeData
"""


def test_arrays_and_quads_through_meshio(tmp_path):
    (tmp_path / "moo.msh").write_text(GMSH)
    result = read(tmp_path / "moo.msh")
    assert result.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    assert result["heat"].tolist() == [0, 1, 2, 3]
    assert result.report == {"file": "moo.msh", "format": "Gmsh", "polygons": 1, "ignored": ["vertex"]}


def test_arrays_of_faces_through_meshio():
    """Blocks of faces go one after the other; an array without numbers for some block is left out."""
    cells = [("vertex", [[0]]), ("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 1, 2]])]
    arrays = {"label": [[9.0], [1.0], [2.0]], "part": [[9.0], [3.0], ["none"]]}
    result = build_result("moo.msh", "Gmsh", surface("moo.msh", meshio.Mesh(POINTS, cells, cell_data=arrays)))
    assert [(field.name, field.location, field.values.tolist()) for field in result.fields] == [
        ("label", "face", [1, 1, 2])
    ]


def test_flat_points_get_a_z(tmp_path):
    meshio.Mesh(POINTS[:, :2], [("triangle", [[0, 1, 2]])]).write(tmp_path / "moo.mesh")
    np.testing.assert_array_equal(read_mesh(tmp_path / "moo.mesh").vertices, POINTS * [1, 1, 0])


def test_volumes_and_lines_are_refused(tmp_path):
    path = tmp_path / "moo.mesh"
    meshio.Mesh(POINTS, [("tetra", [[0, 1, 2, 3]])]).write(path)
    assert message(path) == "moo.mesh holds volume cells (tetra) and no faces; extract its surface first"
    meshio.Mesh(POINTS, [("line", [[0, 1]])]).write(path)
    assert message(path) == "moo.mesh holds no triangles or polygons, only line"


# -- STL ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("binary", [True, False])
def test_stl_corners_are_welded_in_file_order(tmp_path, binary):
    faces = np.array([[3, 1, 0], [3, 2, 1], [0, 1, 2]])
    path = tmp_path / "moo.stl"
    pyvista.PolyData(POINTS, np.insert(faces, 0, 3, axis=1)).save(path, binary=binary)
    result = read(path)
    assert result.mesh.faces.tolist() == [[0, 1, 2], [0, 3, 1], [2, 1, 3]]
    np.testing.assert_array_equal(result.mesh.vertices, POINTS[[3, 1, 0, 2]])
    single = {"single_precision": ["positions"]} if binary else {}
    assert result.report == {"file": "moo.stl", "format": "STL", **single}


def facets(*triangles) -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), 0) for t in triangles)
    return b"solid but binary".ljust(80) + struct.pack("<I", len(triangles)) + body


def test_stl_zeros_of_both_signs_are_one_corner(tmp_path):
    path = tmp_path / "moo.stl"
    path.write_bytes(facets([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[-0.0, 0, 0], [0, 1, 0], [-1, -0.0, 0]]))
    assert read_mesh(path).faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_stl_errors(tmp_path):
    path = tmp_path / "moo.stl"
    one = facets(POINTS[:3])
    for data, part in {
        b"\x01" * 50: "neither starts with 'solid' nor has a header of 84 bytes",
        one.replace(b"solid", b"SOLUS")[:-10]: "says 1 triangles, but there are bytes for 0.8",
        facets(): "holds no triangles",
        b"solid x\nendsolid\n": "holds no triangles",
        b"solid x\nvertex 0 0 0\nvertex 1 0 0\n": "holds 2 triangle corners",
        b"solid x\nvertex 0 0 0\nvertex 1 zero 0\n": "line 3: 'zero' is not a number",
        facets([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0]]): "vertex 1 has a coordinate that is not a finite number",
        facets(POINTS[[0, 1, 1]]): "face 0: face names vertex 1 twice",
    }.items():
        path.write_bytes(data)
        said = message(path)
        assert "moo.stl" in said
        assert part in said


def test_what_the_mesh_refuses_has_the_file_in_front(tmp_path):
    path = tmp_path / "moo.stl"
    path.write_bytes(facets([[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]]))
    with pytest.raises(MeshError, match=r"^moo\.stl: vertex 1"):
        read(path)


def test_reading_says_nothing(tmp_path, capfd):
    (tmp_path / "moo.off").write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    with pytest.raises(FormatError):
        read(tmp_path / "none.off")
    read(tmp_path / "moo.off")
    assert capfd.readouterr() == ("", "")
