"""Damaged OFF files are refused with the line and the reason."""

import pytest

from geomhw.errors import FormatError
from geomhw.io import read
from geomhw.mesh.primitives import icosphere
from support.number_texts import as_text
from support.off_files import load

VERTICES = "0 0 0\n1 0 0\n0 1 0\n"
WRONG = {
    "": ["empty"],
    " \n# nothing\n": ["nothing but blank lines"],
    "PLY\n3 1 0\n": ["line 1", "'PLY'"],
    "4OFF\n3 1 0\n": ["line 1", "4OFF", "dimension"],
    "nOFF\n5\n3 1 0\n": ["line 1", "nOFF", "dimension 5"],
    "# a\nnOFF\n": ["line 2", "nOFF", "dimension"],
    "nOFF # b\n3\n3 1 0\n": ["ends after 0 of 3 vertices"],
    "OFF BINARY\n3 1 0\n": ["ends inside its header"],
    "OFF\n": ["ends after its header"],
    "OFF\n3\n" + VERTICES: ["line 2", "numbers of vertices", "'3'"],
    "OFF\n3 1.5 0\n" + VERTICES: ["line 2", "3 1.5 0"],
    "OFF\n3 one 0\n" + VERTICES: ["line 2", "3 one 0"],
    "OFF\n3 -1 0\n" + VERTICES: ["line 2", "negative"],
    "OFF\n0 0 0\n": ["line 2", "0 vertices and 0 faces"],
    "OFF\n5 1 0\n" + VERTICES: ["ends after 3 of 5 vertices"],
    "OFF\n3 4 0\n" + VERTICES + "3 0 1 2\n": ["ends after 1 of 4 faces"],
    "OFF\n999999999999999 4 0\n" + VERTICES: ["ends after 3 of 999999999999999 vertices"],
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
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 1\n": ["line 6", "three different corners"],
    "OFF\n3 1 0\n" + VERTICES + "2 0 1\n": ["line 6", "three different corners"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1\n": ["line 6", "says 3 corners, but 2 follow"],
    "OFF\n3 1 0\n" + VERTICES + "9223372036854775807 0 1 2\n": ["line 6", "but 3 follow"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 1.5\n": ["line 6", "'1.5' is not a whole number"],
    "OFF\n3 1 0\n" + VERTICES + "3 0 1 x\n": ["line 6", "'x' is not a number"],
    "OFF\n3 1 0\n0 0 0\n1\x020 0\n0 1 0\n3 0 1 2\n": ["line 4", "control character"],
    "OFF\n3 1 0\n0 0 \0 0\n": ["zero byte"],
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text):
    """The message has the file, the line and the reason."""
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, text))
    for part in ["moo.off", *WRONG[text]]:
        assert part in str(caught.value)


SPHERE = as_text(icosphere(3), "off")
FAULTS = {
    "face out of range": ("\n3 162 ", "\n3 642 ", "face names vertex 642, but there are 642"),
    "a count that is greater": ("\n642 1280 0\n", "\n642 1281 0\n", "ends after 1280 of 1281 faces"),
    "no number": ("\n3 0 162 164\n", "\n3 0 16_2 164\n", "'16_2' is not a number"),
    "a bracket": ("\n3 0 162 164\n", "\n3 0 [162] 164\n", "'[162]' is not a number"),
    "a comma": ("\n3 0 162 164\n", "\n3 0,162 164\n", "'0,162' is not a number"),
    "a polygon of four in a line of three": ("\n3 638 641 159\n", "\n4 638 641 159\n", "says 4 corners, but 3 follow"),
    "too few": ("\n3 0 162 164\n", "\n3 0 162\n", "says 3 corners, but 2 follow"),
    "an index of more than four bytes": ("\n3 0 162 164\n", "\n3 0 162 4294967460\n", "vertex 4294967460"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_in_a_large_file_are_named(tmp_path, fault):
    """The line, and what is wrong there."""
    before, after, sentence = FAULTS[fault]
    assert before in SPHERE
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, SPHERE.replace(before, after)))
    assert sentence in str(caught.value)
