"""VTK files: written files read back exactly, here and in VTK; files that VTK writes are read."""

import base64
import re
import subprocess
import sys

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from geomhw.errors import FormatError
from geomhw.io import read, write
from geomhw.results import Field, Result
from support.vtk_files import BY_HAND, MESH, RESULT, as_vtk

ALL = ["vtk", "vtp", "vtu"]


def assert_same(result: Result, expected: Result = RESULT) -> None:
    assert result.mesh.vertices.tobytes() == expected.mesh.vertices.tobytes()
    np.testing.assert_array_equal(result.mesh.faces, expected.mesh.faces)
    places = {(field.name, field.location): field.values for field in result.fields}
    assert places.keys() == {(field.name, field.location) for field in expected.fields}
    for field in expected.fields:
        values = places[field.name, field.location]
        assert values.dtype == field.values.dtype
        assert values.shape == field.values.shape
        assert values.tobytes() == field.values.tobytes()


@pytest.mark.parametrize("extension", ALL)
def test_written_comes_back_to_the_bit(tmp_path, extension):
    """Mesh and fields read back to the last bit."""
    path = tmp_path / f"moo.{extension}"
    write(RESULT, path)
    assert_same(read(path))
    assert read(path).report == {"file": path.name, "format": extension.upper()}


@pytest.mark.parametrize("extension", ALL)
def test_vtk_reads_what_is_written(tmp_path, extension):
    """VTK reads the same mesh and fields, with their types."""
    path = tmp_path / f"moo.{extension}"
    write(RESULT, path)
    opened = pyvista.read(path)
    assert isinstance(opened, pyvista.PolyData if extension == "vtp" else pyvista.UnstructuredGrid)
    assert opened.points.dtype == np.float64
    np.testing.assert_array_equal(opened.points, MESH.vertices)
    cells = opened.faces if extension == "vtp" else opened.cells
    np.testing.assert_array_equal(cells.reshape(-1, 4)[:, 1:], MESH.faces)
    places = {"vertex": opened.point_data, "face": opened.cell_data, "mesh": opened.field_data}
    for field in RESULT.fields:
        values = places[field.location][field.name]
        np.testing.assert_array_equal(values, field.values)
        assert values.dtype == field.values.dtype


@pytest.mark.parametrize("extension", ["vtk", "vtu"])
def test_meshio_reads_grids(tmp_path, extension):
    """meshio reads the same mesh and fields; its legacy reader has no type for integers of 64 bits."""
    import meshio

    fields = [field for field in RESULT.fields if extension == "vtu" or field.values.dtype != np.int64]
    write(Result(MESH, fields), tmp_path / f"moo.{extension}")
    opened = meshio.read(tmp_path / f"moo.{extension}")
    np.testing.assert_array_equal(opened.points, MESH.vertices)
    np.testing.assert_array_equal(opened.cells_dict["triangle"], MESH.faces)
    for field in fields:
        if field.location != "mesh":
            values = opened.point_data[field.name] if field.location == "vertex" else opened.cell_data[field.name][0]
            np.testing.assert_array_equal(values.reshape(field.values.shape), field.values)


def test_legacy_header_is_the_old_one(tmp_path):
    """The legacy header is that of version 3.0, with an unstructured grid, which meshio reads."""
    write(RESULT, tmp_path / "moo.vtk")
    head = b"# vtk DataFile Version 3.0\ngeomhw\nBINARY\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\ndt 1 2 double\n"
    assert (tmp_path / "moo.vtk").read_bytes().startswith(head)


@pytest.mark.parametrize("extension", ALL)
@pytest.mark.parametrize("name", ["two words", 'a<b> & "c"', "50 %", "größe", "x=y'z"])
def test_names_survive(tmp_path, extension, name):
    """Names with spaces, markup and accents are kept."""
    path = tmp_path / f"moo.{extension}"
    names = [name, f"{name}, again"]
    fields = [Field(names[0], "vertex", np.ones(4)), Field(names[1], "vertex", np.ones(4))]
    write(Result(MESH, [*fields, Field(name, "face", np.ones((4, 3)))]), path)
    assert [field.name for field in read(path).fields] == [*names, name]
    assert pyvista.read(path).point_data.keys() == names


@pytest.mark.parametrize("extension", ALL)
def test_a_control_character_in_a_name_breaks_no_file(tmp_path, extension):
    """A control character in a name gives a valid file."""
    path = tmp_path / f"moo.{extension}"
    write(Result(MESH, [Field("a\x01\nb", "vertex", np.ones(4))]), path)
    assert len(read(path).fields) == 1
    assert len(pyvista.read(path).point_data) == 1


