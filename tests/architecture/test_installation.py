"""What installs and documents the program elsewhere agrees with it: man pages, completion, the conda recipe, Docker."""

import re
import runpy
import shutil
import subprocess
from pathlib import Path

import click
import pytest

from geomhw_cli.main import program
from support.messages import missing
from support.program import run

tomllib = pytest.importorskip("tomllib")  # of Python 3.11
ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
#: Packages that conda-forge names differently.
NAMES = {"matplotlib": "matplotlib-base"}


def test_man_pages_hold_every_option(tmp_path: Path) -> None:
    """Each command has a page with all spellings of its options, which groff formats without a warning."""
    pages = runpy.run_path(str(ROOT / "examples" / "reference" / "man_pages.py"))["man_pages"]()
    assert set(pages) == {"geomhw.1", *(f"geomhw-{name}.1" for name in program.commands)}
    for name, command in program.commands.items():
        text = pages[f"geomhw-{name}.1"].replace("\\-", "-")
        for option in command.params:
            if isinstance(option, click.Option):
                assert all(spelling in text for spelling in option.opts), (name, option.opts)
    if groff := shutil.which("groff"):
        for name, text in pages.items():
            (tmp_path / name).write_text(text, encoding="utf-8")
        command_line = [groff, "-man", "-Tutf8", "-Kutf8", "-ww", *map(str, sorted(tmp_path.iterdir()))]
        done = subprocess.run(command_line, capture_output=True, text=True)
        serious = [line for line in done.stderr.splitlines() if "break" not in line and "adjust" not in line]
        assert done.returncode == 0
        assert serious == []


@pytest.mark.parametrize(
    ("shell", "words"),
    [("bash", "complete ... _geomhw_completion geomhw"), ("zsh", "#compdef geomhw"), ("fish", "complete ... geomhw")],
)
def test_completion_is_printed_and_installed(
    shell: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The script is printed, or written where the shell looks for it."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    printed = run("completion", shell)
    assert printed.exit_code == 0
    assert not missing(printed.stdout, words)
    answer = run("completion", shell, "--install")
    assert answer.exit_code == 0
    (written,) = (path for path in tmp_path.rglob("*") if path.is_file())
    assert written.read_text() == printed.stdout
    assert str(written) in answer.stdout


def test_bash_completes(tmp_path: Path) -> None:
    """The installed script completes a command in bash."""
    if not (bash := shutil.which("bash")):
        pytest.skip("there is no bash")
    (tmp_path / "script").write_text(run("completion", "bash").stdout)
    (tmp_path / "geomhw").write_text("#!/bin/sh\n[ \"$_GEOMHW_COMPLETE\" = bash_complete ] && echo 'plain,smooth'\n")
    (tmp_path / "geomhw").chmod(0o755)
    line = f"source {tmp_path}/script; COMP_WORDS=(geomhw smo); COMP_CWORD=1; _geomhw_completion {tmp_path}/geomhw; "
    done = subprocess.run([bash, "-c", line + 'echo "${COMPREPLY[@]}"'], capture_output=True, text=True)
    assert done.stdout == "smooth\n", done.stderr


def test_conda_recipe() -> None:
    """The recipe of conda has the version, Python, requirements and entry point of the project."""
    recipe = (ROOT / "examples" / "install" / "meta.yaml").read_text()
    assert f'version: "{PROJECT["version"]}"' in recipe
    assert f"python {PROJECT['requires-python']}" in recipe
    wanted = set()
    for requirement in PROJECT["dependencies"]:
        name, bound = re.fullmatch(r"([\w-]+)(>=[\d.]+)", requirement).groups()  # type: ignore[union-attr]
        wanted.add(f"{NAMES.get(name, name)} {bound}")
    run_section = recipe.partition("  run:\n")[2].partition("\ntest:")[0]
    assert set(re.findall(r"- (.+)", run_section)) == wanted | {f"python {PROJECT['requires-python']}"}
    assert f"geomhw = {PROJECT['scripts']['geomhw']}" in recipe


def test_docker_runs_the_job_of_the_demo() -> None:
    """The image runs the command line of ``make demo``, and copies what exists."""
    docker = (ROOT / "examples" / "install" / "Dockerfile").read_text()
    (job,) = re.findall(r"geomhw (geodesic \S+)", (ROOT / "Makefile").read_text())[:1]
    assert f"geomhw {job}" in docker.partition("CMD")[2]
    for line in re.findall(r"^COPY (.*) \S+$", docker, re.MULTILINE):
        assert all((ROOT / name).exists() for name in line.split())
