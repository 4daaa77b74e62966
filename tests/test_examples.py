"""The examples run, and show what they say."""

import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_flow_validation(tmp_path: Path) -> None:
    """The figures tell the schemes apart, and both plots hold a curve of each one's color."""
    arguments = ["--levels", "1", "2", "--steps", "20", "-o", str(tmp_path)]
    program = [sys.executable, str(EXAMPLES / "flow" / "validate.py"), *arguments]
    printed = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in printed.splitlines() if line]
    errors = {(row[0], row[1]): float(row[3].rstrip(" %")) for row in rows if row[-1].endswith("%")}
    assert errors["162", "conservative"] < errors["42", "conservative"]
    assert max(errors["162", "conservative"], errors["162", "fast"]) < 0.5 * errors["162", "handout"]
    drift = {row[0]: float(row[1]) for row in rows if len(row) == 5 and row[1][0].isdigit()}
    assert drift["conservative"] < 1e-9 < drift["fast"] < 1e-2 < drift["handout"]
    for name in ("errors.png", "conservation.png"):
        pixels = np.asarray(Image.open(tmp_path / name).convert("RGB"), dtype=int)
        for color in ((0x1B, 0x6C, 0xA8), (0xD1, 0x49, 0x5B), (0x8D, 0x99, 0xAE)):
            assert (np.abs(pixels - color).sum(axis=-1) < 12).sum() > 100
