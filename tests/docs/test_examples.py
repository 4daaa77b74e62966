"""The examples run, and their output has the stated properties."""

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
#: The numbers on the page for the mesh of the course.
COURSE = {"0.337", "66.94074373"}


def make_handout(out: Path, *arguments: str | Path) -> None:
    """Run make in examples/handout, with this Python, for an output folder."""
    command = ["make", "-j2", "-C", HANDOUT, f"OUT={out}", f"PYTHON={sys.executable}", *arguments]
    subprocess.run([*command, f"GEOMHW={sys.executable} -m geomhw_cli"], check=True, capture_output=True)


@needs_opengl
def test_handout(tmp_path: Path) -> None:
    """The page's table is the output of a run, its decimals are in the table, and every picture is made."""
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
        # Only the length of a film differs from the page.
        with Image.open(tmp_path / name) as made, Image.open(HANDOUT / name) as kept:
            assert made.size == kept.size
            assert len(np.unique(np.asarray(made.convert("RGB")).reshape(-1, 3), axis=0)) > 100


@needs_opengl
@needs_reference
def test_handout_on_the_course_mesh(tmp_path: Path) -> None:
    """On the course's mesh, farthest vertex, distance and time are those on the page."""
    make_handout(tmp_path, f"MESH={reference('meshes/closed/moomoo.off')}", tmp_path / "work" / "heat.json")
    report = json.loads((tmp_path / "work" / "heat.json").read_text())
    assert report["farthest"]["vertex"] == 765
    said = {f"{report['time']['t_over_h2']:.3g}", f"{report['farthest']['distance']:.10g}"}
    assert said == COURSE


def test_links() -> None:
    """Links lead to existing files, and each method has a page, which the list of pages names."""
    pages = [EXAMPLES.parent / "README.md", *EXAMPLES.rglob("*.md")]
    links = [(page, link) for page in pages for link in re.findall(r"\]\(([^)#\s]+)\)", page.read_text())]
    assert len(links) > 40
    assert [(page.name, link) for page, link in links if "://" not in link and not (page.parent / link).exists()] == []
    listed = (EXAMPLES / "methods" / "README.md").read_text()
    assert {page.name for page in (EXAMPLES / "methods").glob("[!R]*.md")} == set(re.findall(r"\((\w+\.md)\)", listed))
    named = set(re.findall(r"`(\w+)`", listed))
    others = {"batch", "compare", "completion", "info", "merge", "operators", "repair", "view"}
    assert set(program.commands) - others <= named


def test_flow_validation(tmp_path: Path) -> None:
    """The figures separate the schemes, and both plots have a curve of each scheme's color."""
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


@needs_opengl
def test_fields(tmp_path: Path) -> None:
    """The numbers on the page are printed, and the pictures are those of the page."""
    folder = EXAMPLES / "fields"
    command = [sys.executable, str(folder / "fields.py"), "-o", str(tmp_path)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    page = (folder / "README.md").read_text()
    bracket, killing, _, design = printed.splitlines()
    assert f"    {bracket}\n" in page
    assert re.search(r"1 Killing field, the next energy is \d+e\+(09|1\d) times as large", killing)
    alone, joint = (int(number) for number in re.findall(r"(\d+)°", design))
    assert alone > 60
    assert joint < 15
    for name in ("bracket", "killing", "design"):
        with Image.open(tmp_path / f"{name}.png") as made, Image.open(folder / f"{name}.png") as kept:
            assert made.size == kept.size
            assert len(np.unique(np.asarray(made.convert("RGB")).reshape(-1, 3), axis=0)) > 100


# -- from Python -------------------------------------------------------------------------------------------------


def numbers_of(name: str, folder: Path) -> list[float]:
    """Run a program of examples/python in a folder, and return the numbers that it prints."""
    command = [sys.executable, str(EXAMPLES / "python" / f"{name}.py")]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder).stdout
    return [float(word.replace(",", "")) for word in re.findall(r"-?\d[\d,]*(?:\.\d+)?(?:e-?\d+)?", printed)]


def test_python_programs_are_short() -> None:
    """Each program has at most 30 lines, and the README names it."""
    files = sorted((EXAMPLES / "python").glob("*.py"))
    readme = (EXAMPLES / "python" / "README.md").read_text()
    assert len(files) == 5
    for file in files:
        assert len([line for line in file.read_text().splitlines() if line]) <= 30
        assert f"]({file.name})" in readme


def test_examples_import_from_rooms() -> None:
    """No program of the examples imports from deeper than ``geomhw.<room>``."""
    for file in EXAMPLES.rglob("*.py"):
        assert not re.search(r"^(?:from|import) geomhw\.\w+\.", file.read_text(), re.MULTILINE), file


def test_python_distance(tmp_path: Path) -> None:
    """The file has the distances from five points, which are spread over the surface."""
    numbers_of("distance", tmp_path)
    distance = np.asarray(read(tmp_path / "points.vtp")["distance"])
    assert np.count_nonzero(distance == 0) == 5
    assert 0.8 < distance.max() < 1.29


def test_python_transport(tmp_path: Path) -> None:
    """The vector returns turned by the enclosed area, 90°, to a tenth of a degree."""
    found = numbers_of("transport", tmp_path)
    np.testing.assert_allclose([found[-4], found[-1]], 90, atol=0.1)


def test_python_decomposition(tmp_path: Path) -> None:
    """The shares sum to 100 %, and the added gradient is recovered."""
    *shares, off = numbers_of("decomposition", tmp_path)
    assert sum(shares) == pytest.approx(100, abs=0.2)
    assert min(shares) > 5
    assert off < 1e-3


def test_python_flow(tmp_path: Path) -> None:
    """The vortices turn by more than 20° from line to line, and the energy is constant."""
    found = numbers_of("flow", tmp_path)
    angles, drift = np.array(found[1:8:2]), found[-1]
    assert (np.diff(angles) > 20).all()
    assert drift < 1e-9


def test_python_own_operator(tmp_path: Path) -> None:
    """The error of the commutator of two rotations decreases with each refinement."""
    errors = numbers_of("own_operator", tmp_path)[1::2]
    assert errors[0] > 1.3 * errors[1] > 1.3**2 * errors[2]
    assert errors[2] < 3
