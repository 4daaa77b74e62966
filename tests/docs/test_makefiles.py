"""The Makefiles of the examples do what their pages state on a fresh clone, and write into ignored folders only."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.pictures import needs_opengl
from support.program import run

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
PROGRAM = f"GEOMHW={sys.executable} -m geomhw_cli"
#: What ``make`` makes, in the folder of each example.
PRODUCTS = {
    "fields": "fields.py",
    "films": "out/pair.gif out/jet.gif out/handle.gif",
    "flow": "validate.py",
    "golden": "new/geodesic.ply new/fluid.csv new/connection.npz",
    "handout": "out/creature/heat.png out/creature/advect.gif out/creature/handout.gif out/creature/numbers.md",
    "transport": "out/transport.vtk out/transport.png",
}


def make(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run make in a folder with this Python."""
    command = ["make", f"PYTHON={sys.executable}", PROGRAM, *arguments]
    outside = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    return subprocess.run(command, cwd=folder, env=outside, capture_output=True, text=True)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Data and examples as in a fresh clone, where nothing is older than what it depends on."""
    ignored = shutil.ignore_patterns("out", "new", "__pycache__")
    for name in ("data", "examples"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored, copy_function=shutil.copyfile)
    return tmp_path


@pytest.mark.parametrize("example", PRODUCTS)
def test_make_is_never_up_to_date_on_a_clone(clone: Path, example: str) -> None:
    """On a clone ``make`` computes everything, into ignored folders only."""
    folder = clone / "examples" / example
    for name in ("spot.obj", "kitten.obj"):
        (clone / "examples" / "films" / name).touch()
    planned = make(folder, "-n").stdout
    for product in PRODUCTS[example].split():
        assert product in planned
    written = re.findall(r"(?:-o|--png|--gif|--csv|>) ?(?!/dev|&)([\w./*-]+)", planned)
    assert [path for path in written if not re.match(r"out\b|new/|\$@", path)] == []
    ignored = (ROOT / ".gitignore").read_text().splitlines()
    assert "examples/*/out/" in ignored
    assert "examples/golden/new/" in ignored


@needs_opengl
def test_transport(clone: Path) -> None:
    """The picture of the page is the one that ``make`` draws; nothing else in the folder changes."""
    folder = clone / "examples" / "transport"
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert make(folder).returncode == 0
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["transport.png", "transport.vtk"]
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir() if path.name != "out"} == before
    answer = run("compare", folder / "transport.png", folder / "out" / "transport.png")
    assert answer.exit_code == 0, answer.output


def test_handout_follows_its_settings(clone: Path) -> None:
    """A second ``make`` computes nothing; after a change of a variable it computes again."""
    folder, goal = clone / "examples" / "handout", "out/creature/work/exact.json"
    assert make(folder, goal).returncode == 0
    assert "geodesic" not in make(folder, goal).stdout
    assert "geodesic" in make(folder, goal, "SOURCE=7").stdout
    assert "geodesic" in make(folder, goal).stdout


def test_films_name_a_missing_mesh(clone: Path) -> None:
    """Without the mesh of a film, make names the variable."""
    answer = make(clone / "examples" / "films", "jet")
    assert answer.returncode
    assert "SPOT=" in answer.stderr
