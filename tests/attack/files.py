"""Hostile files through the command line: an exit code, at most one line, and no file where there is no result."""

import os
import random
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from attack.program import fresh, prepared

from fuzz.mutations import mutated
from fuzz.targets import TARGETS
from support.program import contents, run

FUZZ = Path(__file__).parents[1] / "fuzz"
STRAIGHTEN = "path ball.off --straighten X --no-png -o p.vtp"
#: Commands that read a file of a target; the others are meshes.
READERS = {
    "cloud": ["compare X X", "view ball.off --points X -o v.html", STRAIGHTEN],
    "series": ["compare X X", "view X -o v.html"],
    "table": ["compare X X", STRAIGHTEN, "advect ball.off --field X:x,y --steps 1 -o s.pvd"],
    "columns": ["advect ball.off --color X:x --steps 1 -o s.pvd", "geodesic ball.off --mask X:x --no-png -o g.vtk"],
    "array": ["helmholtz ball.off --field X --no-png -o h.vtk", "advect ball.off --color X --steps 1 -o s.pvd"],
    "archive": ["helmholtz ball.off --field X:u --no-png -o h.vtk"],
    "npy": ["compare X X"],
    "npz": ["compare X X"],
    "mtx": ["compare X X"],
    "document": ["compare X X"],
    "picture": ["compare X X"],
    "state": ["fluid ball.off --restart X --steps 1 -o s.pvd"],
}
MESH = ["info X", "info X --check", "geodesic X --no-png -o g.vtk", "repair X -o r.ply", "compare X ball.off"]
MESH += ["geodesic ball.off --source @X --no-png -o g.vtk", "advect X --steps 1 -o s.pvd"]
MESH += ["path X --from 0 --to 1 --no-png -o p.vtp", "trace X --length 1 --no-png -o t.csv", "view X -o v.html"]
MESH += ["logmap X --no-png -o l.vtp", "spectrum X -k 3 --no-png -o e.vtp", "path ball.off --pairs X --no-png -o p.csv"]
SECONDS = 20


def attack(seed: int, count: int) -> Iterator[list[str]]:
    """Give this number of damaged files to commands; yield what is wrong with each answer."""
    chance = random.Random(seed)
    here = os.getcwd()
    with prepared() as template, tempfile.TemporaryDirectory() as space:
        for number in range(count):
            name = list(TARGETS)[number % len(TARGETS)]
            seeds = [path.read_bytes() for path in sorted((FUZZ / "corpus" / name).iterdir())]
            data = mutated(seeds, chance)
            file = f"hostile{TARGETS[name][0]}"
            command = chance.choice(READERS.get(name, MESH)).replace("X", file)
            folder = fresh(template, Path(space) / "run")
            (folder / file).write_bytes(data)
            os.chdir(folder)
            try:
                wrong = answered(command, folder)
            finally:
                os.chdir(here)
            if wrong:
                kept = Path(tempfile.gettempdir()) / f"geomhw-attack-{seed}-{number}{TARGETS[name][0]}"
                kept.write_bytes(data)
                wrong = [f"files {number}: {command} with {kept}: {words}" for words in wrong]
            yield wrong


def answered(command: str, folder: Path) -> list[str]:
    """Run a command in its folder; return what is wrong with its answer."""
    before, begun = contents(folder), time.process_time()
    try:
        answer = run(*command.split())
    except Exception as error:
        return [f"raises {type(error).__name__}: {error}"]
    wrong = []
    if (seconds := time.process_time() - begun) > SECONDS:
        wrong.append(f"takes {seconds:.0f} s")
    after, lines = contents(folder), answer.stderr.strip().splitlines()
    is_failure = answer.exit_code == (2 if command.startswith("compare") or "--check" in command else 1)
    if answer.exit_code not in (0, 1, 2):
        wrong.append(f"exit code {answer.exit_code}")
    if is_failure and not (lines and lines[-1].startswith("Error: ") and len(lines) == 1):
        wrong.append(f"says {lines}")
    if is_failure and after != before:
        wrong.append(f"leaves {sorted(after.keys() - before.keys())}")
    if any(name.startswith(".") for name in after):
        wrong.append("leaves hidden files")
    return wrong
