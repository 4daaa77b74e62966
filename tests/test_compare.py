"""Comparing: equal is equal in every format, a planted deviation is found where it is, what passes is what is said."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista
import scipy.sparse as sp
from conftest import ZOO, zoo_mesh
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from test_commands import run, save_off

from geomhw.compare import Comparison, Finding, Ignored, Tolerance, compare_arrays, compare_files
from geomhw.compare.documents import compare_documents
from geomhw.compare.matrices import compare_sparse
from geomhw.compare.meshes import compare_meshes
from geomhw.errors import GeomhwError
from geomhw.io import SeriesWriter, write, write_csv, write_matrix
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.laplacian import stiffness
from geomhw.results import Field, Result

BALL = icosphere(2)
NONE, DEFAULT = Ignored(), Tolerance()


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def arrays_on(mesh: TriangleMesh) -> Result:
    """A mesh with an array of each kind at each place, infinity and NaN among them."""
    rng = np.random.default_rng(1)
    reach = rng.normal(size=mesh.n_vertices)
    reach[0], reach[1] = np.inf, np.nan
    return Result(
        mesh,
        [
            Field("reach", "vertex", reach),
            Field("wind", "vertex", rng.normal(size=(mesh.n_vertices, 3))),
            Field("gale", "face", rng.normal(size=(mesh.n_faces, 3))),
            Field("label", "face", np.arange(mesh.n_faces)),
        ],
    )


def planted(result: Result, name: str, index: tuple[int, ...], value: float) -> Result:
    """The same with one value changed."""
    fields = []
    for field in result.fields:
        values = np.array(field.values)
        if field.name == name:
            values[index] = value
        fields.append(replace(field, values=values))
    return replace(result, fields=fields)


def one(comparison: Comparison) -> Finding:
    """The only finding that differs."""
    (finding,) = comparison.different
    return finding


def arrays(a, b, tolerance: Tolerance = DEFAULT, **options) -> Finding:
    return compare_arrays("u", "vertex", a, b, tolerance, **options)


# -- numbers -----------------------------------------------------------------------------------------------------

NUMBERS = hnp.arrays(float, st.integers(1, 20), elements=st.floats(allow_nan=True, allow_infinity=True))


@given(NUMBERS)
def test_anything_equals_itself(values):
    """At no tolerance at all, NaN and infinities too."""
    finding = arrays(values, values.copy(), Tolerance(0.0))
    assert finding.same
    assert finding.absolute == 0


@given(NUMBERS, st.data())
def test_order_does_not_matter(a, data):
    """A beside B says of all that B beside A says."""
    b = data.draw(hnp.arrays(float, a.shape, elements=st.floats(-1e3, 1e3)))
    for rtol in (1e-9, 0.5):
        p, q = arrays(a, b, Tolerance(rtol)), arrays(b, a, Tolerance(rtol))
        assert (p.same, p.absolute, p.beyond, p.index) == (q.same, q.absolute, q.beyond, q.index)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_tolerance_is_what_it_says(scale):
    """A deviation under rtol times the largest magnitude passes at every value, one over it does not, at any scale."""
    a = scale * np.array([0.0, 1e-3, -8.0, 3.0])
    for i in range(4):
        for share, same in ((0.99, True), (1.01, False)):
            b = a.copy()
            b[i] += share * 1e-6 * 8 * scale
            finding = arrays(a, b, Tolerance(1e-6), single=False)
            assert finding.same is same
            assert finding.index == (i,)
            assert finding.absolute == pytest.approx(share * 8e-6 * scale, rel=1e-6)
            assert finding.relative == pytest.approx(share * 1e-6, rel=1e-5)
            assert finding.tolerance == pytest.approx(8e-6 * scale)
            assert finding.beyond == (not same)


def test_atol_adds():
    """|a - b| <= atol + rtol * scale: noise passes by atol alone, and the two add up."""
    noise, other = np.array([1e-17, -2e-17]), np.array([3e-17, 1e-17])
    assert not arrays(noise, other).same
    assert arrays(noise, other, Tolerance(atol=4e-17)).same
    assert not arrays(noise, other, Tolerance(atol=2e-17)).same
    assert arrays([1.0], [1.0 + 3e-6], Tolerance(rtol=2e-6, atol=2e-6)).same


def test_one_that_blows_up_does_not_pass():
    """A value beyond all others raises the scale, but is a whole scale away from its partner."""
    a = np.ones(5)
    b = a.copy()
    b[3] = 1e300
    finding = arrays(a, b, Tolerance(0.5))
    assert not finding.same
    assert finding.index == (3,)
    assert not arrays([1e308], [-1e308], Tolerance(1.0)).same


@pytest.mark.parametrize(
    ("a", "b"), [(np.nan, 1.0), (np.inf, 1.0), (np.inf, -np.inf), (np.nan, np.inf), (1 + 1j * np.nan, 1 + 1j)]
)
def test_what_is_not_finite_equals_itself_only(a, b):
    """NaN and the infinities beside anything else are different at any tolerance, and others count no less."""
    finding = arrays([2.0, a], [2.0, b], Tolerance(0.9, 1e300))
    assert not finding.same
    assert finding.index == (1,)
    assert finding.absolute == np.inf
    assert not arrays([1e300, a], [1e300, b], Tolerance(1e300)).same  # where the tolerance itself overflows


@pytest.mark.parametrize(
    ("a", "b", "worst"),
    [
        (np.uint8([3, 250]), np.uint8([3, 251]), 1),
        (np.uint8([0, 7]), np.uint8([0, 255]), 248),
        (np.int64([0, 2**53]), np.int64([0, 2**53 + 1]), 1),
        (np.array([False, True]), np.array([False, False]), 1),
    ],
)
def test_whole_numbers_are_exact(a, b, worst):
    """No tolerance for counts and indices; no overflow and no rounding of the difference either."""
    finding = arrays(a, b, Tolerance(0.9, 1e9))
    assert (finding.same, finding.index, finding.absolute) == (False, (1,), worst)


def test_types_and_widths():
    """Whole numbers beside others are numbers; a column is an array; single precision has its own default."""
    assert arrays(np.array([1, 2]), np.array([1.0, 2.0 + 1e-10])).same
    assert arrays(np.ones((4, 1)), np.ones(4)).same
    x = np.random.default_rng(0).normal(size=50)
    assert arrays(x, x.astype(np.float32)).same
    assert not arrays(x, x.astype(np.float32).astype(np.float64)).same
    assert not arrays(x, x.astype(np.float32), Tolerance(1e-9)).same


def test_shapes_and_texts():
    """Unequal shapes, unequal texts, text beside numbers: one line each."""
    assert arrays(np.ones((3, 2)), np.ones(4)).note == "3 x 2 in A, 4 in B"
    finding = arrays(np.array(["a", "b"]), np.array(["a", "c"]))
    assert (finding.same, finding.index, finding.values) == (False, (1,), ("b", "c"))
    assert arrays(np.array(["a"]), np.array([1.0])).note == "text in A, numbers in B"
    records = np.zeros(2, [("u", float)])
    assert arrays(records, records).same
    assert arrays(records, np.zeros(2, [("v", float)])).note == "[('u', '<f8')] in A, [('v', '<f8')] in B"


def test_signaling_nan() -> None:
    """A NaN that traps in some processors is one as any other, without a warning of numpy's."""
    values = np.frombuffer(bytes.fromhex("3f800000ffffff85ff800001"), ">f4")
    assert np.isnan(values).tolist() == [False, True, True]
    assert compare_arrays("u", "vertex", values, values.copy(), Tolerance()).same


