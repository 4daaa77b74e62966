"""The same input gives the same bytes, for any threads, locale, hash seed, time zone and folder."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import write
from geomhw.mesh.primitives import torus
from geomhw.results import Field, Result
from support.meshes import crumpled
from support.pictures import needs_opengl

MESH = crumpled(torus(16, 10))
FLOW = "--dt 0.01 --steps 4 --every 2"
#: All commands that write files, with their options; their output is compared, too.
COMMANDS = [
    "info torus.ply --json",
    "geodesic torus.ply --source 5 -o g.vtk -o g.vtp -o g.vtu -o g.ply --json",
    "geodesic torus.ply --robust -o robust.vtp --json",
    "geodesic torus.ply --refine --time h2 -o refined.vtp --json",
    "geodesic torus.ply --source 1-9 --robust --solver multigrid -o multigrid.vtp --json",
    "geodesic torus.ply --all-pairs -o all.npy --json",
    "geodesic torus.ply --all-pairs --robust --single -o robust.npy --json",
    "info torus.ply --check --json",
    "vecdiffuse torus.ply --source 3 --source 40 --dt h2 --dt 0.1 -o v.ply --json",
    "vecdiffuse torus.ply --robust -o vr.vtp --json",
    "killing torus.ply -k 3 -o k.vtp --json",
    "design torus.ply -n 4 --points p.csv -o d.vtp --json",
    "vecdiffuse torus.ply --connection intrinsic -o vi.vtp --json",
    f"advect torus.ply {FLOW} --field rigid:y -o a.pvd --csv a.csv --tracers 9 --json",
    f"advect torus.ply {FLOW} --integrator expm -o k.pvd --csv k.csv --json",
    f"fluid torus.ply {FLOW} --init random:1 -o f.pvd --csv f.csv --tracers 9 --json",
    "fluid torus.ply --scheme fast --force none --cfl 1 --until 0.02 --every 2 -o ff.pvd --csv ff.csv --json",
    f"fluid torus.ply {FLOW} --scheme handout --init harmonic:0 -o fh.pvd --csv fh.csv --json",
    "helmholtz torus.ply --field torus.ply:v -o h.vtu --json",
    "operators torus.ply --connection -o C.npz",
    "operators torus.ply --gradient -o G.mtx",
    "compare g.vtp g.vtu --json",
]
PICTURES = [
    "geodesic torus.ply --source 5 -o p.vtk --png g.png --json",
    "vecdiffuse torus.ply --source 3 -o p.vtk --png v.png --json",
    "helmholtz torus.ply --field torus.ply:v -o p.vtk --png h.png --json",
    "advect torus.ply --dt 0.01 --steps 1 -o p.pvd --mp4 p.mp4 --png p.png --json",
    "compare g.png v.png --diff d.png --json",
]
ONE = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "PYTHONHASHSEED": "1",
    "LC_ALL": "C.UTF-8",
    "TZ": "UTC",
    "LP_NUM_THREADS": "4",  # threads of Mesa
}
OTHER = {
    "OPENBLAS_NUM_THREADS": "4",
    "OMP_NUM_THREADS": "4",
    "PYTHONHASHSEED": "2",
    "LC_ALL": "de_DE.UTF-8",  # where it is not installed, C
    "LC_NUMERIC": "de_DE.UTF-8",
    "PYTHONCOERCECLOCALE": "0",
    "PYTHONUTF8": "0",
    "TZ": "Asia/Kathmandu",
    "COLUMNS": "40",
    "LP_NUM_THREADS": "1",
}
#: Several commands in one process, to import VTK once; their output becomes ``stdout.txt``.
PROGRAM = """
import contextlib, io, sys
from geomhw_cli import main
printed = io.StringIO()
with contextlib.redirect_stdout(printed):
    for line in sys.stdin.read().splitlines():
        sys.argv[1:] = line.split()
        with contextlib.suppress(SystemExit):
            main.main()
with open("stdout.txt", "w", encoding="utf-8") as stream:
    stream.write(printed.getvalue())
"""


def files_of(folder: Path, commands: list[str], environment: dict[str, str]) -> dict[str, bytes]:
    """Return all files that the commands write in a folder, and their output without seconds."""
    folder.mkdir(parents=True)
    vectors = np.random.default_rng(0).normal(size=(MESH.n_faces, 3))
    write(Result(MESH, [Field("v", "face", vectors)]), folder / "torus.ply")
    plain = {key: value for key, value in os.environ.items() if not key.startswith(("LC_", "LANG"))}
    answer = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        input="\n".join(commands),
        text=True,
        cwd=folder,
        env=plain | environment,
        capture_output=True,
    )
    assert answer.returncode == 0, answer.stderr
    # The first run of a machine compiles.
    assert [line for line in answer.stderr.splitlines() if not line.startswith("compiling loops")] == []
    found = {path.name: path.read_bytes() for path in folder.iterdir()}
    found["stdout.txt"] = without_seconds(found["stdout.txt"])
    shutil.rmtree(folder)
    return found


def without_seconds(printed: bytes) -> bytes:
    decoder, text, kept = json.JSONDecoder(), printed.decode(), []
    while text := text.strip():
        if text.startswith("{"):
            report, end = decoder.raw_decode(text)
            report.pop("seconds", None)
            report.pop("profile", None)
            kept.append(json.dumps(report))
        else:
            end = text.find("\n") % (len(text) + 1)
            kept.append(text[:end])
        text = text[end:]
    return "\n".join(kept).encode()


@pytest.mark.parametrize("commands", [COMMANDS, pytest.param(PICTURES, marks=needs_opengl)], ids=["data", "pictures"])
def test_same_bytes(commands: list[str], tmp_path: Path) -> None:
    """Every file and every report of every command is byte-identical in two environments."""
    one = files_of(tmp_path / "one", commands, ONE)
    other = files_of(tmp_path / "another place" / "much deeper", commands, OTHER)
    assert one.keys() == other.keys()
    assert [name for name in one if one[name] != other[name]] == []
    asked = {word for command in commands for word in command.split() if "." in word and word[0].isalpha()}
    assert {word for word in asked if word.rpartition(".")[2] in ("vtk", "vtp", "ply", "png", "csv", "npz")} <= set(one)


def test_blas_has_one_thread() -> None:
    """The program restricts BLAS to one thread, since sums depend on the number of threads."""
    program = (
        "import contextlib, sys; sys.argv[1:] = ['--version']\n"
        "from geomhw_cli.main import main\n"
        "with contextlib.suppress(SystemExit): main()\n"
        "import numpy, scipy.linalg, threadpoolctl\n"
        "print({pool['num_threads'] for pool in threadpoolctl.threadpool_info()})"
    )
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
    answer = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert answer.stdout.splitlines()[-1] == "{1}", answer


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no way to take processors away here")
def test_film_on_one_processor(tmp_path: Path) -> None:
    """A film has the same bytes on one processor as on several."""
    from geomhw.io.artifacts.films import write_mp4

    noise = np.random.default_rng(0).integers(0, 256, (30, 40, 3), dtype=np.uint8)
    images = [np.roll(np.kron(noise, np.ones((8, 8, 1), np.uint8)), 7 * k, axis=1) for k in range(30)]
    processors = os.sched_getaffinity(0)
    write_mp4(tmp_path / "all.mp4", images)
    try:
        os.sched_setaffinity(0, {min(processors)})
        write_mp4(tmp_path / "one.mp4", images)
    finally:
        os.sched_setaffinity(0, processors)
    assert (tmp_path / "all.mp4").read_bytes() == (tmp_path / "one.mp4").read_bytes()
