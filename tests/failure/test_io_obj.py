"""Damaged OBJ files are refused with the line and the reason."""

import pytest

from geomhw.errors import FormatError
from geomhw.io import read
from support.obj_files import V, load

WRONG = {
    "": ["empty"],
    "f 1 2 3\n": ["no vertices"],
    V: ["no faces"],
    "v 0 0\n" + V + "f 1 2 3\n": ["line 1", "3 coordinates, not 2"],
    V + "v\nf 1 2 3\n": ["line 5", "3 coordinates, not 0"],
    V + "v 0 inf 0\nf 1 2 5\n": ["line 5", "not a finite number"],
    V + "v 0 zero 0\nf 1 2 3\n": ["line 5", "'zero' is not a number"],
    V + "v 1/2 0 0 0\nf 1 2 3\n": ["line 5", "'1/2' is not a number"],
    V + "f 1 2\n": ["line 5", "three different corners"],
    V + "f\n": ["line 5", "three different corners"],
    V + "f 1 2 3\nf 0 1 2\n": ["line 6", "vertex 0", "counts from 1"],
    V + "\r\nf 1 2 9\n": ["line 6", "vertex 9", "there are 4 (1 to 4)"],
    V + "f 1 2 -5\n": ["line 5", "vertex -5", "only 4 come before"],
    "v 0 0 0\nv 1 0 0\nf -3 -2 -1\nv 0 1 0\nv 0 0 1\nf 1 2 3\n": ["line 3", "vertex -3", "only 2 come before"],
    V + "f 1 2 2\n": ["line 5", "three different corners"],
    V + "f 1 2 -3\n": ["line 5", "three different corners"],
    V + "f 1 2 x/1\n": ["line 5", "'x/1' is not a number"],
    V + "f 1 /2 3\n": ["line 5", "'/2' is not a number"],
    V + "f 1/2 2/- 3\n": ["line 5", "'2/-' is not a number"],
    V + "f 1 2 2.5\n": ["line 5", "'2.5' is not a whole number"],
    V + "f 1 2 \\\n 3 \\\n x\n": ["line 7", "'x' is not a number"],
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text):
    """The message has the file, the line and the reason."""
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, text))
    for part in ["moo.obj", *WRONG[text]]:
        assert part in str(caught.value)