@pytest.mark.parametrize("rtol", [-1e-9, np.nan, np.inf])
def test_tolerances_are_checked(rtol):
    with pytest.raises(GeomhwError, match="rtol is"):
        Tolerance(rtol)


# -- meshes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ZOO)
def test_same_in_every_format(name):
    """What is written in four formats is equal to the bit between any two of them."""
    files = [f"m.{extension}" for extension in ("vtk", "vtp", "vtu", "ply")]
    write(arrays_on(zoo_mesh(name)), files)
    for a in files:
        for b in files:
            found = compare_files(a, b, Tolerance(0.0))
            assert found.same, found.different
            assert {f.name for f in found.findings} == {"positions", "faces", "reach", "wind", "gale", "label"}


def test_same_shape_in_every_format():
    """Bare meshes as OFF, OBJ, STL and PLY: STL by corners and in its own precision, the others to the bit."""
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
    """Each array in turn, a position and a face: found by name, place, index, size and both values."""
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
    """A vertex that is off by 1e-5 of the extent is found however far away the mesh lies."""
    for shift in (0.0, 1e6):
        vertices = BALL.vertices + np.array([shift, 0, 0])
        moved = vertices.copy()
        moved[3, 2] += 1e-5
        pair = [Result(TriangleMesh(points, BALL.faces)) for points in (vertices, moved)]
        assert one(Comparison("mesh", compare_meshes(*pair, Tolerance(1e-6), NONE))).index == (3, 2)


