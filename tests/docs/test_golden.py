"""The program's output equals that in examples/golden, and its picture that of the README, by ``compare``."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geomhw.io.artifacts.tables import read_csv, write_csv
from support.messages import missing
from support.pictures import needs_opengl
from support.program import run

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "golden"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, "subprocess.CompletedProcess[str]"]:
    """Return a copy of the example where make has run, and make's answer."""
    copy = tmp_path_factory.mktemp("made") / "golden-example"
    shutil.copytree(EXAMPLE, copy, ignore=shutil.ignore_patterns("new"))
    return copy, make(copy)


def make(folder: Path, *goals: str) -> subprocess.CompletedProcess[str]:
    """Run make in a folder, with the meshes of this project."""
    variables = [f"GEOMHW={sys.executable} -m geomhw_cli", f"DATA={ROOT / 'data'}"]
    return subprocess.run(["make", "-s", *goals, *variables], cwd=folder, capture_output=True, text=True)


def kept(folder: Path) -> dict[str, bytes]:
    """Return the golden files."""
    return {path.name: path.read_bytes() for path in (folder / "golden").iterdir()}


def test_golden(made: tuple[Path, "subprocess.CompletedProcess[str]"]) -> None:
    """Every array, column and value of every command equals the golden one."""
    golden, answer = made
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert answer.stdout.count(": same: ") == len(kept(golden))


def test_golden_tells_and_renews(made: tuple[Path, "subprocess.CompletedProcess[str]"], tmp_path: Path) -> None:
    """Changed and missing golden files are reported with the place of the change; ``make renew`` restores them."""
    golden = Path(shutil.copytree(made[0], tmp_path / "golden-example"))
    before = kept(golden)
    table = golden / "golden" / "fluid.csv"
    columns = {name: np.array(values) for name, values in read_csv(table).items()}
    columns["energy"][2] *= 1.001
    write_csv(table, [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)])
    (golden / "golden" / "info.json").unlink()
    answer = make(golden, "--old-file=results")
    assert answer.returncode != 0
    assert re.search(r"^fluid.csv: different +column +energy .*\[2\]", answer.stdout, re.MULTILINE), answer.stdout
    assert any(not missing(line, "info.json: Error: ... no such file") for line in answer.stdout.splitlines())
    assert answer.stdout.count(": same: ") == len(before) - 2
    renewed = make(golden, "renew")
    assert renewed.returncode == 0, renewed.stderr
    assert renewed.stdout.count("renewed") == 2
    after = kept(golden)
    assert after.keys() == before.keys()
    changed = {name for name in after if after[name] != before[name]}
    assert changed <= {"fluid.csv", "info.json"}
    assert run("compare", table, EXAMPLE / "golden" / "fluid.csv", "--rtol", "1e-7", "--atol", "1e-9").exit_code == 0


def test_golden_is_complete() -> None:
    """Each file in the folder is compared, and together they take less than 400 kB."""
    listed = re.search(r"^RESULTS = ((?:.*\\\n)*.*)", (EXAMPLE / "Makefile").read_text(), re.MULTILINE)
    assert listed
    files = kept(EXAMPLE)
    assert set(files) == set(listed[1].replace("\\\n", " ").split())
    assert sum(map(len, files.values())) < 400_000


def test_golden_names_no_machine() -> None:
    """Golden reports hold no absolute path."""
    for path in (EXAMPLE / "golden").glob("*.json"):
        report = json.loads(path.read_text())
        assert not any(Path(name).is_absolute() for name in [report["input"]["path"], *report.get("files", [])])


@needs_opengl
def test_readme_picture(tmp_path: Path) -> None:
    """The picture in the README is the one that ``make demo`` draws."""
    made = tmp_path / "creature.png"
    run("geodesic", ROOT / "data" / "creature.obj", "-o", tmp_path / "creature.vtk", "--png", made, "-q")
    answer = run("compare", ROOT / "examples" / "creature.png", made)
    assert answer.exit_code == 0, answer.output
