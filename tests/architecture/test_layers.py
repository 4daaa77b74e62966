"""Imports: the rooms that each room may import, no circles among modules, and what ``--help`` loads."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
#: Rooms from the lowest up. A file imports from its own room and from those in its entry.
ALLOWED = {
    "errors": set(),
    "arrays": set(),
    "compiled": set(),
    "stages": set(),
    "background": set(),
    "mesh": {"arrays", "compiled", "errors"},
    "intrinsic": {"arrays", "compiled", "errors", "mesh"},
    "operators": {"arrays", "errors", "mesh", "intrinsic"},
    "solvers": {"arrays", "errors", "background", "compiled", "options"},
    "results": {"arrays", "errors", "mesh"},
}
_GROUND = {*ALLOWED, "options"}
ALLOWED |= {
    "geodesic": _GROUND,
    "curves": _GROUND | {"geodesic"},
    "transport": _GROUND | {"geodesic"},
    "flow": _GROUND,
    "fluid": _GROUND | {"flow"},
    "spectral": _GROUND | {"flow"},
    "directions": _GROUND | {"flow", "spectral"},
    "scalars": _GROUND | {"geodesic"},
    "io": {"arrays", "compiled", "errors", "mesh", "results"},
    "render": {"arrays", "errors", "mesh", "results", "flow"},
    # Distances and vectors on parts of a mesh, read and written by each rank.
    "distributed": _GROUND | {"geodesic", "transport", "io"},
    # Compares two files: above io, below the program only.
    "compare": {"arrays", "errors", "mesh", "results", "io"},
}
#: Libraries that one room keeps to itself.
PRIVATE = {
    "pyvista": {"render", "results"},
    "vtkmodules": set(),
    "vtk": set(),
    "click": {"cli"},
    "meshio": {"io", "results"},
    "geomhw_cli": {"cli", "__main__"},
}


def imports_of(path: Path) -> set[str]:
    """Return every module that a file imports, at any depth."""
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
    """A file imports from its own room and from the rooms that are allowed to it."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    room = "cli" if parts[0] == "cli" else (parts[1] if len(parts) > 1 else "")
    for module in imports_of(path):
        top = module.split(".")[0]
        if top in PRIVATE:
            assert room in PRIVATE[top], f"{room} imports {module}"
        inner = room_of(module) if top == "geomhw" else ""
        if inner in ALLOWED and room in ALLOWED and inner != room:
            assert inner in ALLOWED[room], f"{room} imports {module}"


def name_of(path: Path) -> str:
    """Return the module that a file holds, under its installed name."""
    parts = list(path.relative_to(ROOT).with_suffix("").parts)
    parts[0] = {"cli": "geomhw_cli"}.get(parts[0], parts[0])
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in SOURCES}


def is_type_checking(node: ast.stmt) -> bool:
    """Whether this is ``if TYPE_CHECKING:``."""
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)


def run_at_import(body: list[ast.stmt]) -> Iterator[ast.Import | ast.ImportFrom]:
    """Yield the imports that run when the module is imported: none in functions or under TYPE_CHECKING."""
    for node in body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        elif not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not is_type_checking(node):
            for block in ("body", "orelse", "finalbody"):
                yield from run_at_import(getattr(node, block, []))


def stub_of(module: str) -> dict[str, str]:
    """Return the public names of a package and the modules that its stub takes them from."""
    stub = MODULES[module].with_suffix(".pyi")
    if not stub.exists():
        return {}
    found = {}
    for node in ast.parse(stub.read_text()).body:
        if isinstance(node, ast.ImportFrom):
            parent = f"{module}.{node.module}" if node.module else module
            found |= {alias.name: parent if node.module else f"{module}.{alias.name}" for alias in node.names}
    return found


def provider(module: str, name: str) -> str:
    """Return the module that runs when ``name`` is imported from a module: packages load their names lazily."""
    if f"{module}.{name}" in MODULES:
        return f"{module}.{name}"
    source = stub_of(module).get(name)
    return provider(source, name) if source else module


def needs(module: str) -> set[str]:
    """Return the modules of this project that a module imports when it is itself imported."""
    found = set()
    for node in run_at_import(ast.parse(MODULES[module].read_text()).body):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif node.module in MODULES:
            found |= {provider(node.module, alias.name) for alias in node.names}
    return found & MODULES.keys() - {module}


def test_no_circle() -> None:
    """No module imports itself through others, when imports in functions and for type checkers are left out."""
    graph = {module: needs(module) for module in MODULES}
    assert sum(map(len, graph.values())) > len(MODULES)  # the imports are found
    try:
        order = list(TopologicalSorter(graph).static_order())
    except CycleError as circle:
        pytest.fail(" -> ".join(circle.args[1]))
    assert set(order) == set(MODULES)


#: Libraries that take longer to load than the help takes to print.
HEAVY = {"numpy", "numba", "scipy", "matplotlib", "meshio", "pyvista", "vtkmodules", "PIL"}


def loaded_by(arguments: list[str]) -> set[str]:
    """Return the modules that the program has loaded when it exits."""
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
    """``--help`` and ``--version`` load neither numpy nor any other heavy library."""
    assert not loaded_by(arguments) & HEAVY
