"""The public API: every name imports, has a type, and a user's program passes ``mypy --strict`` and runs."""

import ast
import importlib
import re
import subprocess
import sys
from pathlib import Path
from typing import Literal, get_args, get_origin

import click
import pytest

from geomhw import options
from geomhw_cli.main import program
from support.pictures import needs_opengl

ROOT = Path(__file__).parents[2]
SCRIPT = Path(__file__).parent / "user_script.py"
PACKAGES = sorted(".".join(path.relative_to(ROOT).parent.parts) for path in (ROOT / "geomhw").rglob("__init__.pyi"))
#: Wrong uses of the API, which a type checker must reject.
WRONG = """
import geomhw
from geomhw.mesh import icosphere
geomhw.HeatDistance(icosphere(1), nonsense=1)
geomhw.HeatDistance(icosphere(1), solver="best")
geomhw.TriangleMesh().vertices
geomhw.no_such_name
"""


def public_names(package: str) -> list[str]:
    """Return the names that the stub of a package exports."""
    stub = ast.parse((ROOT / package.replace(".", "/") / "__init__.pyi").read_text())
    imported = [alias.asname for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    declared = [ast.unparse(node.target) for node in stub.body if isinstance(node, ast.AnnAssign)]
    return [name for name in imported if name] + declared


def mypy(*files: Path) -> str:
    """Check files as a user's program would be checked: errors within the library itself are left out."""
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--config-file="]
    return subprocess.run([*command, *map(str, files)], cwd=ROOT, capture_output=True, text=True).stdout


@pytest.mark.parametrize("package", PACKAGES)
def test_names_import(package: str) -> None:
    """Each name of the stub can be imported, is shown by ``dir``, and other names raise AttributeError."""
    module = importlib.import_module(package)
    names = public_names(package)
    assert names
    for name in names:
        assert getattr(module, name) is not None
    assert {name for name in names if not name.startswith("__")} <= set(dir(module))
    with pytest.raises(AttributeError, match="nothing_of_ours"):
        module.nothing_of_ours  # noqa: B018


def test_names_are_typed(tmp_path: Path) -> None:
    """No public name has the type Any for a type checker."""
    names = [f"{package}.{name}" for package in PACKAGES for name in public_names(package)]
    lines = [*(f"import {package}" for package in PACKAGES), *(f"reveal_type({name})" for name in names)]
    (tmp_path / "names.py").write_text("\n".join(lines))
    revealed = re.findall(r'names\.py:(\d+): note: Revealed type is "(.*)"', mypy(tmp_path / "names.py"))
    types = {names[int(line) - len(PACKAGES) - 1]: found for line, found in revealed}
    assert types.keys() == set(names)
    assert [name for name, found in types.items() if found == "Any"] == []


def test_users_program_is_typed(tmp_path: Path) -> None:
    """A user's program passes ``mypy --strict``; each wrong use is an error of its own line."""
    (tmp_path / "wrong.py").write_text(WRONG)
    found = mypy(SCRIPT, tmp_path / "wrong.py")
    assert "user_script.py" not in found
    assert sorted(set(re.findall(r"wrong\.py:(\d+): error", found))) == ["4", "5", "6", "7"], found


@needs_opengl
def test_users_program_runs(folder: Path) -> None:
    """The same program runs: largest distance, sizes of the matrices and time are printed, the picture is written."""
    done = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, check=True)
    distance, *numbers = re.findall(r"[\d.]+", done.stdout)
    assert float(distance) == pytest.approx(2.24, abs=0.1)
    assert numbers[:4] == ["642"] * 4
    assert float(numbers[4]) == pytest.approx(0.1)
    assert (folder / "distance.png").read_bytes().startswith(b"\x89PNG")


#: The names from which a user chooses, by the Literal that holds them.
LITERALS = {name: get_args(value) for name, value in vars(options).items() if get_origin(value) is Literal}
#: Literals of the library for which no command has an option.
NO_OPTION = {"Location", "FlowSeries"}


def test_choices_are_those_of_the_library() -> None:
    """Each choice on the command line has the names of a Literal of ``options``, and each Literal has an option."""
    offered = {
        tuple(option.type.choices)
        for command in program.commands.values()
        for option in command.params
        if isinstance(option.type, click.Choice)
    }
    assert offered == {names for literal, names in LITERALS.items() if literal not in NO_OPTION}
