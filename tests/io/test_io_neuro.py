"""Files of neuroimaging: GIFTI and FreeSurfer, read as nibabel reads them, and GIFTI written for Workbench."""

import json
from pathlib import Path

import nibabel
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from nibabel.freesurfer import io as freesurfer

from geomhw.io import read, read_field, read_polylines, write, writing_remarks
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result
from support.neuro_files import (
    FACES,
    LABEL_TEXT,
    LABELS,
    NAMES,
    POINTS,
    border_text,
    labels,
    metric,
    quads,
    save_annot,
    save_overlay,
    surface,
)
from support.program import run, save_off

SQUARE = TriangleMesh(POINTS, FACES)


@pytest.mark.parametrize("encoding", ["ASCII", "B64BIN", "B64GZ"])
@pytest.mark.parametrize("endian", ["big", "little"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_gifti_dialects(tmp_path: Path, encoding: str, endian: str, order: str) -> None:
    """All encodings, byte orders and orders of rows give the same surface."""
    settings = {"encoding": f"GIFTI_ENCODING_{encoding}", "endian": endian, "ordering": order}
    image = surface(**settings)
    if encoding == "ASCII" and order == "F":
        for item in image.darrays:  # nibabel writes text row by row
            item.ind_ord = 1
    image.to_filename(tmp_path / "a.surf.gii")
    result = read(tmp_path / "a.surf.gii")
    np.testing.assert_array_equal(result.mesh.vertices, POINTS)
    np.testing.assert_array_equal(result.mesh.faces, FACES)
    assert result.report["format"] == "GIFTI"


def test_gifti_compressed_as_a_whole(tmp_path: Path) -> None:
    """``.surf.gii.gz`` is read."""
    surface().to_filename(tmp_path / "a.surf.gii.gz")
    np.testing.assert_array_equal(read(tmp_path / "a.surf.gii.gz").mesh.vertices, POINTS)


def test_gifti_transform_is_told(tmp_path: Path) -> None:
    """Coordinates stay in the space of the file; the transform is in the report with a remark."""
    image = surface()
    matrix = np.eye(4)
    matrix[:3, 3] = [1, -18, 19.5]
    image.darrays[0].coordsys = nibabel.gifti.GiftiCoordSystem(3, 1, matrix)
    image.to_filename(tmp_path / "a.surf.gii")
    result = read(tmp_path / "a.surf.gii")
    np.testing.assert_array_equal(result.mesh.vertices, POINTS)
    assert result.report["coordinate_transform"]["matrix"] == matrix.tolist()
    (remark,) = result.report["remarks"]
    assert "not applied" in remark
    assert "talairach" in remark


def test_arrays_by_name_number_or_alone(tmp_path: Path) -> None:
    """An array has a name and a number from 0; the only one needs neither."""
    first, second = np.arange(4, dtype="f4"), np.array([0.5, 1, 2, 4], "f4")
    metric(first, second).to_filename(tmp_path / "two.func.gii")
    metric(second).to_filename(tmp_path / "one.shape.gii")
    for key, values in (("map 1", second), ("0", first), ("1", second)):
        np.testing.assert_array_equal(read_field(f"{tmp_path}/two.func.gii:{key}", SQUARE).values, values)
    assert read_field(f"{tmp_path}/one.shape.gii", SQUARE).location == "vertex"


def test_labels_by_name(tmp_path: Path) -> None:
    """Labels of GIFTI and FreeSurfer keep their names, and a name gives the mask of its vertices."""
    labels().to_filename(tmp_path / "a.label.gii")
    save_annot(tmp_path / "lh.a.annot")
    for name in ("a.label.gii", "lh.a.annot"):
        field = read_field(f"{tmp_path}/{name}", SQUARE)
        np.testing.assert_array_equal(field.values, LABELS)
        assert field.labels is not None
        assert {key: field.labels[key] for key in NAMES} == NAMES
        np.testing.assert_array_equal(read_field(f"{tmp_path}/{name}:medial wall", SQUARE).values, LABELS == 3)


def test_freesurfer_surfaces(tmp_path: Path) -> None:
    """Triangles and both kinds of quads are known by their first bytes; the report has the offset to the scanner."""
    info = {"head": [2, 0, 20], "valid": "1", "filename": "a", "volume": [9] * 3, "voxelsize": [1.0] * 3}
    info |= {f"{axis}ras": vector for axis, vector in zip("xyz", np.eye(3), strict=True)} | {
        "cras": np.array([0.5, -18, 20])
    }
    freesurfer.write_geometry(tmp_path / "lh.white", POINTS, FACES, volume_info=info)
    result = read(tmp_path / "lh.white")
    np.testing.assert_array_equal(result.mesh.vertices, POINTS)
    np.testing.assert_array_equal(result.mesh.faces, FACES)
    assert result.report["c_ras"] == [0.5, -18, 20]
    assert "c_ras" in result.report["remarks"][0]
    for mark in (b"\xff\xff\xff", b"\xff\xff\xfd"):
        (tmp_path / "lh.orig").write_bytes(quads(mark))
        result = read(tmp_path / "lh.orig")
        np.testing.assert_allclose(result.mesh.vertices, POINTS, atol=1e-12)
        assert result.mesh.n_faces == 2
        assert result.report["polygons"] == 1


def test_freesurfer_arrays(tmp_path: Path) -> None:
    """Curv files of both kinds, overlays and labels give arrays on vertices."""
    values = np.array([0.25, 1, -2, 8])
    freesurfer.write_morph_data(tmp_path / "lh.thickness", values, fnum=2)
    (tmp_path / "lh.curv").write_bytes(b"\0\0\4\0\0\2" + (values * 100).astype(">i2").tobytes())
    save_overlay(tmp_path / "lh.area.mgz", values[None])
    for name in ("lh.thickness", "lh.curv", "lh.area.mgz"):
        field = read_field(f"{tmp_path}/{name}", SQUARE)
        np.testing.assert_array_equal(field.values, values)
        assert field.name == name.removesuffix(".mgz")
    save_overlay(tmp_path / "t.mgh", np.stack([values, 2 * values]))
    np.testing.assert_array_equal(read_field(f"{tmp_path}/t.mgh:1", SQUARE).values, 2 * values)
    (tmp_path / "lh.v1.label").write_bytes(LABEL_TEXT)
    assert read_field(f"{tmp_path}/lh.v1.label:label", SQUARE).values.tolist() == [0, 1, 0, 1]
    assert read_field(f"{tmp_path}/lh.v1.label:value", SQUARE).values.tolist() == [0, 0.25, 0, -2]


single = st.floats(allow_nan=False, allow_infinity=False, width=32)
texts = st.text(st.characters(blacklist_categories=("Cs", "Cc", "Zl", "Zp", "Zs")), min_size=1, max_size=9)


@given(data=st.data())
def test_round_trip(data: st.DataObject, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Surfaces, arrays in single precision, integers and labels read back to the last bit, by nibabel too."""
    folder = tmp_path_factory.mktemp("gifti")
    points = data.draw(arrays.arrays(np.float32, (4, 3), elements=single)).astype(float)
    mesh = TriangleMesh(points, FACES)
    names = data.draw(st.lists(texts, min_size=2, max_size=2, unique=True))
    first = data.draw(arrays.arrays(np.float32, 4, elements=single))
    second = data.draw(arrays.arrays(np.int32, 4))
    table = {int(key): data.draw(texts) for key in second}
    result = Result(mesh, [Field(names[0], "vertex", first), Field(names[1], "vertex", second, table)])
    write(result, [f"{folder}/{name}" for name in ("a.gii", "a.surf.gii", "a.func.gii", "a.label.gii")])
    for name in ("a.gii", "a.surf.gii"):
        found = read(f"{folder}/{name}")
        np.testing.assert_array_equal(found.mesh.vertices, points)
        np.testing.assert_array_equal(found.mesh.faces, FACES)
    for k, values in enumerate((first, second)):
        found_field = read_field(f"{folder}/a.func.gii:{names[k]}", mesh)
        assert found_field.name == names[k]
        exact = values if k == 0 or np.abs(values.astype(float)).max() > 2**24 else values.astype("f4")
        np.testing.assert_array_equal(found_field.values, exact)
        np.testing.assert_array_equal(nibabel.load(folder / "a.func.gii").darrays[k].data, exact)
    found_field = read_field(f"{folder}/a.label.gii", mesh)
    np.testing.assert_array_equal(found_field.values, second)
    assert found_field.labels is not None
    assert found_field.labels.items() >= table.items()
    theirs = nibabel.load(folder / "a.label.gii")
    np.testing.assert_array_equal(theirs.darrays[0].data, second)
    assert theirs.labeltable.get_labels_as_dict().items() >= table.items()


def test_what_gifti_cannot_hold_is_told(tmp_path: Path) -> None:
    """Infinite distances are -1, face arrays and vectors are left out or divided, and remarks name all of it."""
    fields = [Field("distance", "vertex", np.array([0, 1, np.inf, 2])), Field("area", "face", np.ones(2))]
    result = Result(SQUARE, [*fields, Field("v", "vertex", np.arange(12.0).reshape(4, 3))])
    path = tmp_path / "a.func.gii"
    write(result, path)
    assert read_field(f"{path}:distance", SQUARE).values.tolist() == [0, 1, -1, 2]
    assert read_field(f"{path}:v_y", SQUARE).values.tolist() == [1, 4, 7, 10]
    remarks = " ".join(writing_remarks(result, path))
    assert all(word in remarks for word in ("without area", "-1 where distance", "single precision"))


def test_commands_take_these_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Masks and sources come from a label file by name, and distances go to a metric file."""
    monkeypatch.chdir(tmp_path)
    mesh = icosphere(2)
    save_off(mesh)
    areas = np.where(mesh.vertices[:, 0] > 0.3, 1, 2).astype(np.int32)
    write(Result(mesh, [Field("areas", "vertex", areas, {1: "front", 2: "back"})]), ["a.label.gii", "a.surf.gii"])
    answer = run("geodesic", "a.surf.gii", "--source", "a.label.gii:front=1", "-o", "d.func.gii", "--no-png")
    assert answer.exit_code == 0, answer.stderr
    assert "single precision" in answer.stdout
    distance = np.asarray(read_field("d.func.gii:distance", mesh).values)
    assert (distance[areas == 1] == 0).all()
    assert (distance[areas == 2] > 0).all()
    answer = run("geodesic", "a.surf.gii", "--source", "0", "--mask", "a.label.gii:back", "-o", "e.vtp", "--no-png")
    assert answer.exit_code in (0, 1)


def test_labels_without_names_get_some(tmp_path: Path) -> None:
    """Label 0 is a label, -1 is what Workbench knows as unassigned, and is transparent."""
    write(Result(SQUARE, [Field("cell", "vertex", np.array([0, 1, -1, 1]))]), tmp_path / "a.label.gii")
    table = nibabel.load(tmp_path / "a.label.gii").labeltable
    assert table.get_labels_as_dict() == {-1: "???", 0: "label_0", 1: "label_1"}
    assert [label.alpha for label in table.labels] == [0, 1, 1]
    write(Result(SQUARE, [Field("cell", "vertex", np.array([1, 1, 2, 1]))]), tmp_path / "b.label.gii")
    assert nibabel.load(tmp_path / "b.label.gii").labeltable.get_labels_as_dict()[0] == "???"


def test_borders_of_workbench(tmp_path: Path) -> None:
    """Points lie between three vertices by their weights; a closed border ends where it starts."""
    for closed in (False, True):
        (tmp_path / "a.border").write_text(border_text(closed=closed))
        found = read_polylines(tmp_path / "a.border", POINTS)
        expected = [POINTS[:3].T @ [0.5, 0.25, 0.25], (POINTS[2] + POINTS[3]) / 2]
        np.testing.assert_allclose(found.points, [*expected, expected[0]] if closed else expected)
        assert found.lines is not None
        assert found.lines.tolist() == [0, 3 if closed else 2]


def test_a_mesh_is_cut_along_a_border(folder: Path) -> None:
    """A border round a vertex of a sphere, through the middles of its edges, cuts a disc off."""
    ball = icosphere(2)
    save_off(ball, "ball.off")
    fan = np.flatnonzero((ball.faces == 0).any(axis=1))
    rim = {int(b): int(c) for a, b, c in (np.roll(f, -int(np.flatnonzero(f == 0)[0])) for f in ball.faces[fan])}
    order = [next(iter(rim))]
    while len(order) < len(rim):
        order.append(rim[order[-1]])
    rows = "\n".join(f"0 {v} {v}" for v in order)
    text = border_text(rows, "\n".join(["1 1 0"] * len(order)), closed=True).replace('Vertices="4"', 'Vertices="162"')
    (folder / "a.border").write_text(text)
    answer = run("split", "ball.off", "--curve", "a.border", "--no-png", "-o", "cut.vtp", "--json")
    report = json.loads(answer.stdout)
    middles = (ball.vertices[0] + ball.vertices[order]) / 2
    length = np.linalg.norm(middles - np.roll(middles, 1, axis=0), axis=1).sum()
    assert report["cut"]["length"] == pytest.approx(length, rel=1e-12)
    assert [piece["euler_characteristic"] for piece in report["pieces"]] == [1, 1]
