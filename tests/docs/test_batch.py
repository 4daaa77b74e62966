"""examples/batch runs over folders with good meshes, bad meshes and unusual file names."""

import csv
import html
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest

from support.messages import missing
from support.pictures import needs_opengl

ROOT = Path(__file__).parents[2]
STRIP = ROOT / "data" / "strip.off"
STRANGE = "a b#1$x:=%'(é).off"


@pytest.fixture
def batch(tmp_path: Path) -> Path:
    """Copy the example beside two folders of one name, with good meshes, a bad one and an unusual name."""
    copy = Path(shutil.copytree(ROOT / "examples" / "batch", tmp_path / "batch", ignore=shutil.ignore_patterns("out")))
    for folder, name in [("my own/meshes", "strip.off"), ("your/meshes", "strip.off"), ("your/meshes", STRANGE)]:
        (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        shutil.copy(STRIP, tmp_path / folder / name)
    (tmp_path / "your/meshes/cut.off").write_bytes(STRIP.read_bytes()[:500])
    return copy


NAMES = {"strip", "strip-2", "a b#1$x_=%'(é)", "cut"}


def make(folder: Path, *words: str, command: str = "info", options: str = "") -> tuple[int, str]:
    """Run make, and return its exit code and what it printed."""
    given = [f"GEOMHW={sys.executable} -m geomhw_cli", f"PYTHON={sys.executable}", f"COMMAND={command}"]
    given += [f"OPTIONS={options}", "MESHES='../my own/meshes' ../your/meshes", *words]
    answer = subprocess.run(["make", *given], cwd=folder, capture_output=True, text=True)
    assert "Traceback" not in answer.stderr
    return answer.returncode, answer.stdout + answer.stderr


def table(folder: Path, command: str = "info") -> dict[str, dict[str, str]]:
    """Return the rows of the table by mesh name."""
    with (folder / "out" / command / "results.csv").open(newline="", encoding="utf-8") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


@needs_opengl
def test_every_mesh_has_a_picture_or_a_reason(batch: Path) -> None:
    """One bad mesh of four fails alone; the sheet shows three pictures and one reason."""
    code, _ = make(batch, command="geodesic", options="--source 0")
    assert code == 2
    rows = table(batch, "geodesic")
    assert rows.keys() == NAMES
    ((failed, row),) = ((name, row) for name, row in rows.items() if row["exit_code"] != "0")
    assert failed == "cut"
    assert not missing(row["reason"], "cut.off ... 71 of 602 vertices")
    assert all(row["farthest.vertex"] == "300" for row in rows.values() if row["exit_code"] == "0")
    sheet = (batch / "out" / "geodesic" / "sheet.html").read_text(encoding="utf-8")
    cards = re.findall(r"<article.*?</article>", sheet, re.DOTALL)
    assert len(cards) == len(NAMES)
    for card, row in zip(cards, rows.values(), strict=True):
        assert html.escape(Path(row["mesh"]).name) in card
        picture = re.search(r'<img src="([^"]*)"', card)
        assert bool(picture) != (html.escape(row["reason"] or "no reason") in card)
        if picture:
            file = batch / "out" / "geodesic" / unquote(html.unescape(picture[1]))
            assert file.read_bytes().startswith(b"\x89PNG")


def test_a_mesh_that_is_mended(batch: Path) -> None:
    """A second run computes what failed; the exit code is 0 once all are good; a removed mesh leaves the sheet."""
    assert make(batch)[0] == 2
    shutil.copy(STRIP, batch.parent / "your/meshes/cut.off")
    code, printed = make(batch)
    assert (code, missing(printed, "of which 3 were there")) == (0, [])
    (batch.parent / "your/meshes/cut.off").unlink()
    assert make(batch)[0] == 0
    assert table(batch).keys() == NAMES - {"cut"}
    assert "cut.off" not in (batch / "out/info/sheet.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("COMMAND=geodesics", "'geodesics' is no command"),
        ("MESHES=.", "no mesh"),
        ("GEOMHW=/nowhere/geomhw", "/nowhere/geomhw"),
    ],
)
def test_refusals(batch: Path, words: str, reason: str) -> None:
    """Wrong settings are refused before any mesh is processed, and make no sheet."""
    code, printed = make(batch, words)
    assert code == 2
    assert not missing(printed, reason)
    assert not list(batch.rglob("sheet.html"))
