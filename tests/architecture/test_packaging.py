"""The wheel holds both packages and no tests; the console script is declared."""

import subprocess
import sys
import zipfile
from importlib.metadata import entry_points
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Build a wheel from a copy of the sources, and return the names of its files."""
    import shutil

    copy = tmp_path_factory.mktemp("sources")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy / name)
    for name in ("geomhw", "cli"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    target = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--quiet"]
    subprocess.run([*pip, "--wheel-dir", str(target), str(copy)], check=True, capture_output=True)
    (built,) = target.glob("*.whl")
    with zipfile.ZipFile(built) as archive:
        return archive.namelist()


def test_wheel_holds_every_module(wheel: list[str]) -> None:
    """The wheel holds each module of both packages under its installed name, and nothing else."""
    library = {str(p.relative_to(ROOT)) for p in (ROOT / "geomhw").rglob("*.py*") if p.suffix in (".py", ".pyi")}
    commands = {f"geomhw_cli/{p.relative_to(ROOT / 'cli')}" for p in (ROOT / "cli").rglob("*.py")}
    viewer = {str(p.relative_to(ROOT)) for p in (ROOT / "geomhw/render/viewer").iterdir()}
    inside = {name for name in wheel if ".dist-info/" not in name}
    assert inside == library | commands | viewer | {"geomhw/py.typed"}


def test_console_script() -> None:
    """The console script ``geomhw`` starts the program."""
    (script,) = entry_points(group="console_scripts", name="geomhw")
    assert script.value == "geomhw_cli.main:main"


def test_sdist_can_run_its_tests(tmp_path: Path) -> None:
    """The source distribution holds the modules, the tests and the files that these read."""
    import shutil
    import tarfile

    copy, hidden = tmp_path / "sources", shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc", "new", "out")
    copy.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", "MANIFEST.in", "Makefile", "CHANGELOG.md", "CITATION.cff"):
        shutil.copy(ROOT / name, copy / name)
    for name in ("geomhw", "cli", "tests", "data", "examples"):
        shutil.copytree(ROOT / name, copy / name, ignore=hidden)
    wanted = {str(path.relative_to(copy)) for path in copy.rglob("*") if path.is_file()}
    code = f"from setuptools import build_meta; build_meta.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", code], cwd=copy, check=True, capture_output=True)
    (built,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(built) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    assert wanted <= inside