@pytest.mark.parametrize("extension", ALL)
def test_bool_half_and_scalar_values(tmp_path, extension):
    """Booleans, half precision, scalars and more than two dimensions are written and read."""
    path = tmp_path / f"moo.{extension}"
    fields = [
        Field("b", "vertex", np.array([True, False, True, True])),
        Field("h", "vertex", np.ones(4, np.float16)),
        Field("t", "mesh", np.array(0.5)),
        Field("frames", "vertex", np.ones((4, 2, 3))),
    ]
    write(Result(MESH, fields), path)
    again = read(path)
    assert again["b"].tolist() == [1, 0, 1, 1]
    assert again["t"].tolist() == [0.5]
    assert again["frames"].shape == (4, 6)


@pytest.mark.parametrize("extension", ["vtp", "vtu"])
@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended", "AppendedRaw"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
@pytest.mark.parametrize("order", ["LittleEndian", "BigEndian"])
@pytest.mark.parametrize("header", ["UInt32", "UInt64"])
def test_xml_that_vtk_writes(tmp_path, extension, mode, compressor, order, header):
    """XML files of VTK in every mode, compression and byte order are read to the last bit."""
    path = tmp_path / f"moo.{extension}"
    writer = vtkXMLPolyDataWriter() if extension == "vtp" else vtkXMLUnstructuredGridWriter()
    writer.SetInputData(as_vtk(extension))
    writer.SetFileName(str(path))
    getattr(writer, f"SetDataModeTo{mode.removesuffix('Raw')}")()
    writer.SetEncodeAppendedData(not mode.endswith("Raw"))
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetByteOrderTo{order}")()
    getattr(writer, f"SetHeaderTypeTo{header}")()
    assert writer.Write()
    assert_same(read(path))


def test_base64_with_a_head_of_its_own(tmp_path):
    """Base64 data with a separate header is read."""
    path = tmp_path / "moo.vtp"
    write(RESULT, path)

    def apart(match: re.Match[str]) -> str:
        data = base64.b64decode(match[1])
        return f">{base64.b64encode(data[:8]).decode()}{base64.b64encode(data[8:]).decode()}</DataArray>"

    path.write_text(re.sub(r">([^<>]+)</DataArray>", apart, path.read_text()))
    assert_same(read(path))


@pytest.mark.parametrize("writer_type", [vtkPolyDataWriter, vtkUnstructuredGridWriter])
@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("mode", ["ASCII", "Binary"])
def test_legacy_that_vtk_writes(tmp_path, writer_type, version, mode):
    """Legacy files of VTK in both versions and modes are read."""
    path = tmp_path / "moo.vtk"
    writer = writer_type()
    writer.SetInputData(as_vtk("vtp" if writer_type is vtkPolyDataWriter else "vtu"))
    writer.SetFileName(str(path))
    writer.SetFileVersion(version)
    getattr(writer, f"SetFileTypeTo{mode}")()
    assert writer.Write()
    again = read(path)
    if mode == "Binary":
        assert_same(again)
    # VTK's text has eleven digits.
    np.testing.assert_array_equal(again.mesh.faces, MESH.faces)
    for field in RESULT.fields:
        np.testing.assert_allclose(again[field.name], field.values, rtol=1e-9)


