"""Scenes: GLB, glTF and 3MF with transforms, groups and arrays; groups and materials of OBJ."""

import base64
import json
from pathlib import Path

import numpy as np
import pytest
import pyvista
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from geomhw.errors import FormatError
from geomhw.io import read, read_csv, read_field, write, writing_remarks
from geomhw.mesh import TriangleMesh
from geomhw.results import Field, Result
from support.scene_files import (
    FACES,
    MAIN,
    POINTS,
    TWO_PLACES,
    archive,
    gltf,
    model,
    square_object,
    threemf,
)

CORPUS = Path(__file__).parents[1] / "fuzz" / "corpus"
FAR = np.array([5, 0, 0])


def field(path: Path, name: str) -> Field:
    return next(item for item in read(path).fields if item.name == name)


@pytest.mark.parametrize("kind", ["glb", "3mf"])
def test_scenes_of_trimesh(kind: str) -> None:
    """Parts are at their places, and their names are groups of faces."""
    path = CORPUS / kind / f"trimesh.{kind}"
    result = read(path)
    assert result.mesh.n_faces == 4
    order = np.lexsort(result.mesh.vertices.T)
    both = np.concatenate([POINTS, POINTS + FAR]).astype(float)
    np.testing.assert_allclose(result.mesh.vertices[order], both[np.lexsort(both.T)], atol=1e-7)
    groups = field(path, "group")
    assert groups.labels is not None
    assert set(groups.labels.values()) == {"near", "far"}
    far = read_field(f"{path}:far", result.mesh)
    assert far.location == "face"
    assert (result.mesh.face_centers[far.values == 1, 0] > 4).all()


@pytest.mark.parametrize("mode", [4, 5, 6])
def test_gltf_modes_transforms_and_arrays(tmp_path: Path, mode: int) -> None:
    """Lists, strips and fans give the same triangles; a mirrored node keeps the orientation; colors are arrays."""
    path = tmp_path / "a.gltf"
    path.write_bytes(gltf(mode))
    result = read(path)
    np.testing.assert_allclose(result.mesh.vertices, POINTS * [-1, 1, 1] - [2, 0, 0])
    assert (result.mesh.area_vectors[:, 2] > 0).all()
    np.testing.assert_array_equal(field(path, "heat").values, [1.5, 2, -1, 0.25])
    np.testing.assert_array_equal(field(path, "color").values[1], [0, 1, 0, 1])
    assert result.report["ignored"] == ["lines"]


def test_seams_are_joined(tmp_path: Path) -> None:
    """Vertices that a scene repeats at one place are one, with a remark."""
    path = tmp_path / "a.gltf"
    path.write_bytes(gltf(nodes=[{"children": [1, 1]}, {"mesh": 0}]))
    result = read(path)
    assert result.mesh.n_vertices == 4
    assert "joined 4 vertices" in result.report["remarks"][0]


def test_3mf_parts(tmp_path: Path) -> None:
    """Components and items multiply their transforms; a mirrored part keeps its orientation; the unit is reported."""
    path = tmp_path / "a.3mf"
    path.write_bytes(threemf())
    result = read(path)
    both = np.concatenate([POINTS + FAR, POINTS * [-1, 1, 1] + np.array([5, 0, 3])])
    np.testing.assert_allclose(result.mesh.vertices, both)
    assert (result.mesh.area_vectors[:, 2] > 0).all()
    assert result.report["unit"] == "inch"
    np.testing.assert_array_equal(field(path, "group").values, [0, 0, 1, 1])


def test_3mf_with_objects_in_other_files(tmp_path: Path) -> None:
    """Components and items name objects of other files of the archive, which relationships call the model."""
    path = tmp_path / "a.3mf"
    parts = TWO_PLACES[1].replace("<component", '<component p:path="/3D/Objects/Part%201.model"')
    main = model(f'<object id="2"><components>{parts}</components></object>', TWO_PLACES[0])
    relation = f"<Relationship Target='/3D/main.xml' Type='{MAIN}' Id='a'/>"
    other = model('<object id="2"/>' + square_object())
    files = {"3D/objects/part 1.model": other, "3D/main.xml": main, "_rels/.rels": relation}
    path.write_bytes(archive(files))
    result = read(path)
    np.testing.assert_allclose(result.mesh.vertices, np.concatenate([POINTS + FAR, POINTS * [-1, 1, 1] + [5, 0, 3]]))
    item = '<item objectid="1" p:path="/3D/objects/part 1.model"/>'
    path.write_bytes(archive({"3D/3dmodel.model": model("", item), "3D/objects/part 1.model": other}))
    np.testing.assert_allclose(read(path).mesh.vertices, POINTS)


def test_3mf_passes_over_extensions(tmp_path: Path) -> None:
    """Elements of extensions with the names of core elements, such as the vertices of slices, are no geometry."""
    path = tmp_path / "a.3mf"
    slices = '<s:slice xmlns:s="slices"><s:vertex x="1" y="2"/></s:slice>'
    path.write_bytes(archive({"3D/3dmodel.model": model(square_object() + slices, '<item objectid="1"/>')}))
    np.testing.assert_allclose(read(path).mesh.vertices, POINTS)


