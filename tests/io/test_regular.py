"""Numbers one blank apart: read as a JSON array to the same bits as any other way, or left to the other ways."""

import re
import sys

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from geomhw.errors import FormatError
from geomhw.io import read
from geomhw.io.formats import decimal_parser, off_read, uniform_lines
from geomhw.io.formats.uniform_lines import parse_lines, parse_regular
from geomhw.mesh.primitives import icosphere
from support.messages import missing
from support.number_texts import FIXED, FLOATS, WRITTEN, as_text, bits
from support.off_files import BODY, SAME, load
from support.reference import needs_reference, reference

if sys.version_info >= (3, 14):  # before, it is required
    pytest.importorskip("simdjson")
SPHERE = as_text(icosphere(3), "off")
ENDS = {"newline": "\n", "blank": " \n", "blanks": "     \n", "carriage return": "\r\n", "both": " \r\n"}


@settings(max_examples=300, deadline=None)
@given(st.lists(WRITTEN | FLOATS | FIXED, min_size=1, max_size=40), st.sampled_from([" ", "\n", "\t ", " \t"]))
@example(["-0", "1"], " ")
@example(["0.5", "-0"], " ")
@example(["-0", "1"], "\t ")
@example(["-0.0", "0.25", "1e5", "1e+5", "1E-5"], "\n")
@example(["4503599627370497.5", "4503599627370496.5", "9007199254740993.0", "9223372036854775807"], " ")
def test_taken_numbers_are_the_nearest_doubles(tokens: list[str], gap: str) -> None:
    values = parse_regular(gap.join(tokens).encode(), np.float64)
    assert values is None or values.tobytes() == bits(tokens)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[FLOATS] * 3), min_size=3, max_size=60), st.sampled_from([64, 1 << 16]))
@example([("-0.0", "-0", "0"), ("1", "0.5", "2"), ("3", "4", "5")], 64)
def test_both_ways_read_the_same_bits(points: list[tuple[str, ...]], block: int) -> None:
    """The short way, of blocks of lines and of one, and the general one."""
    n = len(points)
    faces = "".join(f"3 {i} {(i + 1) % n} {(i + 2) % n}\n" for i in range(n))
    text = f"OFF\n{n} {n} 0\n" + "".join(" ".join(point) + "\n" for point in points) + faces
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(uniform_lines, "BLOCK", block)
        short = off_read._regular(text.encode())
    general = off_read._general("moo.off", text.encode())
    assert (short is None) == any(token == "-0" for point in points for token in point)
    if short is not None:
        assert short.points.tobytes() == general.points.tobytes()
        np.testing.assert_array_equal(short.corners, general.corners)
        np.testing.assert_array_equal(short.sizes, general.sizes)


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("head", ["OFF\n", "COFF # of four\n# and more\n\n", "OFF", "OFF "])
def test_files_that_programs_write_go_the_short_way(monkeypatch, tmp_path, head, end):
    """Line ends of any program, comments in the header, no newline at the end, extra numbers in all lines alike."""
    monkeypatch.delattr(off_read, "_general")
    mesh = icosphere(3)
    for text in (SPHERE, SPHERE + "\n\n", re.sub("(?m)^(3 .*)$", r"\1 255 0 0", SPHERE)):
        path = load(tmp_path, text.replace("OFF\n", head).replace("\n", ENDS[end]))
        found = read(path).mesh
        assert found.vertices.tobytes() == mesh.vertices.tobytes()
        np.testing.assert_array_equal(found.faces, mesh.faces)


@pytest.mark.parametrize("corner", ["{0}", "{0}//{0}", "{0}/{0}/{0}"])
def test_regular_obj_files_are_read_as_arrays_too(monkeypatch, tmp_path, corner):
    """Words at the start of lines and two slashes in a row stand in nobody's way."""
    for slower in ("_decimals", "_by_numpy"):
        monkeypatch.delattr(decimal_parser, slower)
    mesh = icosphere(2)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += ["f " + " ".join(corner.format(i + 1) for i in face) for face in mesh.faces.tolist()]
    found = read(load(tmp_path, "\n".join(lines), "moo.obj")).mesh
    assert found.vertices.tobytes() == mesh.vertices.tobytes()
    np.testing.assert_array_equal(found.faces, mesh.faces)


