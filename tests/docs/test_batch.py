"""examples/batch runs over folders with good meshes, bad meshes and unusual file names."""

import csv
import html
import os
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


MESHES = {"meshes/strip.off", "meshes-2/strip.off", "meshes-2/a_b_1_x_____é_.off", "meshes-2/cut.off"}


def make(folder: Path, *words: str, command: str = "info", options: str = "") -> tuple[int, set[str]]:
    """Run make, and return its exit code and the names of the meshes that it processed."""
    given = [f"GEOMHW={sys.executable} -m geomhw_cli", f"PYTHON={sys.executable}", f"COMMAND={command}"]
    given += [f"OPTIONS={options}", "MESHES='../my own/meshes' ../your/meshes", *words]
    answer = subprocess.run(["make", "-j2", *given], cwd=folder, capture_output=True, text=True)
    assert "Traceback" not in answer.stderr
    return answer.returncode, set(re.findall(r"^(meshes[^ ]*): (?=done|Error)", answer.stdout, re.MULTILINE))


def table(folder: Path, command: str = "info") -> dict[str, dict[str, str]]:
    """Return the lines of the table by mesh name."""
    with (folder / "out" / command / "table.csv").open(newline="", encoding="utf-8") as file:
        return {line["name"]: line for line in csv.DictReader(file)}


def newer(path: Path) -> None:
    """Make a file newer than everything made from it."""
    os.utime(path)


@needs_opengl
def test_every_mesh_has_a_picture_or_a_reason(batch: Path) -> None:
    """One bad mesh of four fails alone; the sheet shows three pictures and one reason."""
    code, done = make(batch, command="geodesic", options="--source 0")
    assert code == 2
    assert done == MESHES
    lines = table(batch, "geodesic")
    ((failed, line),) = ((name, line) for name, line in lines.items() if line["exit_code"] != "0")
    assert failed == "meshes-2/cut.off"
    assert not missing(line["reason"], "cut.off ... 71 of 602 vertices")
    assert all(line["farthest.vertex"] == "300" for line in lines.values() if line["exit_code"] == "0")
    sheet = (batch / "out" / "geodesic" / "sheet.html").read_text(encoding="utf-8")
    cards = re.findall(r"<article.*?</article>", sheet, re.DOTALL)
    assert len(cards) == len(MESHES)
    for card, line in zip(cards, lines.values(), strict=True):
        assert html.escape(Path(line["path"]).name) in card
        picture = re.search(r'<img src="([^"]*)"', card)
        assert bool(picture) != (html.escape(line["reason"] or "no reason") in card)
        if picture:
            file = batch / "out" / "geodesic" / unquote(html.unescape(picture[1]))
            assert file.read_bytes().startswith(b"\x89PNG")


def test_only_what_changed(batch: Path) -> None:
    """A second run does nothing; newer meshes, other options and ``make retry`` rerun what they should."""
    everything = (2, MESHES)
    assert make(batch) == everything
    assert make(batch) == (2, set())
    newer(batch.parent / "your/meshes" / STRANGE)
    assert make(batch) == (2, {"meshes-2/a_b_1_x_____é_.off"})
    assert make(batch, "retry") == (2, {"meshes-2/cut.off"})
    assert make(batch, options="--check") == everything
    assert "defect" not in table(batch)["meshes/strip.off"]["reason"]


def test_a_mesh_that_is_mended(batch: Path) -> None:
    """The exit code is 0 once all meshes are good; a removed mesh leaves the sheet."""
    make(batch)
    shutil.copy(STRIP, batch.parent / "your/meshes/cut.off")
    newer(batch.parent / "your/meshes/cut.off")
    assert make(batch) == (0, {"meshes-2/cut.off"})
    (batch.parent / "your/meshes/cut.off").unlink()
    assert make(batch) == (0, set())
    assert table(batch).keys() == MESHES - {"meshes-2/cut.off"}


def test_a_name_that_comes_to_stand_for_another_mesh(batch: Path) -> None:
    """When two folders exchange their names, no result of the other folder is reused."""
    swapped = "MESHES=../your/meshes '../my own/meshes'"
    make(batch)
    code, done = make(batch, swapped)
    assert code == 2
    assert done == {"meshes/strip.off", "meshes/cut.off", "meshes/a_b_1_x_____é_.off", "meshes-2/strip.off"}
    assert table(batch)["meshes/strip.off"]["path"] == str(batch.parent / "your/meshes/strip.off")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("COMMAND=geodesics", "no command 'geodesics'"),
        ("MESHES=nowhere", "nowhere ... no such file or folder"),
        ("MESHES=.", "no meshes to work on"),
        ("OUT=a b", "blanks ... OUT=a b"),
        ("GEOMHW=/nowhere/geomhw", "/nowhere/geomhw"),
    ],
)
def test_refusals(batch: Path, words: str, reason: str) -> None:
    """Wrong settings are refused before any mesh is processed."""
    given = [
        "make",
        f"PYTHON={sys.executable}",
        f"GEOMHW={sys.executable} -m geomhw_cli",
        "MESHES=../your/meshes",
        words,
    ]
    answer = subprocess.run(given, cwd=batch, capture_output=True, text=True)
    assert answer.returncode == 2
    assert not missing(answer.stderr, reason)
    assert not list(batch.rglob("status"))
