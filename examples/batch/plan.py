"""Names for meshes that make can handle: ``python3 plan.py OUT MESHES...`` prints them.

MESHES are folders and files. Each name is that of a link in OUT/.meshes to a mesh, so that neither make nor the shell
ever sees what the mesh itself is called; OUT/meshes.json has the paths.
"""

import json
import os
import re
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path

#: What geomhw reads.
EXTENSIONS = (".off", ".obj", ".ply", ".stl", ".vtk", ".vtp", ".vtu")
EXTENSIONS += (".msh", ".mesh", ".meshb", ".inp", ".bdf", ".nas", ".vol", ".su2")


def main() -> None:
    """Link the meshes and print their names."""
    out, given = Path(sys.argv[1]), [Path(os.path.abspath(name)) for name in sys.argv[2:]]
    if re.search(r"\s", str(out)):
        sys.exit(f"make cannot handle blanks in OUT={out}")
    for path in given:
        if not path.exists():
            sys.exit(f"{path}: there is no such file or folder")
    names = named([mesh for path in given for mesh in meshes_of(path)])
    for name, mesh in names.items():
        link(out, name, mesh)
    if names:
        (out / "meshes.json").write_text(json.dumps({name: str(mesh) for name, mesh in names.items()}, indent=2) + "\n")
    print(*names)


def meshes_of(path: Path) -> list[Path]:
    """The meshes of a folder, not of folders within; or the file itself, whatever its name."""
    if not path.is_dir():
        return [path]
    files = (file for file in path.iterdir() if not file.name.startswith(".") and not file.is_dir())
    return sorted(file for file in files if file.suffix.lower() in EXTENSIONS)


def named(meshes: list[Path]) -> dict[str, Path]:
    """``folder/file`` for each mesh, without blanks or signs that make or the shell takes for its own.

    Where two would have one name, the later is numbered: ``meshes-2/ball.off`` is of the second folder ``meshes``.
    """
    folders: dict[Path, str] = {}
    names: dict[str, Path] = {}
    for mesh in dict.fromkeys(meshes):
        if mesh.parent not in folders:
            folders[mesh.parent] = free(plain(mesh.parent.name or "root"), folders.values())
        names[free(f"{folders[mesh.parent]}/{plain(mesh.name)}", names)] = mesh
    return names


def plain(name: str) -> str:
    """Letters of any script, digits, and ``. + - _``, which also stands for all others."""
    return re.sub(r"^[.-]", "_", re.sub(r"[^\w.+-]", "_", name))


def free(name: str, taken: Iterable[str]) -> str:
    """That name, or the first of ``name-2``, ``name-3``, ... that is not taken, whatever its capitals."""
    used = {other.casefold() for other in taken}
    candidates = (name if k == 1 else f"{name}-{k}" for k in range(1, len(used) + 2))
    return next(candidate for candidate in candidates if candidate.casefold() not in used)


def link(out: Path, name: str, mesh: Path) -> None:
    """Make the link; what was computed under its name from another mesh goes away."""
    place = out / ".meshes" / name
    if place.is_symlink():
        if os.readlink(place) == str(mesh):
            return
        shutil.rmtree(out / name, ignore_errors=True)
        place.unlink()
    place.parent.mkdir(parents=True, exist_ok=True)
    place.symlink_to(mesh)


if __name__ == "__main__":
    main()
