"""The examples run, and show what they say."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from geomhw.io import read
from geomhw_cli.main import program
from support.pictures import needs_opengl
from support.reference import needs_reference, reference

EXAMPLES = Path(__file__).parents[2] / "examples"
HANDOUT = EXAMPLES / "handout"
#: What the page says of the course's own mesh.
COURSE = {"0.337", "66.94074373"}


def make_handout(out: Path, *arguments: str | Path) -> None:
    """Runs make there, with this test's Python, for an output folder."""
    command = ["make", "-j2", "-C", HANDOUT, f"OUT={out}", f"PYTHON={sys.executable}", *arguments]
    subprocess.run([*command, f"GEOMHW={sys.executable} -m geomhw_cli"], check=True, capture_output=True)


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


def test_links() -> None:
    """Pages lead to files that are there, and each of the five methods has a page."""
    pages = [EXAMPLES.parent / "README.md", *EXAMPLES.rglob("*.md")]
    links = [(page, link) for page in pages for link in re.findall(r"\]\(([^)#\s]+)\)", page.read_text())]
    assert len(links) > 40
    assert [(page.name, link) for page, link in links if "://" not in link and not (page.parent / link).exists()] == []
    methods = {"geodesic", "vecdiffuse", "advect", "fluid", "helmholtz"}
    assert {page.stem for page in (EXAMPLES / "methods").glob("[!R]*.md")} == methods <= set(program.commands)


def test_flow_validation(tmp_path: Path) -> None:
    """The figures tell the schemes apart, and both plots hold a curve of each one's color."""
    arguments = ["--levels", "1", "2", "--steps", "20", "-o", str(tmp_path)]
    command = [sys.executable, str(EXAMPLES / "flow" / "validate.py"), *arguments]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in printed.splitlines() if line]
    errors = {(row[0], row[1]): float(row[3].rstrip(" %")) for row in rows if row[-1].endswith("%")}
    assert errors["162", "conservative"] < errors["42", "conservative"]
    assert max(errors["162", "conservative"], errors["162", "rk4"]) < 0.5 * errors["162", "stable-fluids"]
    drift = {row[0]: float(row[1]) for row in rows if len(row) == 5 and row[1][0].isdigit()}
    assert drift["conservative"] < 1e-9 < drift["rk4"] < 1e-2 < drift["stable-fluids"]
    for name in ("errors.png", "conservation.png"):
        pixels = np.asarray(Image.open(tmp_path / name).convert("RGB"), dtype=int)
        for color in ((0x1B, 0x6C, 0xA8), (0xD1, 0x49, 0x5B), (0x8D, 0x99, 0xAE)):
            assert (np.abs(pixels - color).sum(axis=-1) < 12).sum() > 100


# -- from Python -------------------------------------------------------------------------------------------------


def numbers_of(name: str, folder: Path) -> list[float]:
    """Runs a program of examples/python in a folder; the numbers that it prints."""
    command = [sys.executable, str(EXAMPLES / "python" / f"{name}.py")]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder).stdout
    return [float(word.replace(",", "")) for word in re.findall(r"-?\d[\d,]*(?:\.\d+)?(?:e-?\d+)?", printed)]


def test_python_programs_are_short() -> None:
    """Each is short enough to be read at once, and named in the README."""
    files = sorted((EXAMPLES / "python").glob("*.py"))
    readme = (EXAMPLES / "python" / "README.md").read_text()
    assert len(files) == 5
    for file in files:
        assert len([line for line in file.read_text().splitlines() if line]) <= 30
        assert f"]({file.name})" in readme


def test_python_distance(tmp_path: Path) -> None:
    """Each point is nearer to the others than the one before, and the file has the distances from all."""
    numbers_of("distance", tmp_path)
    distance = np.asarray(read(tmp_path / "points.vtp")["distance"])
    assert np.count_nonzero(distance == 0) == 5
    assert 0.8 < distance.max() < 1.29


def test_python_transport(tmp_path: Path) -> None:
    """The vector comes back turned by the area, a quarter turn, to a tenth of a degree."""
    found = numbers_of("transport", tmp_path)
    np.testing.assert_allclose([found[-4], found[-1]], 90, atol=0.1)


def test_python_decomposition(tmp_path: Path) -> None:
    """Shares add up; the slope is found but for what the mesh takes for slope in the flow round the hole."""
    *shares, off = numbers_of("decomposition", tmp_path)
    assert sum(shares) == pytest.approx(100, abs=0.2)
    assert min(shares) > 5
    assert off < 1e-3


def test_python_flow(tmp_path: Path) -> None:
    """The vortices turn on, by some 30° from line to line, and energy is kept."""
    found = numbers_of("flow", tmp_path)
    angles, drift = np.array(found[1:8:2]), found[-1]
    assert (np.diff(angles) > 20).all()
    assert drift < 1e-9


def test_python_own_operator(tmp_path: Path) -> None:
    """The bracket of two turns comes nearer to the third with every refinement."""
    errors = numbers_of("own_operator", tmp_path)[1::2]
    assert errors[0] > 1.3 * errors[1] > 1.3**2 * errors[2]
    assert errors[2] < 3
