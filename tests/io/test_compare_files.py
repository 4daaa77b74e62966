"""Files of every format compared: equal to the bit, or different where one value was changed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista
import scipy.sparse as sp

from geomhw.compare import Comparison, Ignored, Tolerance, compare_files
from geomhw.compare.arrays import compare_sparse
from geomhw.compare.documents import compare_documents
from geomhw.compare.meshes import compare_meshes
from geomhw.errors import GeomhwError
from geomhw.io import write
from geomhw.io.artifacts.matrices import write_matrix
from geomhw.io.artifacts.series import SeriesWriter
from geomhw.io.artifacts.tables import write_csv
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.laplacian import stiffness
from geomhw.results import Field, Result
from support.comparisons import DEFAULT, NONE, arrays_on, one, planted
from support.meshes import ZOO, zoo_mesh
from support.program import run, save_off

BALL = icosphere(2)


pytestmark = pytest.mark.usefixtures("folder")


# -- meshes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ZOO)
def test_same_in_every_format(name):
    """Files of one result in four formats are pairwise equal, to the last bit."""
    files = [f"m.{extension}" for extension in ("vtk", "vtp", "vtu", "ply")]
    write(arrays_on(zoo_mesh(name)), files)
    for a in files:
        for b in files:
            found = compare_files(a, b, Tolerance(0.0))
            assert found.same, found.different
            assert {f.name for f in found.findings} == {"positions", "faces", "reach", "wind", "gale", "label"}


def test_same_shape_in_every_format():
    """Meshes as OFF, OBJ and PLY are equal to the last bit; STL is compared by corners, in single precision."""
    save_off(BALL, "m.off")
    corners = [f"f {a} {b} {c}" for a, b, c in (BALL.faces + 1).tolist()]
    Path("m.obj").write_text("\n".join([*(f"v {x!r} {y!r} {z!r}" for x, y, z in BALL.vertices.tolist()), *corners]))
    write(Result(BALL), "m.ply")
    for a, b in (("m.off", "m.obj"), ("m.obj", "m.ply")):
        assert compare_files(a, b, Tolerance(0.0)).same
    pyvista.PolyData.from_regular_faces(BALL.vertices, BALL.faces).save("m.stl")
    found = compare_files("m.stl", "m.off")
    assert [(f.name, f.size, f.same) for f in found.findings] == [("corners", (320, 3, 3), True)]
    assert 0 < found.findings[0].relative < 1e-7
    assert not compare_files("m.stl", "m.off", Tolerance(1e-9)).same


def test_planted_in_a_mesh():
    """One changed value is found with name, location, index, size and both values."""
    result = arrays_on(BALL)
    write(result, "a.vtp")
    for name, location, index in (("reach", "vertex", (7,)), ("wind", "vertex", (9, 2)), ("gale", "face", (300, 1))):
        before = float(np.asarray(result[name])[index])
        write(planted(result, name, index, before + 1e-5), "b.ply")
        finding = one(compare_files("a.vtp", "b.ply", Tolerance(1e-7)))
        assert (finding.name, finding.location, finding.index, finding.beyond) == (name, location, index, 1)
        assert finding.values == (before, before + 1e-5)
        assert finding.absolute == pytest.approx(1e-5, rel=1e-6)
    vertices = BALL.vertices.copy()
    vertices[5, 1] += 1e-6
    write(replace(result, mesh=TriangleMesh(vertices, BALL.faces)), "b.ply")
    assert (one(compare_files("a.vtp", "b.ply")).name, one(compare_files("a.vtp", "b.ply")).index) == (
        "positions",
        (5, 1),
    )
    faces = np.roll(BALL.faces, 1, axis=1)
    faces[1:] = BALL.faces[1:]
    write(replace(result, mesh=TriangleMesh(BALL.vertices, faces)), "b.ply")
    assert (one(compare_files("a.vtp", "b.ply")).name, one(compare_files("a.vtp", "b.ply")).index) == ("faces", (0, 0))


def test_positions_have_the_scale_of_the_mesh():
    """The tolerance of positions is relative to the extent, at any distance from the origin."""
    for shift in (0.0, 1e6):
        vertices = BALL.vertices + np.array([shift, 0, 0])
        moved = vertices.copy()
        moved[3, 2] += 1e-5
        pair = [Result(TriangleMesh(points, BALL.faces)) for points in (vertices, moved)]
        assert one(Comparison("mesh", compare_meshes(*pair, Tolerance(1e-6), NONE))).index == (3, 2)


def test_missing_and_ignored():
    """Arrays that one side lacks are named; patterns leave arrays out."""
    result = arrays_on(BALL)
    write(result, "a.vtk")
    write(replace(result, fields=[*result.fields[1:], Field("new", "vertex", np.ones(162))]), "b.vtk")
    told = {(f.name, f.note) for f in compare_files("a.vtk", "b.vtk").different}
    assert told == {("reach", "only in A"), ("new", "only in B")}
    assert compare_files("a.vtk", "b.vtk", ignored=Ignored(["r?ach", "n*"])).same
    with pytest.raises(GeomhwError, match="nothing is compared"):
        compare_files("a.vtk", "b.vtk", ignored=Ignored(["*"]))


def test_other_sizes_are_one_line():
    """Different numbers of vertices and faces give one line each, which no pattern hides."""
    write(arrays_on(BALL), "a.vtp")
    other = arrays_on(icosphere(1))
    write(other, "b.vtp")
    for ignored in (NONE, Ignored(["v*", "f*", "positions"])):
        findings = compare_files("a.vtp", "b.vtp", ignored=ignored).findings
        assert [f.note for f in findings] == ["162 in A, 42 in B", "320 in A, 80 in B"]
    write(replace(other, fields=other.fields[1:]), "b.vtp")
    assert [(f.name, f.note) for f in compare_files("a.vtp", "b.vtp").findings][2:] == [("reach", "only in A")]


def test_single_precision_is_noticed(tmp_path):
    """Single-precision arrays have their own tolerance; ``info`` names them."""
    a = pyvista.PolyData.from_regular_faces(BALL.vertices, BALL.faces)
    for name in ("u", "v"):
        a.point_data[name] = BALL.vertices[:, 0]
    b = a.copy()
    b.point_data["u"] = a.point_data["u"].astype(np.float32)
    a.save("a.vtp")
    b.save("b.vtp")
    found = compare_files("a.vtp", "b.vtp")
    assert found.same
    assert {f.name: f.relative > 1e-9 for f in found.findings if f.location == "vertex"} == {
        "positions": False,
        "u": True,
        "v": False,
    }
    assert "single precision" in run("info", "b.vtp").stdout
    assert "single precision" not in run("info", "a.vtp").stdout
    b.point_data["v"] = a.point_data["v"] * (1 + 1e-7)
    b.save("b.vtp")
    assert one(compare_files("a.vtp", "b.vtp")).name == "v"


# -- series ------------------------------------------------------------------------------------------------------


def save_series(name: str, frames: list[tuple[float, Result]]) -> None:
    writer = SeriesWriter(name)
    for time, result in frames:
        writer.add(time, result)


def test_series():
    """A series gives the worst frame of each array; times and lengths are compared."""
    result = arrays_on(BALL)
    frames = [(0.1 * k, result) for k in range(4)]
    save_series("a.pvd", frames)
    save_series("b.pvd", frames)
    assert compare_files("a.pvd", "b.pvd", Tolerance(0.0)).same
    small, large = (planted(result, "gale", (17, 1), np.asarray(result["gale"])[17, 1] + d) for d in (1e-3, 1e-2))
    save_series("b.pvd", [frames[0], (0.1, small), (0.2, large), (0.3, small)])
    finding = one(compare_files("a.pvd", "b.pvd"))
    assert (finding.name, finding.frame, finding.index) == ("gale", 2, (17, 1))
    assert finding.absolute == pytest.approx(1e-2)
    assert "at frame 2 [17, 1]: " in run("compare", "a.pvd", "b.pvd").stdout
    save_series("b.pvd", [*frames[:3], (0.31, result)])
    assert (one(compare_files("a.pvd", "b.pvd")).name, one(compare_files("a.pvd", "b.pvd")).index) == ("times", (3,))
    assert compare_files("a.pvd", "b.pvd", ignored=Ignored(["times"])).same
    save_series("b.pvd", frames[:3])
    assert one(compare_files("a.pvd", "b.pvd")).note == "4 in A, 3 in B"


def test_series_with_second_parts():
    """Second parts of a time step are not compared."""
    frames = [(0.0, arrays_on(BALL)), (0.5, arrays_on(BALL))]
    save_series("a.pvd", frames)
    save_series("b.pvd", frames)
    text = Path("b.pvd").read_text()
    more = [f'<DataSet timestep="{t!r}" part="1" file="nowhere.{k}.vtp"/>' for k, (t, _) in enumerate(frames)]
    Path("b.pvd").write_text(text.replace("  </Collection>", "\n".join([*more, "  </Collection>"])))
    assert compare_files("a.pvd", "b.pvd").same


# -- tables, documents, matrices ---------------------------------------------------------------------------------


def test_tables():
    """Columns are compared by name: integers exactly, NaN equal, texts equal."""
    rows = [{"step": k, "energy": 2.0 + 1e-3 * k, "best": float("nan"), "top": float("inf")} for k in range(6)]
    write_csv("a.csv", rows)
    write_csv("b.csv", [dict(reversed(row.items())) for row in rows])
    assert compare_files("a.csv", "b.csv", Tolerance(0.0)).same
    write_csv("b.csv", [{**row, "energy": row["energy"] + 1e-6 * (k == 4)} for k, row in enumerate(rows)])
    finding = one(compare_files("a.csv", "b.csv"))
    assert (finding.location, finding.name, finding.index) == ("column", "energy", (4,))
    write_csv("b.csv", [{**row, "step": row["step"] + (k == 2)} for k, row in enumerate(rows)])
    assert one(compare_files("a.csv", "b.csv", Tolerance(0.9))).name == "step"
    write_csv("b.csv", rows[:5])
    assert {f.note for f in compare_files("a.csv", "b.csv").different} == {"6 in A, 5 in B"}
    Path("b.csv").write_text("step\n0\n")
    assert {f.note for f in compare_files("a.csv", "b.csv").different} >= {"only in A"}
    Path("a.csv").write_text("name,u\nx,1\ny,\n")
    Path("b.csv").write_text("name,u\nx,1.0\nz,\n")
    assert (one(compare_files("a.csv", "b.csv")).name, one(compare_files("a.csv", "b.csv")).values) == (
        "name",
        ("y", "z"),
    )


REPORT = {
    "command": "geodesic",
    "input": {"path": "/here/moo.off", "file": "moo.off"},
    "mesh": {"n_vertices": 12, "genus": None, "oriented": True, "bounds": [[-1.0, 0.0], [1.0, 1e-9]]},
    "answers": [{"distance": 3.5, "vertex": 4}, {"distance": float("nan"), "vertex": 5}],
    "files": ["a.vtk"],
    "seconds": {"read": 0.1},
}


def document(**changes) -> list[tuple[str, str]]:
    """Return what differs in the report after changes at the given paths."""
    other = json.loads(json.dumps(REPORT))
    for path, value in changes.items():
        *way, last = path.split("__")
        place = other
        for key in way:
            place = place[int(key) if key.isdigit() else key]
        place[last] = value
    Path("a.json").write_text(json.dumps(REPORT))
    Path("b.json").write_text(json.dumps(other))
    return [(f.name, f.note or f.values) for f in compare_files("a.json", "b.json").different]


def test_documents():
    """Values are compared by path; entries that vary from run to run are left out."""
    assert document() == []
    assert document(seconds={"read": 7}, files=[], input__path="/there/moo.off", input__file="x.off") == []
    assert document(answers__0__distance=3.5 + 1e-12) == []
    assert document(answers__0__distance=3.6) == [("answers[0].distance", (3.5, 3.6))]
    assert document(answers__1__distance=3.5)[0][0] == "answers[1].distance"
    assert document(answers__0__vertex=5) == [("answers[0].vertex", (4, 5))]
    assert document(mesh__genus=0) == [("mesh.genus", (None, 0))]
    assert document(mesh__oriented=1) == [("mesh.oriented", (True, 1))]
    assert document(command="info") == [("command", ("geodesic", "info"))]
    assert document(mesh__bounds=[[-1.0, 0.0], [1.0, 5e-10]]) == []
    assert document(mesh__bounds=[[-1.0, 0.0], [1.0, 1e-5]]) == [("mesh.bounds", (1e-9, 1e-5))]
    assert document(mesh__bounds=[[-1.0, 0.0]]) == [("mesh.bounds", "2 x 2 in A, 1 x 2 in B")]
    assert document(mesh__new=1) == [("mesh.new", "only in B")]
    assert document(answers=REPORT["answers"][:1])[0] == ("answers", "2 entries in A, 1 in B")


def test_documents_whole():
    """With ``everything`` all entries are compared, except those ignored by name."""
    document(seconds={"read": 7}, files=[], input__path="/there/moo.off")
    found = compare_files("a.json", "b.json", ignored=Ignored(["files"]), everything=True).different
    assert [finding.name for finding in found] == ["input.path", "seconds.read"]
    assert run("compare", "a.json", "b.json").exit_code == 0
    assert run("compare", "a.json", "b.json", "--everything").exit_code == 1


@pytest.mark.parametrize(
    ("patterns", "left"),
    [
        ([], ["a.u", "b[0].u", "b[1].u"]),
        (["u"], []),
        (["b[*].u"], ["a.u"]),
        (["b[1]*"], ["a.u", "b[0].u"]),
        (["b"], ["a.u"]),
        (["a.?"], ["b[0].u", "b[1].u"]),
        (["b[0]"], ["a.u", "b[1].u"]),
    ],
)
def test_ignored_paths(patterns, left):
    """Patterns match names, paths and enclosing paths; brackets are literal."""
    one, other = ({"a": {"u": x}, "b": [{"u": x}, {"u": x}], "c": 1} for x in (1.0, 2.0))
    findings = compare_documents(one, other, DEFAULT, Ignored(patterns))
    assert [f.name for f in findings if not f.same] == left


@pytest.mark.parametrize("operator", [stiffness, complex_connection_stiffness])
def test_matrices(operator):
    """Matrices in both formats are equal to the last bit; a changed entry is found."""
    matrix = operator(BALL)
    write_matrix("a.npz", matrix)
    write_matrix("a.mtx", matrix)
    found = compare_files("a.npz", "a.mtx", Tolerance(0.0))
    assert found.same
    assert found.findings[0].size == (162, 162)
    other = sp.lil_array(matrix)
    for place in ((7, 5), (int(matrix.indices[0]), 0)):
        changed = other.copy()
        changed[place] += 1e-3
        write_matrix("b.mtx", sp.csr_array(changed))
        finding = one(compare_files("a.npz", "b.mtx"))
        assert finding.index == place
        assert finding.absolute == pytest.approx(1e-3)
    dense = compare_sparse("S", matrix.toarray(), matrix, Tolerance(0.0))
    assert dense.same
    assert compare_sparse("S", matrix, matrix[:, :3], DEFAULT).note == "162 x 162 in A, 162 x 3 in B"


def test_entries_that_are_zero():
    """An explicit zero equals a missing entry; NaN does not."""
    plain = sp.coo_array(([1.0], ([0], [1])), shape=(2, 3))
    stored = sp.coo_array(([1.0, 0.0], ([0, 1], [1, 2])), shape=(2, 3))
    assert compare_sparse("S", plain, stored, Tolerance(0.0)).note == "1 entries in A, 2 in B"
    assert compare_sparse("S", plain, stored, Tolerance(0.0)).same
    broken = sp.coo_array(([1.0, np.nan], ([0, 1], [1, 2])), shape=(2, 3))
    assert compare_sparse("S", plain, broken, DEFAULT).index == (1, 2)


def test_numpy_files():
    """Arrays of .npy and .npz files are compared by name, text included."""
    u = np.random.default_rng(2).normal(size=(5, 4, 3))
    v = u.copy()
    v[2, 3, 1] += 1e-4
    np.save("a.npy", u)
    np.save("b.npy", v)
    assert compare_files("a.npy", "a.npy", Tolerance(0.0)).same
    assert one(compare_files("a.npy", "b.npy")).index == (2, 3, 1)
    np.savez("a.npz", u=u, what=np.array("x"))
    np.savez("b.npz", u=u, what=np.array("y"), more=u)
    different = compare_files("a.npz", "b.npz").different
    assert [(f.name, f.values or f.note) for f in different] == [("what", ("x", "y")), ("more", "only in B")]
    assert compare_files("a.npz", "b.npz", ignored=Ignored(["what", "more"])).same