@needs_reference
def test_a_reference_mesh_is_the_same_both_ways():
    data = reference("meshes/closed/moomoo.off").read_bytes()
    short, general = off_read._regular(data), off_read._general("moomoo.off", data)
    assert short is not None
    assert short.points.tobytes() == general.points.tobytes()
    np.testing.assert_array_equal(short.corners, general.corners)


@pytest.mark.parametrize("dialect", SAME)
def test_without_simdjson_all_is_the_same(monkeypatch, tmp_path, dialect):
    path = load(tmp_path, SAME[dialect])
    with_it = read(path)
    monkeypatch.setattr(uniform_lines, "_parser", lambda: None)
    without = read(path)
    assert with_it.mesh.vertices.tobytes() == without.mesh.vertices.tobytes()
    np.testing.assert_array_equal(with_it.mesh.faces, without.mesh.faces)
    assert with_it.report == without.report


FAULTS = {
    "face out of range": ("\n3 162 ", "\n3 642 ", "vertex 642 ... 642"),
    "a vertex twice": ("\n3 0 162 164\n", "\n3 0 164 164\n", "vertex 164 twice"),
    "a count that is greater": ("\n642 1280 0\n", "\n642 1281 0\n", "1280 of 1281 faces"),
    "one that is smaller": ("\n642 1280 0\n", "\n642 1279 0\n", "line 1924 ... goes on"),
    "no number": ("\n3 0 162 164\n", "\n3 0 16_2 164\n", "'16_2' is not a number"),
    "a bracket": ("\n3 0 162 164\n", "\n3 0 [162] 164\n", "'[162]' is not a number"),
    "a comma": ("\n3 0 162 164\n", "\n3 0,162 164\n", "'0,162' is not a number"),
    "a polygon of four in a line of three": ("\n3 638 641 159\n", "\n4 638 641 159\n", "4 corners ... 3 follow"),
    "too few": ("\n3 0 162 164\n", "\n3 0 162\n", "3 corners ... 2 follow"),
    "an index of more than four bytes": ("\n3 0 162 164\n", "\n3 0 162 4294967460\n", "vertex 4294967460"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_regular_files_are_told_by_the_general_way(tmp_path, fault):
    before, after, keywords = FAULTS[fault]
    assert before in SPHERE
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, SPHERE.replace(before, after)))
    assert not missing(str(caught.value), keywords)


@pytest.mark.parametrize(
    "text", ["[1] 2", "1,2", "1 [] 2", "1  2", "1 2\n\n3", '"1" 2', "1 true", "{} 1", "1] [2", "1\r2", "+1", "1 \0", ""]
)
def test_what_json_would_take_or_mend_is_not_taken(text: str) -> None:
    values = parse_regular(text.encode(), np.float64)
    assert values is None or not (len(values) or text)


UNLIKE = ["1 2\n3\n", "1\n2 3\n", "1 2\n\n3 4\n", " 1 2\n3 4\n", "1 2\n3 4 #\n", "1 2\n3\t4\n", "1 2\r3\n", "\n"]


@pytest.mark.parametrize("text", [*UNLIKE, "2\r\n", "2\r\n \n"])
def test_lines_that_differ_are_not_taken(text: str) -> None:
    assert parse_lines(text.encode(), 0, 2, whole=True) is None


def test_counts_that_lie_take_no_memory() -> None:
    assert parse_lines(b"1 2 3\n" * 10, 0, 10**17) is None
    assert off_read._regular(b"OFF\n99999999999999999 99999999999999999 0\n" + BODY.encode()) is None


def test_long_lines_are_left_to_others() -> None:
    """The parser keeps many times the size of a text."""
    assert parse_regular(b"1 " * 200_000, np.float64) is None
    assert parse_lines(b"1 " * 200_000, 0, 1) is None
