"""Formats that meshio reads for this package: file order, arrays, no output of its own."""

import meshio
import numpy as np
import pytest

from geomhw.errors import FormatError
from geomhw.io import read, read_mesh
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.meshio_worker import surface
from support.stl_files import POINTS


def test_modules_of_the_users_folder_are_none_of_ours(tmp_path, monkeypatch):
    """A file in the user's folder with the name of a module is not run."""
    monkeypatch.chdir(tmp_path)
    for name in ("meshio", "numpy", "json", "geomhw"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('taken')")
    meshio.Mesh(POINTS, [("triangle", [[0, 1, 2]])]).write("moo.mesh")
    assert read_mesh("moo.mesh").n_faces == 1


@pytest.mark.parametrize("extension", [".msh", ".inp", ".bdf", ".vol"])
def test_through_meshio_in_file_order(tmp_path, capfd, extension):
    """Faces keep the order of the file, and other cells are reported as ignored."""
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


GRID = [(1, 0, 0), (2, 1, 0), (3, 1, 1), (4, 0, 1)]


def test_faces_of_second_order(tmp_path):
    """Faces with nodes on their sides are divided at the nodes; each piece has the values of its face."""
    path = tmp_path / "moo.msh"
    points = np.array(
        [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 0, 1], [2, 1, 0], [1, 1, 0], [0, 1, 0], [1, 2, 0]]
    )
    cells = [("triangle6", [[0, 1, 2, 4, 5, 6]]), ("triangle", [[0, 2, 3]])]
    meshio.Mesh(points, cells, cell_data={key: [[7], [8]] for key in ("gmsh:physical", "gmsh:geometrical")}).write(
        path, file_format="gmsh22"
    )
    result = read(path)
    assert result.mesh.faces.tolist() == [[0, 4, 6], [4, 1, 5], [6, 5, 2], [4, 5, 6], [0, 2, 3]]
    assert result["gmsh:physical"].tolist() == [7, 7, 7, 7, 8]
    assert "1 face of second order" in result.report["remarks"][0]


@pytest.mark.parametrize(("kind", "nodes"), [("triangle6", 6), ("quad8", 8), ("quad9", 9)])
def test_pieces_of_second_order(kind, nodes):
    """Pieces cover the face once, with its orientation, and use all nodes."""
    corners = np.array([[0, 0], [2, 0], [2, 2], [0, 2]][: 3 if nodes < 8 else 4], float)
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    points = np.concatenate([corners, middles, corners.mean(axis=0, keepdims=True)])[:nodes]
    result = build_result("moo", "a", surface("moo", meshio.Mesh(points, [(kind, [range(nodes)])])))
    assert (result.mesh.area_vectors[:, 2] > 0).all()
    assert result.mesh.face_areas.sum() == pytest.approx(2 if nodes < 8 else 4)
    assert set(result.mesh.faces.ravel().tolist()) == set(range(nodes))


@pytest.mark.parametrize(
    ("kind", "property", "remarks"),
    [
        ("CTRIA3", "", ["left out the array nastran:ref, which not all cells have"]),
        ("CTRIA6", "5", []),
    ],
)
def test_blanks_in_nastran(tmp_path, kind, property, remarks):
    """The property of a face, and the nodes on the sides of faces of second order, may be left blank."""
    path = tmp_path / "moo.nas"
    faces = [(kind, 1, property, 1, 2, 3), ("CQUAD4", 2, "5", 1, 2, 3, 4)]
    cards = [*(("GRID", i, "", f"{x}.", f"{y}.", "0.") for i, x, y in GRID), *faces]
    lines = ["BEGIN BULK", *("".join(f"{field:<8}" for field in card) for card in cards), "ENDDATA", ""]
    path.write_text("\n".join(lines))
    result = read(path)
    assert result.mesh.n_faces == 3
    assert result.report.get("remarks", []) == remarks


def test_some_nodes_on_the_sides_are_blank():
    """A face of second order that lacks one of its nodes is refused."""
    with pytest.raises(FormatError, match="moo holds faces of kind triangle6 with 5 nodes"):
        surface("moo", meshio.Mesh(np.eye(5, 3), [("triangle6", [range(5)])]))


@pytest.mark.parametrize(("start", "version"), [("$NOD\n1\n1 0 0 0\n$ENDNOD\n", "1"), ("$MeshFormat\n3 0 8\n", "3")])
def test_versions_of_gmsh_are_named(tmp_path, start, version):
    """Versions of the format that are not read are named."""
    path = tmp_path / "moo.msh"
    path.write_text(start)
    with pytest.raises(FormatError, match=f"version {version} of the format"):
        read(path)


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
    """Arrays are read; quads are split, and their values repeated."""
    (tmp_path / "moo.msh").write_text(GMSH)
    result = read(tmp_path / "moo.msh")
    assert result.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    assert result["heat"].tolist() == [0, 1, 2, 3]
    assert result.report == {"file": "moo.msh", "format": "Gmsh", "polygons": 1, "ignored": ["vertex"]}


def test_arrays_of_faces_through_meshio():
    """Blocks of faces are joined; an array without numbers for some block is dropped."""
    cells = [("vertex", [[0]]), ("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 1, 2]])]
    arrays = {"label": [[9.0], [1.0], [2.0]], "part": [[9.0], [3.0], ["none"]]}
    result = build_result("moo.msh", "Gmsh", surface("moo.msh", meshio.Mesh(POINTS, cells, cell_data=arrays)))
    assert [(field.name, field.location, field.values.tolist()) for field in result.fields] == [
        ("label", "face", [1, 1, 2])
    ]


def test_flat_points_get_a_z(tmp_path):
    """Points with two coordinates get z = 0."""
    meshio.Mesh(POINTS[:, :2], [("triangle", [[0, 1, 2]])]).write(tmp_path / "moo.mesh")
    np.testing.assert_array_equal(read_mesh(tmp_path / "moo.mesh").vertices, POINTS * [1, 1, 0])


def test_reading_says_nothing(tmp_path, capfd):
    """Reading prints nothing, on success and on failure."""
    (tmp_path / "moo.off").write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    with pytest.raises(FormatError):
        read(tmp_path / "none.off")
    read(tmp_path / "moo.off")
    assert capfd.readouterr() == ("", "")
