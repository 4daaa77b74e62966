"""The house: which room may import which, and what the program may load before it is asked to work."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
#: Rooms from the ground up. A file imports from its own room and from those that its entry names.
ALLOWED = {
    "errors": set(),
    "arrays": set(),
    "stages": set(),
    "background": set(),
    "mesh": {"arrays", "errors"},
    "intrinsic": {"arrays", "errors", "mesh"},
    "operators": {"arrays", "errors", "mesh", "intrinsic"},
    "solvers": {"arrays", "errors", "background"},
    "results": {"arrays", "errors", "mesh"},
}
_GROUND = {*ALLOWED, "options"}
ALLOWED |= {
    "geodesic": _GROUND,
    "transport": _GROUND | {"geodesic"},
    "flow": _GROUND,
    "fluid": _GROUND | {"flow"},
    "io": {"arrays", "errors", "mesh", "results"},
    "render": {"arrays", "errors", "mesh", "results"},
    # Reads two files and says what differs: above io, and below nothing but the program.
    "compare": {"arrays", "errors", "mesh", "results", "io"},
}
#: Libraries that one room keeps to itself.
PRIVATE = {
    "pyvista": set(),
    "vtkmodules": {"render"},
    "vtk": {"render"},
    "click": {"cli"},
    "meshio": {"io"},
    "geomhw_cli": {"cli"},
}


def imports_of(path: Path) -> set[str]:
    """Every module that the file names in an import, wherever in the file that stands."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} has a relative import"
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def room_of(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


SOURCES = sorted([*(ROOT / "geomhw").rglob("*.py"), *(ROOT / "cli").rglob("*.py")])


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_arrows(path: Path) -> None:
    """A file imports from its own room and from those that the design allows it."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    room = "cli" if parts[0] == "cli" else (parts[1] if len(parts) > 1 else "")
    for module in imports_of(path):
        top = module.split(".")[0]
        if top in PRIVATE:
            assert room in PRIVATE[top], f"{room} imports {module}"
        inner = room_of(module) if top == "geomhw" else ""
        if inner in ALLOWED and room in ALLOWED and inner != room:
            assert inner in ALLOWED[room], f"{room} imports {module}"


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_rooms_are_small(path: Path) -> None:
    """A file has one subject: 320 lines at most."""
    assert len(path.read_text().splitlines()) <= 320


def loaded_by(arguments: list[str]) -> set[str]:
    """Modules that the program has loaded when it exits."""
    script = (
        "import sys\n"
        "from geomhw_cli.main import program\n"
        f"program.main({arguments!r}, standalone_mode=False)\n"
        "print(*sys.modules, file=sys.stderr)\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stderr.split())


@pytest.mark.parametrize("arguments", [["--help"], ["geodesic", "--help"], ["compare", "--help"], ["--version"]])
def test_help_loads_nothing_heavy(arguments: list[str]) -> None:
    """Help and version load neither numpy nor anything above it."""
    assert not loaded_by(arguments) & {"numpy", "scipy", "meshio", "pyvista", "vtkmodules", "PIL"}
