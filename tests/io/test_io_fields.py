"""Fields from files: where they belong, and why one is refused."""

import numpy as np
import pytest

from geomhw.io import read_field, write
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

# 4 vertices and 2 faces; and 3 of each.
MESH = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
EVEN = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2], [0, 2, 1], [1, 0, 2]])
U, W = np.array([0.5, 1, 2, 3]), np.array([[1.0, 2, 3], [4, 5, 6]])


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fields = [Field("u", "vertex", U), Field("w", "face", W), Field("a:b", "vertex", U + 1), Field("dt", "mesh", U)]
    for name in ["moo.vtp", "moo.vtu", "moo.vtk", "moo.ply"]:
        write(Result(MESH, fields), name)
    np.save("u.npy", U)
    np.savez("all.npz", u=U, w=W, flag=np.array([True, False]), half=np.arange(4, dtype=np.float16))
    rows = "\n".join(f"{a},{b},{c},{d}" for a, (b, c, d) in zip(U, np.arange(12).reshape(4, 3), strict=True))
    (tmp_path / "t.csv").write_text(f'u,x, y ,"z"\n{rows}\n')
    return tmp_path


@pytest.mark.parametrize(
    ("spec", "name", "location", "values"),
    [
        *((f"moo.{ext}:u", "u", "vertex", U) for ext in ("vtp", "vtu", "vtk", "ply")),
        *((f"moo.{ext}:w", "w", "face", W) for ext in ("vtp", "vtu", "vtk", "ply")),
        ("moo.vtp:a:b", "a:b", "vertex", U + 1),
        ("./moo.vtp:u", "u", "vertex", U),
        ("u.npy", "u", "vertex", U),
        ("all.npz:u", "u", "vertex", U),
        ("all.npz:w", "w", "face", W),
        ("all.npz:flag", "flag", "face", [1, 0]),
        ("all.npz:half", "half", "vertex", [0, 1, 2, 3]),
        ("t.csv:u", "u", "vertex", U),
        ("t.csv:x,y,z", "x,y,z", "vertex", np.arange(12).reshape(4, 3)),
        ("t.csv:z, x", "z, x", "vertex", np.arange(12).reshape(4, 3)[:, [2, 0]]),
    ],
)
def test_where_fields_come_from(here, spec, name, location, values):
    field = read_field(spec, MESH)
    assert (field.name, field.location) == (name, location)
    np.testing.assert_array_equal(field.values, values)


def test_a_colon_in_the_path(here):
    (here / "c:").mkdir()
    np.savez("c:/all.npz", u=U)
    assert read_field("c:/all.npz:u", MESH).location == "vertex"
    np.savez("all.npz:w.npz", u=W)
    assert read_field("all.npz:w.npz:u", MESH).location == "face"
    np.save("one:two.npy", U)
    assert read_field("one:two.npy", MESH).name == "one:two"


@pytest.mark.parametrize(("stored", "expected"), [("vertex", "vertex"), ("face", "face"), (None, "face")])
def test_as_many_vertices_as_faces(here, stored, expected):
    values = np.arange(3.0)
    np.save("even.npy", values)
    if stored:
        write(Result(EVEN, [Field("u", stored, values)]), "even.vtp")
    assert read_field("even.vtp:u" if stored else "even.npy", EVEN).location == expected


def test_of_two_arrays_of_a_name_the_one_that_fits(here):
    write(Result(MESH, [Field("u", "vertex", U), Field("u", "face", U[:2])]), "both.vtp")
    assert read_field("both.vtp:u", MESH).location == "vertex"
    only_faces = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]], MESH.faces)
    assert read_field("both.vtp:u", only_faces).location == "face"
