"""Fields from files: the file, the array, and whether it belongs to vertices or faces."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read_field, write
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result
from support.field_files import EVEN, MESH, U, W, save_fields


@pytest.fixture(autouse=True)
def here(folder: Path) -> Path:
    """Each test has its own working folder with field files of every format."""
    save_fields()
    return folder


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
    """Each spec gives the field with its name, location and values."""
    field = read_field(spec, MESH)
    assert (field.name, field.location) == (name, location)
    np.testing.assert_array_equal(field.values, values)


def test_a_colon_in_the_path(here):
    """Colons in paths and names are accepted."""
    (here / "c:").mkdir()
    np.savez("c:/all.npz", u=U)
    assert read_field("c:/all.npz:u", MESH).location == "vertex"
    np.savez("all.npz:w.npz", u=W)
    assert read_field("all.npz:w.npz:u", MESH).location == "face"
    np.save("one:two.npy", U)
    assert read_field("one:two.npy", MESH).name == "one:two"


@pytest.mark.parametrize(("stored", "expected"), [("vertex", "vertex"), ("face", "face"), (None, "face")])
def test_as_many_vertices_as_faces(here, stored, expected):
    """With as many vertices as faces, the stored location decides; plain arrays belong to faces."""
    values = np.arange(3.0)
    np.save("even.npy", values)
    if stored:
        write(Result(EVEN, [Field("u", stored, values)]), "even.vtp")
    assert read_field("even.vtp:u" if stored else "even.npy", EVEN).location == expected


def test_of_two_arrays_of_a_name_the_one_that_fits(here):
    """Of two arrays of one name, the one with a fitting length is read."""
    write(Result(MESH, [Field("u", "vertex", U), Field("u", "face", U[:2])]), "both.vtp")
    assert read_field("both.vtp:u", MESH).location == "vertex"
    only_faces = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]], MESH.faces)
    assert read_field("both.vtp:u", only_faces).location == "face"