def test_gltf_with_a_buffer_beside_it(tmp_path: Path) -> None:
    """A buffer may be a file named relative to the glTF file, with blanks and letters beyond ASCII escaped."""
    tree = json.loads(gltf())
    buffer = base64.b64decode(tree["buffers"][0]["uri"].partition(",")[2])
    (tmp_path / "data é").mkdir()
    (tmp_path / "data é" / "a.bin").write_bytes(buffer + b"surplus")
    path = tmp_path / "a.gltf"
    path.write_bytes(gltf(buffers=[{"byteLength": len(buffer), "uri": "data%20%C3%A9/a.bin"}]))
    np.testing.assert_allclose(read(path).mesh.vertices, POINTS * [-1, 1, 1] - [2, 0, 0])
    with path.open("rb") as stream, pytest.raises(FormatError, match="keeps its data in"):
        read(stream, ".gltf")
    for uri, words in (("b.bin", "b.bin: there is no such file"), ("/dev/zero", "keeps its data in /dev/zero")):
        path.write_bytes(gltf(buffers=[{"byteLength": len(buffer), "uri": uri}]))
        with pytest.raises(FormatError, match=words):
            read(path)


OBJ = "".join("v {} {} {}\n".format(*point) for point in POINTS.tolist())


def test_obj_groups_and_materials(tmp_path: Path) -> None:
    """Names after g and usemtl are labels of the faces after them; several names of a line count as one."""
    path = tmp_path / "a.obj"
    path.write_text(f"{OBJ}f 1 2 3\ng left  arm\nusemtl red\nf 1 3 4\nf 1 2 4\ng default\nusemtl red\nf 2 3 4\n")
    groups, materials = field(path, "group"), field(path, "material")
    assert groups.values.tolist() == [0, 1, 1, 0]
    assert groups.labels == {0: "default", 1: "left arm"}
    assert materials.values.tolist() == [0, 1, 1, 1]
    assert materials.labels == {0: "default", 1: "red"}
    mask = read_field(f"{path}:left arm", read(path).mesh)
    assert mask.values.tolist() == [0, 1, 1, 0]
    path.write_text(f"{OBJ}o a\nf 1 2 3\no b\nf 1 3 4\n")
    assert field(path, "group").labels == {0: "a", 1: "b"}
    path.write_text(f"{OBJ}g all\nusemtl red\nf 1 2 3 4\n")
    assert read(path).fields == []
    path.write_text(f"{OBJ}g one\nf 1 2 3 4\ng two\nf 1 2 4\n")
    assert field(path, "group").values.tolist() == [0, 0, 1]
    assert len(FACES) == 2


single = st.floats(allow_nan=False, allow_infinity=False, width=32)


@given(data=st.data())
def test_glb_and_csv_round_trip(data: st.DataObject, tmp_path_factory: pytest.TempPathFactory) -> None:
    """A mesh and its arrays read back from GLB to single precision, by trimesh too, and from CSV to the last bit."""
    folder = tmp_path_factory.mktemp("glb")
    points = data.draw(arrays.arrays(np.float32, (4, 3), elements=single, unique=True)).astype(float)
    mesh = TriangleMesh(points, FACES)
    heat, flow = (data.draw(arrays.arrays(np.float32, shape, elements=single)) for shape in (4, (4, 3)))
    result = Result(mesh, [Field("heat", "vertex", heat), Field("flow", "vertex", flow)])
    write(result, [folder / "a.glb", folder / "a.csv"])
    found = read(folder / "a.glb")
    np.testing.assert_array_equal(found.mesh.vertices, points)
    np.testing.assert_array_equal(found.mesh.faces, FACES)
    np.testing.assert_array_equal(found["heat"], heat)
    np.testing.assert_array_equal(found["flow"], flow)
    assert 0 <= found["color"].min() <= found["color"].max() <= 1
    theirs = trimesh.load(folder / "a.glb", process=False, force="mesh")
    np.testing.assert_array_equal(theirs.vertices, points)
    np.testing.assert_array_equal(theirs.faces, FACES)
    np.testing.assert_array_equal(theirs.vertex_attributes["_HEAT"].ravel(), heat)
    np.testing.assert_array_equal(read_field(f"{folder}/a.csv:heat", mesh).values, heat)
    np.testing.assert_array_equal(read_field(f"{folder}/a.csv:flow_x,flow_y,flow_z", mesh).values, flow)


def test_what_glb_and_csv_leave_out(tmp_path: Path) -> None:
    """Remarks name arrays on faces; a table of faces is written where no array is on vertices; inf stays in CSV."""
    mesh = TriangleMesh(POINTS, FACES)
    area, far = Field("area", "face", mesh.face_areas), Field("far", "vertex", np.array([0, np.inf, 1, 2]))
    both = Result(mesh, [area, far])
    write(both, [tmp_path / "a.glb", tmp_path / "a.csv"])
    assert "area (per face)" in writing_remarks(both, tmp_path / "a.glb")[0]
    assert "area (per face)" in writing_remarks(both, tmp_path / "a.csv")[0]
    assert read_csv(tmp_path / "a.csv")["far"].tolist() == [0, np.inf, 1, 2]
    assert (read(tmp_path / "a.glb")["color"][1] == 0.5).all()
    only = Result(mesh, [area])
    write(only, tmp_path / "b.csv")
    assert writing_remarks(only, tmp_path / "b.csv") == []
    assert list(read_csv(tmp_path / "b.csv")) == ["face", "x", "y", "z", "area"]
    surface = pyvista.read(tmp_path / "a.glb").combine().extract_surface(algorithm="dataset_surface")
    np.testing.assert_allclose(surface.points, POINTS)
