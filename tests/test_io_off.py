"""OFF files: every dialect that is read gives the same square; everything else says what is wrong and where."""

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import needs_reference, reference
from hypothesis import given, settings
from hypothesis import strategies as st
from test_numerals import as_text

from geomhw.errors import FormatError
from geomhw.io import read, read_mesh
from geomhw.mesh.primitives import icosphere

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
BODY = "0 0 0\n1 0 0\n1 1 0\n0 1 5e-1\n3 0 1 2\n3 0 2 3\n"

SAME = {
    "plain": "OFF\n4 2 0\n" + BODY,
    "no keyword": "4 2 0\n" + BODY,
    "lower case": "off\n4 2 0\n" + BODY,
    "counts behind the keyword": "OFF 4 2 0\n" + BODY,
    "counts glued to the keyword": "OFF4 2 0\n" + BODY,
    "two counts": "OFF\n4 2\n" + BODY,
    "comments and blank lines": "# a\nOFF # b\n\n4 2 0#c # d\n\n" + BODY.replace("\n", " # 7 8 9\n\n") + "# end",
    "carriage returns": ("OFF\n4 2 0\n" + BODY).replace("\n", "\r\n"),
    "old Macintosh": ("OFF\n4 2 0\n" + BODY).replace("\n", "\r"),
    "byte-order mark": "\ufeffOFF\n4 2 0\n" + BODY,
    "tabs and indents": ("OFF\n4 2 0\n" + BODY).replace(" ", "\t  ").replace("\n", "\n\t"),
    "no last newline": ("OFF\n4 2 0\n" + BODY).rstrip(),
    "colors on vertices": "COFF\n4 2 0\n" + BODY.replace("0\n1", "0 255 0 0 255\n1", 1),
    "extra numbers under OFF": "OFF\n4 2 0\n0 0 0 .1 .2\n1 0 0 9\n" + BODY[12:],
    "normals and texture": "STCNOFF\n4 2 0\n0 0 0 0 0 1 1 1 1 1 .5 .5\n" + BODY[6:],
    "colors on faces": "OFF\n4 2 0\n" + BODY.replace("3 0 1 2", "3 0 1 2 0.25 0.5 0.75"),
    "quad": "OFF\n4 1 0\n" + BODY[: BODY.index("3 0 1 2")] + "4 0 1 2 3\n",
}


def load(tmp_path: Path, text: str, name: str = "moo.off") -> Path:
    path = tmp_path / name
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("dialect", SAME)
def test_dialects_give_the_same_mesh(tmp_path, dialect):
    result = read(load(tmp_path, SAME[dialect]))
    np.testing.assert_array_equal(result.mesh.vertices, SQUARE)
    np.testing.assert_array_equal(result.mesh.faces, [[0, 1, 2], [0, 2, 3]])
    quad = {"polygons": 1} if dialect == "quad" else {}
    assert result.report == {"file": "moo.off", "format": "OFF", **quad}


def test_polygons_become_fans_in_file_order(tmp_path):
    vertices = "".join(f"{i} {i * i} 0\n" for i in range(6))
    result = read(load(tmp_path, f"OFF\n6 3 0\n{vertices}3 0 1 2\n5 5 4 3 2 1 128 0 0\n4 2 3 4 5\n"))
    expected = [[0, 1, 2], [5, 4, 3], [5, 3, 2], [5, 2, 1], [2, 3, 4], [2, 4, 5]]
    assert result.mesh.faces.tolist() == expected
    assert result.report["polygons"] == 2


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=3, max_size=20))
def test_coordinates_come_back_to_the_bit(tmp_path_factory, points):
    rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
    path = load(tmp_path_factory.mktemp("off"), f"OFF\n{len(points)} 1 0\n{rows}3 0 1 2\n")
    assert read_mesh(path).vertices.tobytes() == np.array(points).tobytes()