def test_missing_and_ignored():
    """Arrays that one side lacks are named with the side; names and patterns leave out, also by --ignore."""
    result = arrays_on(BALL)
    write(result, "a.vtk")
    write(replace(result, fields=[*result.fields[1:], Field("new", "vertex", np.ones(162))]), "b.vtk")
    told = {(f.name, f.note) for f in compare_files("a.vtk", "b.vtk").different}
    assert told == {("reach", "only in A"), ("new", "only in B")}
    assert compare_files("a.vtk", "b.vtk", ignored=Ignored(["r?ach", "n*"])).same
    with pytest.raises(GeomhwError, match="nothing is compared"):
        compare_files("a.vtk", "b.vtk", ignored=Ignored(["*"]))


def test_other_sizes_are_one_line():
    """Other numbers of vertices and faces, and none of the arrays on them; no pattern hides that."""
    write(arrays_on(BALL), "a.vtp")
    other = arrays_on(icosphere(1))
    write(other, "b.vtp")
    for ignored in (NONE, Ignored(["v*", "f*", "positions"])):
        findings = compare_files("a.vtp", "b.vtp", ignored=ignored).findings
        assert [f.note for f in findings] == ["162 in A, 42 in B", "320 in A, 80 in B"]
    write(replace(other, fields=other.fields[1:]), "b.vtp")
    assert [(f.name, f.note) for f in compare_files("a.vtp", "b.vtp").findings][2:] == [("reach", "only in A")]


def test_single_precision_is_noticed(tmp_path):
    """Arrays that a file holds as floats have the tolerance of floats, the others of doubles; info says which."""
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
    """The worst of all frames, one line an array; times; other lengths; what is a second part is passed over."""
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
    """Files that a time step has beside its mesh are not compared."""
    frames = [(0.0, arrays_on(BALL)), (0.5, arrays_on(BALL))]
    save_series("a.pvd", frames)
    save_series("b.pvd", frames)
    text = Path("b.pvd").read_text()
    more = [f'<DataSet timestep="{t!r}" part="1" file="nowhere.{k}.vtp"/>' for k, (t, _) in enumerate(frames)]
    Path("b.pvd").write_text(text.replace("  </Collection>", "\n".join([*more, "  </Collection>"])))
    assert compare_files("a.pvd", "b.pvd").same


# -- tables, documents, matrices ---------------------------------------------------------------------------------


def test_tables():
    """Columns by name in any order; whole numbers exact, NaN equal, texts equal; missing columns named."""
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
    """What is different in the report with changes at paths: name and note or values."""
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
    """Values by path, numbers by tolerance, all else equal; what differs from run to run is left out."""
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
    """With ``everything`` also what differs from run to run, less what is ignored by name."""
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
    """By its own name, by its path, by what it is inside of; brackets stand for themselves."""
    one, other = ({"a": {"u": x}, "b": [{"u": x}, {"u": x}], "c": 1} for x in (1.0, 2.0))
    findings = compare_documents(one, other, DEFAULT, Ignored(patterns))
    assert [f.name for f in findings if not f.same] == left


