"""VTK files: what is written comes back, and other programs read the same; what VTK writes is read here."""

import base64
import re

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from geomhw.errors import FieldError, FormatError
from geomhw.io import read, write
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

MESH = TriangleMesh(
    [[0, 0, 0], [1, 0, 0], [1 / 3, 1, 0], [0.1, 0.2, np.pi]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
)
RESULT = Result(
    MESH,
    [
        Field("heat", "vertex", np.array([1e-300, 0.1, -0.0, np.pi])),
        Field("id", "vertex", np.array([0, -1, 2**40, 3])),
        Field("moved", "vertex", np.arange(12.0).reshape(4, 3) / 7),
        Field("uv", "vertex", np.arange(8.0).reshape(4, 2) / 3),
        Field("label", "face", np.array([5, 6, 7, 8], dtype=np.int32)),
        Field("direction", "face", np.arange(12.0).reshape(4, 3) / 11),
        Field("velocity", "face", np.arange(12.0).reshape(4, 3) / 13),
        Field("frame", "face", np.arange(36.0).reshape(4, 9)),
        Field("dt", "mesh", np.array([0.1, 0.2])),
    ],
)
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
    path = tmp_path / f"moo.{extension}"
    write(RESULT, path)
    assert_same(read(path))
    assert read(path).report == {"file": path.name, "format": extension.upper()}


@pytest.mark.parametrize("extension", ALL)
def test_vtk_reads_what_is_written(tmp_path, extension):
    path = tmp_path / f"moo.{extension}"
    write(RESULT, path)
    opened = pyvista.read(path)
    assert isinstance(opened, pyvista.UnstructuredGrid if extension == "vtu" else pyvista.PolyData)
    assert opened.points.dtype == np.float64
    np.testing.assert_array_equal(opened.points, MESH.vertices)
    cells = opened.cells if extension == "vtu" else opened.faces
    np.testing.assert_array_equal(cells.reshape(-1, 4)[:, 1:], MESH.faces)
    places = {"vertex": opened.point_data, "face": opened.cell_data, "mesh": opened.field_data}
    for field in RESULT.fields:
        values = places[field.location][field.name]
        np.testing.assert_array_equal(values, field.values)
        assert values.dtype == field.values.dtype


def test_meshio_reads_the_vtu(tmp_path):
    import meshio

    write(RESULT, tmp_path / "moo.vtu")
    opened = meshio.read(tmp_path / "moo.vtu")
    np.testing.assert_array_equal(opened.points, MESH.vertices)
    np.testing.assert_array_equal(opened.cells_dict["triangle"], MESH.faces)
    for field in RESULT.fields:
        if field.location != "mesh":
            values = opened.point_data[field.name] if field.location == "vertex" else opened.cell_data[field.name][0]
            np.testing.assert_array_equal(values, field.values)


def test_legacy_header_is_the_old_one(tmp_path):
    write(RESULT, tmp_path / "moo.vtk")
    assert (
        (tmp_path / "moo.vtk")
        .read_bytes()
        .startswith(b"# vtk DataFile Version 3.0\ngeomhw\nBINARY\nDATASET POLYDATA\nFIELD FieldData 1\ndt 1 2 double\n")
    )


@pytest.mark.parametrize("extension", ALL)
@pytest.mark.parametrize("name", ["two words", 'a<b> & "c"', "50 %", "größe", "x=y'z"])
def test_names_survive(tmp_path, extension, name):
    path = tmp_path / f"moo.{extension}"
    names = [name, f"{name}, again"]
    fields = [Field(names[0], "vertex", np.ones(4)), Field(names[1], "vertex", np.ones(4))]
    write(Result(MESH, [*fields, Field(name, "face", np.ones((4, 3)))]), path)
    assert [field.name for field in read(path).fields] == [*names, name]
    assert pyvista.read(path).point_data.keys() == names


@pytest.mark.parametrize("extension", ALL)
def test_a_control_character_in_a_name_breaks_no_file(tmp_path, extension):
    path = tmp_path / f"moo.{extension}"
    write(Result(MESH, [Field("a\x01\nb", "vertex", np.ones(4))]), path)
    assert len(read(path).fields) == 1
    assert len(pyvista.read(path).point_data) == 1


@pytest.mark.parametrize("extension", ALL)
def test_bool_half_and_scalar_values(tmp_path, extension):
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


def test_what_is_no_number_is_not_written(tmp_path):
    with pytest.raises(FieldError, match="field 'z' cannot be written: its values are complex128"):
        write(Result(MESH, [Field("z", "vertex", np.ones(4) * 1j)]), tmp_path / "moo.vtp")
    with pytest.raises(FieldError, match="two vertex fields are named 'u'"):
        write(Result(MESH, [Field("u", "vertex", np.ones(4))] * 2), tmp_path / "moo.vtp")
    assert not list(tmp_path.iterdir())


def as_vtk(extension: str) -> pyvista.DataSet:
    poly = pyvista.PolyData(MESH.vertices, np.insert(MESH.faces, 0, 3, axis=1))
    dataset = poly.cast_to_unstructured_grid() if extension == "vtu" else poly
    places = {"vertex": dataset.point_data, "face": dataset.cell_data, "mesh": dataset.field_data}
    for field in RESULT.fields:
        places[field.location][field.name] = field.values
    return dataset


@pytest.mark.parametrize("extension", ["vtp", "vtu"])
@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended", "AppendedRaw"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
@pytest.mark.parametrize("order", ["LittleEndian", "BigEndian"])
@pytest.mark.parametrize("header", ["UInt32", "UInt64"])
def test_xml_that_vtk_writes(tmp_path, extension, mode, compressor, order, header):
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


BY_HAND = """# vtk DataFile Version 2.0
by hand
ASCII
DATASET POLYDATA
POINTS 4 float
0 0 0 1 0 0
0 1 0
0 0 1
POLYGONS 4 16
3 0 2 1 3 0 1 3
3 1 2 3
3 2 0 3
POINT_DATA 4
SCALARS heat double 1
LOOKUP_TABLE mine
1 2 3 4
LOOKUP_TABLE mine 1
0 0 0 1
NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1
CELL_DATA 4
COLOR_SCALARS rgb 3
0 0 1 0 0 1 0 0 1 0 0 1
TEXTURE_COORDINATES uv 2 float
0 0 1 0 0 1 0 0
"""


def test_legacy_attributes_by_hand(tmp_path):
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
    made = Result(MESH, [Field("METADATA", place, np.ones(4)) for place in ("mesh", "vertex", "face")])
    made = Result(MESH, [Field("first", "vertex", np.ones(4)), *made.fields])
    write(made, tmp_path / "moo.vtk")
    assert_same(read(tmp_path / "moo.vtk"), made)


def test_legacy_metadata_are_passed_over(tmp_path):
    path = tmp_path / "moo.vtk"
    metadata = "METADATA\nCOMPONENT_NAMES\nX\nY\nZ\nINFORMATION 0\n\n"
    field = f"FIELD FieldData 2\na 1 2 int\n1 2\n{metadata}b 1 1 int\n3\n{metadata}"
    path.write_text(BY_HAND.replace("POINTS", field + "POINTS").replace("POLYGONS", metadata + "POLYGONS"))
    result = read(path)
    assert (result["a"].tolist(), result["b"].tolist()) == ([1, 2], [3])
    np.testing.assert_array_equal(result.mesh.faces, MESH.faces)


LEGACY_WRONG = {
    "# vtk DataFile": ["does not start as"],
    BY_HAND.replace("POLYDATA", "STRUCTURED_POINTS"): ["STRUCTURED_POINTS"],
    BY_HAND.replace("0 0 1\nPOLY", "0 0 x\nPOLY"): ["line 5", "not a number"],
    BY_HAND.replace("1 2 3 4", "1 2 three 4"): ["line 15", "not a number"],
    BY_HAND[:-10]: ["line 24", "ends inside"],
    BY_HAND[:130]: ["ends inside"],
    BY_HAND.replace("NORMALS", "WEIRDNESS"): ["line 19", "'WEIRDNESS n"],
    BY_HAND.replace("n float", "n string"): ["line 19", "'string'"],
    BY_HAND.replace("POLYGONS 4", "POLYGONS four"): ["line 9", "not understood"],
    BY_HAND.replace("3 2 0 3", "9 2 0 3"): ["moo.vtk"],
    BY_HAND.replace("3 2 0 3", "3 2 0 9"): ["face 3", "vertex 9"],
    BY_HAND.replace("POLYGONS", "TRIANGLE_STRIPS"): ["triangle strip"],
    BY_HAND.replace("POLYGONS", "LINES"): ["no faces, only line"],
    BY_HAND.replace("CELL_DATA 4", "CELL_DATA 3"): ["line 23", "'0 0 1'"],
}


@pytest.mark.parametrize("text", LEGACY_WRONG, ids=range(len(LEGACY_WRONG)))
def test_legacy_errors_are_named(tmp_path, text):
    path = tmp_path / "moo.vtk"
    path.write_text(text)
    with pytest.raises(FormatError) as caught:
        read(path)
    for part in ["moo.vtk", *LEGACY_WRONG[text]]:
        assert part in str(caught.value)


XML_WRONG = {
    "not XML": (lambda text: "hello", "not a whole VTK XML file"),
    "cut": (lambda text: text[:-40], "not a whole VTK XML file"),
    "other kind": (lambda text: text.replace("PolyData", "ImageData"), "holds VTK ImageData, not PolyData"),
    "compressor": (lambda text: text.replace("header_type", 'compressor="vtkLZ4DataCompressor" header_type'), "LZ4"),
    "no base64": (lambda text: text.replace('format="binary">', 'format="binary">A'), "not a whole VTK XML file"),
    "a point missing": (lambda text: re.sub(r".{32}</DataArray>", "</DataArray>", text, count=2), "ends early"),
    "bad type": (lambda text: text.replace('Int32" Name="conn', 'Text" Name="conn'), "not a whole VTK XML file"),
    "no piece": (lambda text: text.replace('Points="4"', 'Points="0"'), "0 pieces with points"),
    "no polys": (lambda text: text.replace("Polys>", "Polls>"), "no cells"),
}


@pytest.mark.parametrize("case", XML_WRONG)
def test_xml_errors_are_named(tmp_path, case):
    path = tmp_path / "moo.vtp"
    write(RESULT, path)
    change, part = XML_WRONG[case]
    before = path.read_text()
    after = change(before)
    assert after != before
    path.write_text(after)
    with pytest.raises(FormatError, match=part) as caught:
        read(path)
    assert "moo.vtp" in str(caught.value)


def test_a_grid_of_tetrahedra_is_refused(tmp_path):
    grid = pyvista.UnstructuredGrid({10: np.array([[0, 1, 2, 3]])}, MESH.vertices)
    grid.save(tmp_path / "moo.vtu")
    with pytest.raises(FormatError, match=r"moo\.vtu holds tetra cells; a surface is made of triangles"):
        read(tmp_path / "moo.vtu")
