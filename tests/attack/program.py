"""Commands of every kind of output on small meshes, as processes, and the files that they leave."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from geomhw.mesh.primitives import icosphere, torus
from support.program import contents, save_off

FLOW = "--field rigid:z --color x --dt 0.01 --steps 60 --every 5"
FLUID = "--force none --dt 0.01 --steps 60 --every 5"
#: Commands by the kind of their output.
COMMANDS = {
    "mesh": "geodesic ball.off --no-png -o a.vtk -o b.vtp -o c.vtu -o d.ply",
    "picture": "geodesic ball.off -o a.vtk --png a.png",
    "transport": "vecdiffuse ball.off -o t.vtp --png t.png",
    "parts": "helmholtz ball.off --field wind.npy -o h.vtu --png h.png",
    "matrix": "geodesic ring.off --all-pairs --time h2 -o D.npy",
    "exact matrix": "geodesic ring.off --all-pairs --method exact -o E.npy",
    "marching": "geodesic ring.off --method fast-marching --source face:3 --limit 1 -o m.vtp --png m.png",
    "sparse": "geodesic ring.off --all-pairs --method exact --limit 1 -o near.npz",
    "operator": "operators ball.off --stiffness -o S.mtx",
    "series": f"advect ball.off {FLOW} -o s.pvd --csv s.csv --tracers 20",
    "film": f"advect ball.off {FLOW} -o g.pvd --gif g.gif --png g.png --width 200",
    "mp4": "advect ball.off --dt 0.01 --steps 10 --every 2 -o m.pvd --mp4 m.mp4 --width 200",
    "fluid": f"fluid ball.off {FLUID} -o f.pvd --csv f.csv",
    "fluid film": f"fluid ball.off {FLUID} -o k.pvd --gif k.gif --width 200",
    "repair": "repair ball.off -o r.ply",
    "path": "path ball.off --from 0 --to 9 -o p.vtp -o p.csv --png p.png --svg p.svg",
    "trace": "trace ball.off --length 2 --fan 8 -o t.csv --pdf t.pdf",
    "logmap": "logmap ball.off -o l.vtp --png l.png --view front",
    "center": "center ball.off --points 0,30,60 -o c.vtp --png c.png --view front",
    "voronoi": "voronoi ball.off --sites 5 -o v.vtp --png v.png --view front",
    "sample": "sample ball.off --count 9 -o s.vtp --png s.png --view front",
    "spectrum": "spectrum ball.off -k 8 --signature hks -o e.vtu --png e.png",
    "killing": "killing ball.off -k 4 -o k.vtp --png k.png",
    "design": "design ball.off -n 4 --points p.csv -o d.vtp --png d.png",
    "bracket": "bracket ball.off --field wind.npy --field rigid:z -o b.vtp --png b.png",
    "derivatives": "derive ball.off --field wind.npy -o j.vtu --png j.png",
    "pushed": "push ball.off --field wind.npy --by rigid:z --time 0.2 --frames 3 -o u.pvd --csv u.csv --width 200",
    "extrema": "extrema ball.off --array height.npy -o x.vtp --png x.png",
    "gradient": "gradient ball.off --array height.npy -o y.vtp --png y.png",
    "smooth": "smooth ball.off --array height.npy --fwhm 0.5 -o z.csv --png z.png",
    "isolines": "isolines ball.off --array height.npy --count 3 -o i.vtp -o i.json --png i.png",
    "regions": "rois ball.off --center 0 --center 9 --radius 0.5 -o q.vtp --png q.png",
    "signed": "signed ball.off --curve equator.csv -o d.vtp --png d.png",
    "split": "split ball.off --curve equator.csv -o w.vtp --pieces half.ply --png w.png",
    "streamlines": "streamlines ball.off --field rigid:z --spacing 0.3 -o n.vtp -o n.csv --png n.png",
    "batch": "batch geodesic ball.off ring.off --out many -- --no-png",
    "shard": "geodesic ring.off --all-pairs --shard 1/2 -o D.1.shard",
    "page": "view ball.off -o v.html",
    "folder": f"fluid ball.off {FLUID} --width 200",
    "info": "info ball.off --json",
    "compare": "compare ball.off ring.off",
}
#: Files that grow during a run, and are valid at every length.
GROWING = (".pvd", ".vtp.series", ".csv", ".restart.npz", ".partial.npy", ".partial.json")
SECONDS = 120


@dataclass(frozen=True)
class Reference:
    """What a command writes and how long it takes when nothing disturbs it."""

    code: int
    seconds: float
    files: dict[str, bytes]


def outputs(folder: Path) -> dict[str, bytes]:
    """Return every file of a folder, the reports of a batch without times and paths."""
    return {
        name: _untimed(data) if name.endswith(("report.json", "outcome.json")) else data
        for name, data in contents(folder).items()
    }


def _untimed(data: bytes) -> bytes:
    """Return a report without what differs between runs; the bytes themselves if they are not a whole report."""
    try:
        report = json.loads(data)
    except ValueError:
        return data
    return json.dumps(
        {k: v for k, v in report.items() if k not in ("key", "input", "seconds", "profile", "files")}
    ).encode()


@contextmanager
def prepared() -> Iterator[Path]:
    """Make a folder with two meshes, a field, a vertex array and a curve."""
    with tempfile.TemporaryDirectory(prefix="geomhw-attack-") as name:
        folder = Path(name)
        save_off(icosphere(2), str(folder / "ball.off"))
        save_off(torus(40, 24), str(folder / "ring.off"))
        rng, angle = np.random.default_rng(0), np.linspace(0, 2 * np.pi, 33)
        np.save(folder / "wind.npy", rng.normal(size=(320, 3)))
        np.save(folder / "height.npy", rng.normal(size=162))
        circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        np.savetxt(folder / "equator.csv", circle, delimiter=",", header="x,y,z", comments="")
        yield folder


def start(command: str, folder: Path) -> "subprocess.Popen[str]":
    """Start a command in a folder, without signals that are ignored and without other variables of the user."""
    env = {name: value for name, value in os.environ.items() if not name.startswith("GEOMHW_")}
    words = [sys.executable, "-P", "-m", "geomhw_cli", *command.split()]
    if sys.version_info < (3, 11):
        words.remove("-P")
    pipe = subprocess.PIPE
    return subprocess.Popen(
        words, cwd=folder, env=env, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True, errors="replace"
    )


def finished(command: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run a command to its end."""
    with start(command, folder) as process:
        out, err = process.communicate(timeout=SECONDS)
    return subprocess.CompletedProcess(command, process.returncode, out, err)