@pytest.mark.parametrize("extension", ALL)
def test_cells_of_several_kinds_in_file_order(tmp_path, extension):
    """Cells of several kinds keep the order of the file; lines and vertices are ignored."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 2, 0.0]])
    mixed = pyvista.PolyData(points, faces=[3, 0, 1, 2, 4, 0, 2, 3, 4], lines=[2, 0, 1], verts=[1, 3])
    mixed.cell_data["c"] = np.arange(4)
    path = tmp_path / f"moo.{extension}"
    (mixed.cast_to_unstructured_grid() if extension == "vtu" else mixed).save(path)
    result = read(path)
    assert result.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]
    assert result["c"].tolist() == [2, 3, 3]
    assert result.report["polygons"] == 1
    assert result.report["ignored"] == ["line", "vertex"]


def test_legacy_attributes_by_hand(tmp_path):
    """Legacy attributes of several kinds are read."""
    path = tmp_path / "moo.vtk"
    path.write_text(BY_HAND)
    result = read(path)
    assert [(f.name, f.location, f.values.shape) for f in result.fields] == [
        ("heat", "vertex", (4,)),
        ("n", "vertex", (4, 3)),
        ("rgb", "face", (4, 3)),
        ("uv", "face", (4, 2)),
    ]
    assert result["heat"].tolist() == [1, 2, 3, 4]


def test_an_array_named_as_a_section_is(tmp_path):
    """An array named METADATA is read."""
    made = Result(MESH, [Field("METADATA", place, np.ones(4)) for place in ("mesh", "vertex", "face")])
    made = Result(MESH, [Field("first", "vertex", np.ones(4)), *made.fields])
    write(made, tmp_path / "moo.vtk")
    assert_same(read(tmp_path / "moo.vtk"), made)


def test_legacy_metadata_are_passed_over(tmp_path):
    """Legacy metadata is skipped."""
    path = tmp_path / "moo.vtk"
    metadata = "METADATA\nCOMPONENT_NAMES\nX\nY\nZ\nINFORMATION 0\n\n"
    field = f"FIELD FieldData 2\na 1 2 int\n1 2\n{metadata}b 1 1 int\n3\n{metadata}"
    path.write_text(BY_HAND.replace("POINTS", field + "POINTS").replace("POLYGONS", metadata + "POLYGONS"))
    result = read(path)
    assert (result["a"].tolist(), result["b"].tolist()) == ([1, 2], [3])
    np.testing.assert_array_equal(result.mesh.faces, MESH.faces)


@pytest.mark.parametrize("extension", [*ALL, "ply"])
def test_answers_are_active(tmp_path, extension):
    """Viewers show the answer of a command first, and every array comes back."""
    path = tmp_path / f"moo.{extension}"
    fields = [Field("heat", "vertex", np.zeros(4)), Field("distance", "vertex", np.arange(4.0))]
    fields += [Field("heat_gradient", "face", np.zeros((4, 3))), Field("direction", "face", np.ones((4, 3)))]
    write(Result(MESH, fields), path)
    opened = pyvista.read(path)
    if extension == "ply":
        assert b"property double quality" in path.read_bytes()
    else:
        assert opened.point_data.active_scalars_name == "distance"
        assert opened.cell_data.active_vectors_name == "direction"
    assert {field.name for field in read(path).fields} == {field.name for field in fields}
    colors = [Field("vorticity", "vertex", np.zeros(4)), Field("color", "vertex", np.ones((4, 3)))]
    write(Result(MESH, [*colors, Field("velocity", "face", np.ones((4, 3)))]), path)
    if extension != "ply":
        assert pyvista.read(path).point_data.active_scalars_name == "color"
        assert pyvista.read(path).cell_data.active_vectors_name == "velocity"
    np.testing.assert_array_equal(read(path)["color"], np.ones((4, 3)))


#: Readers of our files, as the table of examples/reference/files.md lists them: arrays per vertex and per face.
READERS = {
    ("pyvista", "vtk"): "vertex face",
    ("pyvista", "vtp"): "vertex face",
    ("pyvista", "vtu"): "vertex face",
    ("pyvista", "ply"): "",
    ("meshio", "vtk"): "vertex face",
    ("meshio", "vtp"): None,
    ("meshio", "vtu"): "vertex face",
    ("meshio", "ply"): None,
}


@pytest.mark.parametrize(("program", "extension"), READERS)
def test_who_reads_what(tmp_path, program, extension):
    """Each reader of the table finds the arrays that the table promises, and no more."""
    path = tmp_path / f"moo.{extension}"
    write(Result(MESH, [Field("u", "vertex", np.ones(4)), Field("v", "face", np.ones((4, 3)))]), path)
    expected = READERS[program, extension]
    if program == "pyvista":
        opened = pyvista.read(path)
        found = [*("vertex" for name in opened.point_data if name == "u")]
        found += [*("face" for name in opened.cell_data if name == "v")]
    else:
        found_arrays = "*['vertex'] * ('u' in m.point_data), *['face'] * ('v' in m.cell_data)"
        code = f"import meshio; m = meshio.read({str(path)!r}); print({found_arrays})"
        answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        found = answer.stdout.split() if answer.returncode == 0 else None
    assert found == (expected if expected is None else expected.split())


@pytest.mark.parametrize("count", ["3", "5", "999999999999"])
def test_a_piece_has_the_points_that_it_announces(tmp_path, count):
    """Coordinates of another number than the piece announces are refused."""
    path = tmp_path / "moo.vtp"
    write(Result(MESH), path)
    path.write_bytes(path.read_bytes().replace(b'NumberOfPoints="4"', f'NumberOfPoints="{count}"'.encode()))
    with pytest.raises(FormatError, match=rf"{count} points, but coordinates of 4|4 rows where the file has {count}"):
        read(path)


@pytest.mark.parametrize(("kind", "nodes"), [(22, 6), (34, 7), (23, 8), (28, 9)])
@pytest.mark.parametrize("extension", ["vtk", "vtu"])
def test_faces_of_second_order(tmp_path, kind, nodes, extension):
    """Faces with nodes on their sides are divided at the nodes, between others; cell arrays follow."""
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]][: 3 if nodes < 8 else 4], float)
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    points = np.concatenate([corners, middles, corners.mean(axis=0, keepdims=True)])[:nodes]
    cells = [3, 0, 1, 2, nodes, *range(nodes), 3, 2, 1, 0]
    grid = pyvista.UnstructuredGrid(cells, [5, kind, 5], np.concatenate([points, [[0, 0, 9]]]))
    grid.cell_data["k"] = [1, 2, 3]
    path = tmp_path / f"moo.{extension}"
    grid.save(path)
    result = read(path)
    pieces = result.mesh.face_areas[result["k"] == 2]
    assert pieces.sum() == pytest.approx(2 if nodes < 8 else 4)
    assert result["k"].tolist() == [1, *[2] * len(pieces), 3]
    assert set(result.mesh.faces[1:-1].ravel().tolist()) == set(range(nodes))
    assert (result.mesh.area_vectors[1:-1, 2] > 0).all()


def test_nodes_of_second_order_are_counted(tmp_path):
    """A face of second order with another number of nodes is refused."""
    path = tmp_path / "moo.vtk"
    grid = pyvista.UnstructuredGrid([6, *range(6)], [22], np.eye(6, 3))
    grid.save(path, binary=False)
    text = path.read_text()
    path.write_text(text.replace("CELL_TYPES 1\n22", "CELL_TYPES 1\n23"))
    with pytest.raises(FormatError, match="cell 0 has 6 nodes"):
        read(path)


@pytest.mark.parametrize("axes", [(4, 3, 1), (4, 1, 3), (1, 4, 3)])
@pytest.mark.parametrize("kind", ["points", "rectilinear", "curvilinear"])
@pytest.mark.parametrize("binary", [True, False])
def test_structured_grids_of_a_surface(tmp_path, axes, kind, binary):
    """A structured grid with one point along one axis is a surface of quads, as in VTK."""
    grid = pyvista.ImageData(dimensions=axes, origin=(1, 2, 3), spacing=(1, 0.5, 2))
    if kind == "rectilinear":
        grid = grid.cast_to_rectilinear_grid()
        grid.x = np.asarray(grid.x) ** 2
    elif kind == "curvilinear":
        grid = grid.cast_to_structured_grid()
        grid.points += np.sin(grid.points[:, [1, 2, 0]])
    grid["height"] = np.arange(12.0)
    grid.cell_data["k"] = np.arange(6)
    path = tmp_path / "moo.vtk"
    grid.save(path, binary=binary)
    result = read(path)
    np.testing.assert_allclose(result.mesh.vertices, grid.points, rtol=1e-6)
    quads = [grid.get_cell(i).point_ids for i in range(6)]
    quads = [ids if kind == "curvilinear" else [ids[0], ids[1], ids[3], ids[2]] for ids in quads]
    for k, quad in enumerate(quads):
        assert set(result.mesh.faces[result["k"] == k].ravel().tolist()) == set(quad)
    assert result["height"].tolist() == list(range(12))
    assert len(result.mesh.faces) == 12
    edges = np.concatenate([result.mesh.faces[:, [0, 1]], result.mesh.faces[:, [1, 2]], result.mesh.faces[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)  # consistently oriented


@pytest.mark.parametrize(
    ("dimensions", "words"),
    [
        ("3 2 2", "volume cells"),
        ("3 1 1", "no faces"),
        ("3 3 1", "product"),
        ("0 2 2", "damaged"),
        ("3 2", "DIMENSIONS"),
        ("9" * 30 + " 1 1", "damaged"),
    ],
)
def test_structured_grids_that_are_no_surface(tmp_path, dimensions, words):
    """Structured grids of volume cells or lines, and dimensions that do not fit, are refused."""
    path = tmp_path / "moo.vtk"
    count = 12 if dimensions == "3 2 2" else 3
    points = "\n".join(f"{i} {i * i} 0" for i in range(count))
    head = f"# vtk DataFile Version 3.0\nmoo\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS {dimensions}\n"
    path.write_text(f"{head}POINTS {count} float\n{points}\n")
    with pytest.raises(FormatError, match=words):
        read(path)