@pytest.mark.parametrize("operator", [stiffness, complex_connection_stiffness])
def test_matrices(operator):
    """In both formats equal to the bit; a planted entry by row and column; entries not stored are zero."""
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
    """An explicit zero is one that is not stored; a NaN is not."""
    plain = sp.coo_array(([1.0], ([0], [1])), shape=(2, 3))
    stored = sp.coo_array(([1.0, 0.0], ([0, 1], [1, 2])), shape=(2, 3))
    assert compare_sparse("S", plain, stored, Tolerance(0.0)).note == "1 entries in A, 2 in B"
    assert compare_sparse("S", plain, stored, Tolerance(0.0)).same
    broken = sp.coo_array(([1.0, np.nan], ([0, 1], [1, 2])), shape=(2, 3))
    assert compare_sparse("S", plain, broken, DEFAULT).index == (1, 2)


def test_numpy_files():
    """.npy and .npz with named arrays, text among them."""
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


# -- the command -------------------------------------------------------------------------------------------------


def test_exit_codes_and_lines():
    """0 and 1, a line for each array with verdict, place, name, size and the worst deviation; -q says nothing."""
    result = arrays_on(BALL)
    write(result, "a.vtp")
    write(planted(result, "wind", (9, 2), 5.0), "b.vtp")
    answer = run("compare", "a.vtp", "a.vtp")
    assert (answer.exit_code, answer.stdout.splitlines()[-1]) == (0, "same: 6 compared")
    answer = run("compare", "a.vtp", "b.vtp")
    assert answer.exit_code == 1
    (line,) = [line for line in answer.stdout.splitlines() if "wind" in line]
    assert line.split()[:6] == ["different", "vertex", "wind", "162", "x", "3"]
    before = float(np.asarray(result["wind"])[9, 2])
    assert f"at [9, 2]: {before!r} in A, 5.0 in B" in line
    assert answer.stdout.splitlines()[-1] == "different: 1 of 6 differ"
    assert (run("compare", "a.vtp", "b.vtp", "-q").exit_code, run("compare", "a.vtp", "b.vtp", "-q").output) == (1, "")
    assert run("compare", "a.vtp", "b.vtp", "--ignore", "wind").exit_code == 0
    assert run("compare", "a.vtp", "b.vtp", "--atol", "10").exit_code == 0
    assert run("compare", "a.vtp", "b.vtp", "--rtol", "1e-3").exit_code == 1


def test_report():
    """--json: files, tolerances, and each finding with plain values, whatever is not finite in words."""
    result = arrays_on(BALL)
    write(result, "a.vtp")
    write(planted(result, "reach", (0,), 1.0), "b.vtp")
    answer = run("compare", "a.vtp", "b.vtp", "--rtol", "1e-8", "--ignore", "gale", "--json")
    report = json.loads(answer.stdout)
    assert answer.exit_code == 1
    assert (report["command"], report["kind"], report["same"]) == ("compare", "mesh", False)
    assert (report["a"], report["rtol"], report["ignore"]) == ({"path": "a.vtp"}, 1e-8, ["gale"])
    assert [f["name"] for f in report["findings"]] == ["positions", "faces", "reach", "wind", "label"]
    found = report["findings"][2]
    assert (found["same"], found["index"], found["values"], found["absolute"]) == (False, [0], ["inf", 1.0], "inf")
    assert json.loads(run("compare", "a.vtp", "a.vtp", "--json").stdout)["same"] is True


