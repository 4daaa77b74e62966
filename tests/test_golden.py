"""What the program makes beside what is kept in tests/golden, and beside the README's picture, by ``compare``."""

import json
from pathlib import Path

import pytest
from golden.renew import DATA, GOLDEN, RUNS, produce
from test_commands import run
from test_render import needs_opengl

EXAMPLES = DATA.parent / "examples"
#: Rounding differs from machine to machine; so does what is nothing but rounding, such as the divergence of a flow.
OTHER_MACHINES = ("--rtol", "1e-7", "--atol", "1e-9")


@pytest.mark.parametrize("name", RUNS)
def test_golden(name: str, tmp_path: Path) -> None:
    """Every array, column and value of every command is what it was; ``make golden`` after a change that is meant."""
    for path in produce(name, tmp_path):
        answer = run("compare", GOLDEN / path.name, path, *OTHER_MACHINES)
        assert answer.exit_code == 0, answer.output


def test_golden_is_complete() -> None:
    """No file in the folder that nothing makes, and none too heavy for a repository."""
    kept = {file for name, job in RUNS.items() for file in (*job.kept, *([f"{name}.json"] if job.report else []))}
    files = {path.name: path.stat().st_size for path in GOLDEN.iterdir() if path.is_file()}
    assert set(files) == kept | {"renew.py"}
    assert sum(files.values()) < 400_000


def test_golden_names_no_machine() -> None:
    """Reports kept hold neither an absolute path nor a time taken."""
    for path in GOLDEN.glob("*.json"):
        report = json.loads(path.read_text())
        assert not Path(report["input"]["path"]).is_absolute()
        assert "seconds" not in report


@needs_opengl
def test_readme_picture(tmp_path: Path) -> None:
    """The picture at the top of the README is what the command of ``make demo`` draws."""
    made = tmp_path / "creature.png"
    run("geodesic", DATA / "creature.obj", "-o", tmp_path / "creature.vtk", "--png", made, "-q")
    answer = run("compare", EXAMPLES / "creature.png", made)
    assert answer.exit_code == 0, answer.output
