"""Damaged PLY files, and field names that PLY cannot hold, are refused with the reason."""

import numpy as np
import pytest

from geomhw.errors import FieldError, FormatError
from geomhw.io import read, write
from geomhw.results import Field
from support.ply_files import BODIES, HEADER, load, result_with


@pytest.mark.parametrize("names", [("a_b_x", "a b"), ("x", "y"), ("v_z", "v")])
def test_names_that_would_clash_are_refused(tmp_path, names):
    """Field names that give the same PLY property are refused, and no file is written."""
    fields = [Field(names[0], "vertex", np.ones(5)), Field(names[1], "vertex", np.ones((5, 3)))]
    with pytest.raises(FieldError, match="in PLY; rename field"):
        write(result_with(*fields), tmp_path / "moo.ply")
    assert not list(tmp_path.iterdir())


def broken(form: str, change: tuple[str, str] = ("", ""), cut: int | None = None, extra: bytes = b"") -> bytes:
    return HEADER.format(form=form).replace(*change).encode() + BODIES.get(form, b"")[:cut] + extra


LITTLE = "binary_little_endian"
WRONG = {
    "no ply": (b"plx\n", ["line 1", "'ply'"]),
    "no end": (b"ply\nformat ascii 1.0\n", ["inside its header"]),
    "format": (broken("utf8"), ["'utf8'", "ascii"]),
    "header line": (broken("ascii", ("property float z", "property float128 z")), ["line 12", "float128"]),
    "count": (broken("ascii", ("vertex 5", "vertex -5")), ["line 11", "element vertex -5"]),
    "no x": (broken(LITTLE, ("double x", "double w")), ["missing: x"]),
    "no faces": (broken(LITTLE, ("vertex_indices", "corners")), ["no faces"]),
    "cut in the faces": (broken(LITTLE, cut=20), ["ends after 0 of 2 rows", "'face'"]),
    "cut before a length": (broken(LITTLE, cut=12), ["ends after 0 of 2 rows", "'face'"]),
    "cut in the vertices": (broken(LITTLE, cut=100), ["ends after 1 of 5 rows", "'vertex'"]),
    "cut text": (broken("ascii", cut=60), ["moo.ply", "ends after 1 of 5 rows", "'vertex'"]),
    "huge": (broken(LITTLE, ("face 2", "face 999999999999")), ["rows of element 'face'"]),
    "not a number": (broken("ascii").replace(b"0.25", b"zero"), ["line 22", "'zero'"]),
    "not whole": (broken("ascii").replace(b"3 0 1 2 7", b"3 0 1 1.5 7"), ["'vertex_indices'", "integer of 4 bytes"]),
    "list length": (broken("ascii").replace(b"3 0 1 2 7", b"-3 0 1 2 7"), ["face 0", "-3 is no length"]),
    "out of range": (broken("ascii").replace(b"3 0 1 2 7", b"3 0 1 9 7"), ["face 0", "vertex 9", "there are 5"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named(tmp_path, case):
    """The message has the file, the element or line, and the reason."""
    data, parts = WRONG[case]
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, data))
    for part in ["moo.ply", *parts]:
        assert part in str(caught.value)
