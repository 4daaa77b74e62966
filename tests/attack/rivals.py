"""Two runs at once with other options and one output: the files are those of one of them, whole."""

import random
import tempfile
import time
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from attack.program import FLOW, FLUID, SECONDS, finished, fresh, prepared, start

from support.program import contents

ROWS = "geodesic ring.off --all-pairs -o D.npy"
#: Two commands whose outputs share a file, by the kind of the file.
PAIRS = {
    "mesh": ("geodesic ball.off --source 0 -o a.vtk -o b.ply", "geodesic ball.off --source 9 -o a.vtk -o b.ply"),
    "picture": tuple(f"geodesic ball.off --source {v} -o a.vtk --png a.png" for v in (0, 9)),
    "matrix": tuple(f"{ROWS} --time {time}" for time in ("h2", "sqrt-h")),
    "same matrix": (ROWS, ROWS),
    "other method": (ROWS, f"{ROWS} --method exact"),
    "sparse": tuple(f"geodesic ring.off --all-pairs --method exact --limit {r} -o D.npz" for r in (1, 0.5)),
    "operator": ("operators ball.off --stiffness -o S.mtx", "operators ball.off --mass -o S.mtx"),
    "series": (f"advect ball.off {FLOW} -o s.pvd", f"advect ball.off {FLOW} -o s.pvd --integrator expm"),
    "table": (f"advect ball.off {FLOW} -o s.pvd --csv t.csv", f"fluid ball.off {FLUID} -o f.pvd --csv t.csv"),
    "film": tuple(f"advect ball.off {FLOW} -o {name}.pvd --gif g.gif --width 200" for name in "ab"),
    "sheet": tuple(f"fluid ball.off {FLUID} -o {name}.pvd --png g.png --width 200" for name in "ab"),
    "fluid": (f"fluid ball.off {FLUID} -o f.pvd", f"fluid ball.off {FLUID} -o f.pvd --scheme rk4"),
    "folder": (f"fluid ball.off {FLUID} --no-png", f"fluid ball.off {FLUID} --no-png --scheme rk4"),
    "curves": tuple(f"path ball.off --from {v} --to 9 -o p.vtp --png p.png --svg p.svg" for v in (0, 5)),
    "sites": tuple(f"voronoi ball.off --sites {k} --no-png -o {k}.vtp --points s.csv" for k in (4, 5)),
    "spectrum": tuple(f"spectrum ball.off -k {k} -o e.vtp --png e.png" for k in (4, 5)),
    "page": ("view ball.off -o v.html", "view ring.off -o v.html"),
    "repair": ("repair ball.off -o r.ply", "repair ring.off -o r.ply"),
}


@lru_cache
def alone(command: str) -> tuple[float, dict[str, bytes]]:
    """Return the time and the files of a run without a rival."""
    with prepared() as folder:
        before = contents(folder)
        begun = time.monotonic()
        finished(command, folder)
        return time.monotonic() - begun, {k: v for k, v in contents(folder).items() if k not in before}


def attack(seed: int, count: int) -> Iterator[list[str]]:
    """Start this number of pairs; yield what is wrong with each."""
    chance = random.Random(seed)
    with prepared() as template, tempfile.TemporaryDirectory() as space:
        for number in range(count):
            kind = list(PAIRS)[number % len(PAIRS)]
            pair = chance.sample(PAIRS[kind], 2)
            delay = chance.uniform(0, 0.9) * alone(pair[0])[0] if chance.random() < 0.6 else 0.0
            folder = fresh(template, Path(space) / "run")
            yield [f"rivals {number} ({kind}, {delay:.1f} s): {words}" for words in raced(pair, delay, folder)]


def raced(pair: list[str], delay: float, folder: Path) -> list[str]:
    """Start two commands; return what is wrong with their exit codes, words and files."""
    before, wrong = contents(folder), []
    with start(pair[0], folder) as first:
        time.sleep(delay)
        with start(pair[1], folder) as second:
            errors = [process.communicate(timeout=2 * SECONDS)[1] for process in (first, second)]
    codes = [first.returncode, second.returncode]
    for code, err in zip(codes, errors, strict=True):
        lines = err.strip().splitlines()
        if code not in (0, 1) or "Traceback" in err or (code == 1 and not (len(lines) == 1 and "another run" in err)):
            wrong.append(f"exit code {code}: {' | '.join(lines[-3:])}")
    if 0 not in codes:
        wrong.append("both are refused")
    after = {name: data for name, data in contents(folder).items() if before.get(name) != data}
    expected = [alone(command)[1] for command, code in zip(pair, codes, strict=True) if code == 0]
    names = set().union(*expected)
    if extra := after.keys() - names:
        wrong.append(f"leaves {sorted(extra)}")
    for files in expected:
        same = {name for name in files if after.get(name) == files[name]}
        shared = {name for name in files if sum(name in other for other in expected) > 1}
        if not files.keys() - shared <= same:
            wrong.append(f"{sorted(files.keys() - shared - same)} are not those of the run alone")
    shared = {name for name in names if sum(name in files for files in expected) > 1}
    if shared and not any(all(after.get(name) == files[name] for name in shared) for files in expected):
        wrong.append(f"{sorted(shared)} are those of neither run, or of both")
    return wrong