VERTICES = "0 0 0\n1 0 0\n0 1 0\n"
WRONG = {
    "": ["empty"],
    " \n# nothing\n": ["nothing but blank lines"],
    "PLY\n3 1 0\n": ["line 1", "'PLY'"],
    "4OFF\n3 1 0\n": ["line 1", "4OFF", "dimension"],
    "nOFF\n3\n3 1 0\n": ["line 1", "nOFF", "dimension"],
    "OFF BINARY\n3 1 0\n": ["line 1", "binary"],
    "OFF\n": ["ends after its header"],
    "OFF\n3\n" + VERTICES: ["line 2", "numbers of vertices", "'3'"],
    "OFF\n3 1.5 0\n" + VERTICES: ["line 2", "3 1.5 0"],
    "OFF\n3 one 0\n" + VERTICES: ["line 2", "3 one 0"],
    "OFF\n3 -1 0\n" + VERTICES: ["line 2", "negative"],
    "OFF\n0 0 0\n": ["line 2", "0 vertices and 0 faces"],
    "OFF\n5 1 0\n" + VERTICES: ["ends after 3 of 5 vertices"],
    "OFF\n3 4 0\n" + VERTICES + "3 0 1 2\n": ["ends after 1 of 4 faces"],
    "OFF\n999999999999999 4 0\n" + VERTICES: ["ends after 3 of 999999999999999 vertices"],
    "OFF\n\n3 1 0\n" + VERTICES + "3 0 1 2\n\n3 0 2 1\n": ["line 9", "goes on", "3 vertices"],
    "OFF\n3 1 0\r\n0 0 0\r\n1 abc 0\r\n0 1 0\r\n3 0 1 2\r\n": ["line 4", "'abc' is not a number"],
    "OFF\n3 1 0\n0 0 0 # fine\n1 1_0 0\n0 1 0\n3 0 1 2\n": ["line 4", "'1_0' is not a number"],
    "OFF\n3 1 0\n0 0 0\n1 2-3 0\n0 1 0\n3 0 1 2\n": ["line 4", "'2-3' is not a number"],
    "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n": ["line 4", "3 coordinates, not 2"],
    "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n": ["line 4", "not a finite number", "nan"],
    "OFF\n3 1 0\n0 0 0\n1 1e999 0\n0 1 0\n3 0 1 2\n": ["line 4", "not a finite number", "inf"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 99\n": ["line 6", "vertex 99", "there are 3 (0 to 2)"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 -1\n": ["line 6", "vertex -1", "there are 3"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 - 2\n": ["line 6", "'-' is not a number"],
    "OFF\n3 1 0\n" + VERTICES + "3 0-1 - 2\n": ["line 6", "'0-1' is not a number"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 1\n": ["line 6", "vertex 1 twice"],
    "OFF\n3 1 0\n" + VERTICES + "4 0 1 2 1\n": ["line 6", "vertex 1 twice"],
    "OFF\n3 1 0\n" + VERTICES + "2 0 1\n": ["line 6", "at least 3 corners, not 2"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1\n": ["line 6", "says 3 corners, but 2 follow"],
    "OFF\n3 1 0\n" + VERTICES + "9223372036854775807 0 1 2\n": ["line 6", "but 3 follow"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 1.5\n": ["line 6", "'1.5' is not a whole number"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 x\n": ["line 6", "'x' is not a number"],
    "OFF\n3 1 0\n0 0 \0 0\n": ["zero byte"],
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text):
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, text))
    for part in ["moo.off", *WRONG[text]]:
        assert part in str(caught.value)


@needs_reference
@pytest.mark.parametrize(
    ("name", "n", "m"), [("closed/moomoo.off", 1045, 2086), ("hostile/camelhead.off", 11381, 22704)]
)
def test_reference_meshes(name, n, m):
    mesh = read_mesh(reference(f"meshes/{name}"))
    assert (mesh.n_vertices, mesh.n_faces) == (n, m)


SPHERE = as_text(icosphere(3), "off")
ENDS = {"newline": "\n", "blank": " \n", "blanks": "     \n", "carriage return": "\r\n", "both": " \r\n"}


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("head", ["OFF\n", "COFF # of four\n# and more\n\n", "OFF", "OFF "])
def test_files_as_programs_write_them(tmp_path, head, end):
    """Line ends of any program, comments in the header, no newline at the end, extra numbers in all lines alike."""
    mesh = icosphere(3)
    for text in (SPHERE, SPHERE + "\n\n", re.sub("(?m)^(3 .*)$", r"\1 255 0 0", SPHERE)):
        found = read(load(tmp_path, text.replace("OFF\n", head).replace("\n", ENDS[end]))).mesh
        assert found.vertices.tobytes() == mesh.vertices.tobytes()
        np.testing.assert_array_equal(found.faces, mesh.faces)


FAULTS = {
    "face out of range": ("\n3 162 ", "\n3 642 ", "face names vertex 642, but there are 642"),
    "a vertex twice": ("\n3 0 162 164\n", "\n3 0 164 164\n", "face names vertex 164 twice"),
    "a count that is greater": ("\n642 1280 0\n", "\n642 1281 0\n", "ends after 1280 of 1281 faces"),
    "one that is smaller": ("\n642 1280 0\n", "\n642 1279 0\n", "line 1924: the file goes on"),
    "no number": ("\n3 0 162 164\n", "\n3 0 16_2 164\n", "'16_2' is not a number"),
    "a bracket": ("\n3 0 162 164\n", "\n3 0 [162] 164\n", "'[162]' is not a number"),
    "a comma": ("\n3 0 162 164\n", "\n3 0,162 164\n", "'0,162' is not a number"),
    "a polygon of four in a line of three": ("\n3 638 641 159\n", "\n4 638 641 159\n", "says 4 corners, but 3 follow"),
    "too few": ("\n3 0 162 164\n", "\n3 0 162\n", "says 3 corners, but 2 follow"),
    "an index of more than four bytes": ("\n3 0 162 164\n", "\n3 0 162 4294967460\n", "vertex 4294967460"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_in_a_large_file_are_named(tmp_path, fault):
    before, after, sentence = FAULTS[fault]
    assert before in SPHERE
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, SPHERE.replace(before, after)))
    assert sentence in str(caught.value)
