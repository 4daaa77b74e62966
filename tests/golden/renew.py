"""Results on the meshes of data/, to compare new ones with; ``make golden`` renews them after a meant change."""

import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

GOLDEN = Path(__file__).resolve().parent
DATA = GOLDEN.parent.parent / "data"


@dataclass(frozen=True)
class Run:
    """One command on a mesh of data/, the files of it that are kept, and whether its report is, as ``<name>.json``."""

    arguments: str
    kept: tuple[str, ...] = ()
    report: bool = True


RUNS = {
    "geodesic": Run("geodesic sphere.off --source 0 -o geodesic.ply --json", ("geodesic.ply",)),
    "vecdiffuse": Run(
        "vecdiffuse sphere.off --source 0 --source 100 --angle 30 --dt h2 --dt 0.1 -o vecdiffuse.ply --json",
        ("vecdiffuse.ply",),
    ),
    "advect": Run(
        "advect sphere.off --field rigid:z --color blob:0 --dt 0.01 --steps 40 --every 10 -o advect.pvd "
        "--csv advect.csv --json",
        ("advect.csv",),
    ),
    "fluid": Run(
        "fluid sphere.off --init random:1 --force none --dt 0.01 --steps 20 --every 5 -o fluid.pvd "
        "--csv fluid.csv --json",
        ("fluid.csv",),
    ),
    "operators": Run("operators strip.off --connection -o connection.npz", ("connection.npz",), report=False),
    "info": Run("info genus2.off --json"),
}


def produce(name: str, folder: Path) -> list[Path]:
    """Run a command in a folder, on a copy of its mesh; the files to keep."""
    run = RUNS[name]
    words = run.arguments.split()
    shutil.copy(DATA / words[1], folder)
    command = [sys.executable, "-m", "geomhw_cli", *words]
    answer = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    kept = [folder / file for file in run.kept]
    if run.report:
        kept.append(folder / f"{name}.json")
        report = json.loads(answer.stdout)
        report.pop("seconds", None)  # of no use to anybody, and new each time
        kept[-1].write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return kept


if __name__ == "__main__":
    for name in RUNS:
        with tempfile.TemporaryDirectory() as folder:
            for path in produce(name, Path(folder)):
                shutil.copy(path, GOLDEN)
