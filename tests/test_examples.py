"""The examples run, and show what they say."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from conftest import needs_reference, reference
from PIL import Image
from test_render import needs_opengl

EXAMPLES = Path(__file__).parents[1] / "examples"
HANDOUT = EXAMPLES / "handout"
#: What the page says of the course's own mesh.
COURSE = {"0.337", "66.94074373"}


def make_handout(out: Path, *arguments: str | Path) -> None:
    """Runs make there, with this test's Python, for an output folder."""
    program = ["make", "-j2", "-C", HANDOUT, f"OUT={out}", f"PYTHON={sys.executable}", *arguments]
    subprocess.run([*program, f"GEOMHW={sys.executable} -m geomhw_cli"], check=True, capture_output=True)


@needs_opengl
def test_handout(tmp_path: Path) -> None:
    """The page's table is what a run prints, each decimal in its text is in the table, and every picture is made."""
    make_handout(tmp_path, "STEPS=2", "EVERY=1", "FADING=2")
    table = (tmp_path / "numbers.md").read_text()
    page = (HANDOUT / "README.md").read_text()
    text, found = page[: page.index("| problem |")], page[page.index("| problem |") :]
    assert found == table
    decimals = set(re.findall(r"\d+\.\d+", re.sub(r"(sec|eq)\. [\d.]+", "", text)))
    assert decimals - COURSE <= set(re.findall(r"\d+\.\d+", table))
    shown = re.findall(r"\]\((\w\S*\.(?:png|gif))\)", page)
    assert len(shown) == 8
    for name in shown:
        # As the page has it, but for a film's length.
        with Image.open(tmp_path / name) as made, Image.open(HANDOUT / name) as kept:
            assert made.size == kept.size
            assert len(np.unique(np.asarray(made.convert("RGB")).reshape(-1, 3), axis=0)) > 100


@needs_opengl
@needs_reference
def test_handout_on_the_course_mesh(tmp_path: Path) -> None:
    """The farthest vertex that the handout asks for, and what else the page says of that mesh."""
    make_handout(tmp_path, f"MESH={reference('meshes/closed/moomoo.off')}", tmp_path / "work" / "heat.json")
    report = json.loads((tmp_path / "work" / "heat.json").read_text())
    assert report["farthest"]["vertex"] == 765
    said = {f"{report['time']['t_over_h2']:.3g}", f"{report['farthest']['distance']:.10g}"}
    assert said == COURSE


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