def test_complex_values_in_a_report():
    """As pairs."""
    np.save("a.npy", np.array([1 + 2j]))
    np.save("b.npy", np.array([1 + 3j]))
    report = json.loads(run("compare", "a.npy", "b.npy", "--json").stdout)
    assert report["findings"][0]["values"] == [[1, 2], [1, 3]]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["a.off", "none.off"], "none.off: there is no such file"),
        (["none.off", "a.off"], "none.off: there is no such file"),
        (["none.csv", "a.csv"], "none.csv: there is no such file"),
        (["none.pvd", "a.pvd"], "none.pvd: there is no such file"),
        (["a.pvd", "lost.pvd"], "gone.vtp: there is no such file"),
        (["a.pvd", "empty.pvd"], "empty.pvd is a series without frames"),
        (["a.off", "a.csv"], "a.off (mesh) and a.csv (table) cannot be compared"),
        (["a.xyz", "a.off"], "'.xyz' is not compared"),
        (["bad.json", "a.json"], "bad.json cannot be read as JSON"),
        (["bad.csv", "a.csv"], "row 0 has 1 cells where the header has 2"),
        (["twice.csv", "a.csv"], "two columns 'u'"),
        (["blank.csv", "a.csv"], "no line with the names"),
        (["bad.npz", "bad.npz"], "bad.npz cannot be read as a numpy file"),
        (["bad.mtx", "bad.mtx"], "bad.mtx cannot be read as Matrix Market"),
        (["bad.png", "bad.png"], "bad.png cannot be read as a picture: it is no PNG"),
        (["a.off", "a.off", "--rtol", "-1"], "rtol is -1"),
        (["a.off", "a.off", "--rtol", "nan"], "rtol is nan"),
        (["a.off", "a.off", "--rtol", "much"], "not a valid float"),
        (["a.off", "a.off", "--ignore", "*"], "nothing is compared"),
        (["a.off", "a.off", "--diff", "d.png"], "--diff is for pictures"),
        (["a.off"], "Missing argument"),
        (["folder.csv", "a.csv"], "folder.csv cannot be read: it is a folder"),
    ],
)
def test_trouble_is_not_a_difference(arguments, words, folder):
    """What cannot be compared is exit code 2 and one sentence, never 1, and nothing on stdout."""
    save_off(icosphere(0), "a.off")
    write(Result(icosphere(0)), "a.00000.vtp")
    pvd = "<VTKFile><Collection>{}</Collection></VTKFile>"
    Path("a.pvd").write_text(pvd.format('<DataSet timestep="0" part="0" file="a.00000.vtp"/>'))
    Path("lost.pvd").write_text(pvd.format('<DataSet timestep="0" part="0" file="gone.vtp"/>'))
    Path("empty.pvd").write_text(pvd.format(""))
    Path("a.csv").write_text("u,v\n1,2\n")
    Path("a.json").write_text("{}")
    Path("bad.json").write_text("{")
    Path("bad.csv").write_text("u,v\n1\n")
    Path("twice.csv").write_text("u,u\n1,2\n")
    Path("blank.csv").write_text("\n\n")
    for name in ("bad.npz", "bad.mtx", "bad.png", "a.xyz"):
        Path(name).write_text("rubbish")
    Path("folder.csv").mkdir()
    answer = run("compare", *arguments)
    assert answer.exit_code == 2
    assert answer.stdout == ""
    assert words in answer.stderr
    assert len([line for line in answer.stderr.splitlines() if line.startswith("Error")]) == 1


def test_trouble_says_which_file():
    """Of two files of one name, the folder tells them apart."""
    for where in "ab":
        Path(where).mkdir()
        save_off(BALL, f"{where}/m.off")
        Path(where, "m.json").write_text("{}")
        Path(where, "m.csv").write_text("u\n1\n")
    Path("b/m.off").write_text("rubbish")
    Path("b/m.json").write_text("rubbish {")
    Path("b/m.csv").write_text("u,u\n1,2\n")
    for name in ("m.off", "m.json", "m.csv"):
        answer = run("compare", f"a/{name}", f"b/{name}")
        assert answer.exit_code == 2
        assert f"b/{name}" in answer.stderr
        assert f"a/{name}" not in answer.stderr


def test_other_commands_still_fail_with_one():
    """Only of compare is trouble 2."""
    assert run("info", "none.off").exit_code == 1


def test_same_bytes_elsewhere(folder):
    """Files of equal names in two folders, as CI has them."""
    (folder / "golden").mkdir()
    write(arrays_on(BALL), "m.vtk")
    shutil.copy("m.vtk", "golden/m.vtk")
    assert run("compare", "golden/m.vtk", "m.vtk").exit_code == 0
