"""``compare`` refuses pictures that it would overwrite or cut down."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from support.pictures import PLAIN, save
from support.program import run

pytestmark = pytest.mark.usefixtures("folder")


def test_input_is_kept():
    """The difference picture may not replace an input, and must be a PNG."""
    save("a.png", PLAIN)
    before = Path("a.png").read_bytes()
    answer = run("compare", "a.png", "a.png", "--diff", "a.png")
    assert (answer.exit_code, "input" in answer.stderr) == (2, True)
    assert run("compare", "a.png", "a.png", "--diff", "d.jpg").exit_code == 2
    assert Path("a.png").read_bytes() == before


def test_deep_pngs_are_refused():
    """PNG files with 16 bits are refused."""
    Image.fromarray(np.zeros((4, 4), np.uint16)).save("a.png")
    answer = run("compare", "a.png", "a.png")
    assert answer.exit_code == 2
    assert "more than 8 bits" in answer.stderr