@lru_cache
def reference(kind: str) -> Reference:
    """Return what the command of this kind writes and how long it takes."""
    with prepared() as folder:
        before = outputs(folder)
        finished(COMMANDS[kind], folder)  # loads the program and compiles its loops
        for name in outputs(folder).keys() - before.keys():
            (folder / name).unlink()
        started = time.monotonic()
        code = finished(COMMANDS[kind], folder).returncode
        seconds = time.monotonic() - started
        files = {name: data for name, data in outputs(folder).items() if name not in before}
        return Reference(code, seconds, files)


def fresh(template: Path, folder: Path) -> Path:
    """Return a new copy of a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)
    return folder


def wrong_files(kind: str, folder: Path, before: dict[str, bytes]) -> list[str]:
    """Return what is wrong with the files that a stopped run left: cut off, mixed, forgotten, or changed inputs."""
    expected, found, wrong = reference(kind).files, outputs(folder), []
    for name, data in found.items():
        if data == before.get(name) or data == expected.get(name):
            continue
        if Path(name).name.startswith("."):
            wrong.append(f"leaves {name}")
        elif name in before and name not in expected:
            wrong.append(f"changes its input {name}")
        elif not name.endswith(GROWING):
            wrong.append(f"leaves a part of {name}")
    wrong += [f"removes {name}" for name in before.keys() - found.keys() if name not in expected]
    return wrong + [words for path in folder.rglob("*.pvd") for words in _wrong_series(path, before)]


def _wrong_series(path: Path, before: dict[str, bytes]) -> list[str]:
    """Return what is wrong with a series: an index that is no index, or names frames that are not there."""
    from geomhw.errors import GeomhwError
    from geomhw.io import read_series

    if path.read_bytes() == before.get(path.name):
        return []
    try:
        frames = read_series(path)
    except GeomhwError as error:
        return [str(error)]
    missing = [frame.file for frame in frames if not (path.parent / frame.file).exists()]
    return [f"{path.name} names missing frames, the first of which is {missing[0]}"] if missing else []
