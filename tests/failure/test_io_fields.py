"""Fields from files: missing, of the wrong size, or without numbers."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import FieldError
from geomhw.io import read_field
from support.field_files import EVEN, MESH, U, save_fields
from support.messages import missing


@pytest.fixture(autouse=True)
def here(folder: Path) -> Path:
    """Each test has its own working folder with field files of every format."""
    save_fields()
    return folder


def refused(spec, mesh=MESH) -> str:
    with pytest.raises(FieldError) as caught:
        read_field(spec, mesh)
    return str(caught.value)


def test_files_and_names_that_are_not_there(here):
    """Missing files, folders and arrays are named, with the arrays that exist."""
    (here / "folder.npz").mkdir()
    assert not missing(refused("none.vtp:u"), "none.vtp ... no such file ... field 'none.vtp:u'")
    assert not missing(refused("none.npy"), "none.npy ... no such file")
    assert not missing(refused("folder.npz:u"), "folder.npz ... it is a folder")
    assert not missing(refused("moo.vtp:heat"), "moo.vtp has no array 'heat' ... u, a:b, w")
    assert not missing(refused("moo.vtp"), "say which array ... 'moo.vtp:NAME' ... u, a:b, w")
    assert "has no array 'dt'" in refused("moo.vtp:dt")
    assert not missing(refused("all.npz:v"), "all.npz has no array 'v' ... u, w, flag, half")
    assert "say which array" in refused("all.npz")
    assert not missing(refused("t.csv:v"), "t.csv has no array 'v' ... u, x, y, z")
    assert "say which array" in refused("t.csv")
    assert "say which array" in refused("t.csv:x,")
    assert "leave ':u' away" in refused("u.npy:u")
    (here / "bare.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert not missing(refused("bare.off:u"), "bare.off has no array 'u' ... none")
    (here / "notes.txt").touch()
    assert not missing(refused("notes.txt:u"), "'.txt' ... known are .npy .npz .csv .off")


def test_wrong_numbers_of_rows(here):
    """Arrays with a number of rows or a shape that fits neither vertices nor faces are refused."""
    assert not missing(refused("u.npy", EVEN), "u.npy has 4 rows ... 3 vertices ... 3 faces")
    (here / "short.csv").write_text("u\n")
    assert "short.csv:u has 0 rows" in refused("short.csv:u")
    np.save("deep.npy", np.zeros((4, 2, 2)))
    np.save("point.npy", np.array(3.0))
    np.save("none.npy", np.zeros((4, 0)))
    for name in ["deep", "point", "none"]:
        assert "an array of shape" in refused(f"{name}.npy")


def test_values_that_are_no_numbers(here):
    """NaN, infinity, text, complex numbers and objects are refused, with the row."""
    np.save("nan.npy", np.array([[0, 1.0], [2, 3], [4, np.nan], [np.nan, 1]]))
    np.save("inf.npy", np.array([0, -np.inf, 0, 0]))
    np.save("text.npy", np.array(["a", "b", "c", "d"]))
    np.save("complex.npy", U * 1j)
    np.save("object.npy", np.array([None] * 4))
    assert not missing(refused("nan.npy"), "nan.npy: row 2 ... finite ... (4.0 nan)")
    assert not missing(refused("inf.npy"), "inf.npy: row 1 ... finite ... (-inf)")
    assert "not of real numbers" in refused("text.npy")
    assert "complex128, not of real numbers" in refused("complex.npy")
    assert not missing(refused("object.npy"), "object.npy ... numpy file")  # a pickle is not opened


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("u,v\n1,2\n3,abc\n", "row 1 ... 'v' ... 'abc' ... not a number"),
        ("u,v\n1,2\n3,\n", "row 1 ... 'v' ... '' ... not a number"),
        ("u,v\n1,2\n3\n", "row 1 ends ... 'v'"),
        ("u,v\n1,2\n3,nan\n", "row 1 ... finite ... (nan)"),
        ("", "it holds none"),
    ],
)
def test_tables_with_holes(here, text, part):
    """Tables with text, gaps or NaN in a column are refused, with row and column."""
    (here / "bad.csv").write_text(text)
    assert not missing(refused("bad.csv:v"), part)


def test_files_that_are_not_what_they_say(here):
    """Files of a wrong type under a known extension are refused."""
    for name in ["x.npy", "x.npz"]:
        (here / name).write_bytes(b"rubbish")
        assert not missing(refused(f"{name}:u" if name == "x.npz" else name), f"{name} ... numpy file")
    (here / "table.csv").write_bytes(b"\xff\xfe\x00")
    assert not missing(refused("table.csv:u"), "table.csv ... as a table")
    (here / "u.npy").rename(here / "single.npz")
    assert "not an archive" in refused("single.npz:u")
