"""``geodesic --estimate``: processor time and memory from the first bytes of a file, near those of runs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from geomhw.mesh.primitives import icosphere, torus
from geomhw_cli.runtime import estimate as module
from support.messages import missing
from support.program import contents, one_line, run, save_off


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder."""
    return folder


def header(n: int, name: str = "m.ply") -> str:
    """Write the header of a PLY file without its body."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {n}", "property float x", "property float y"]
    lines += ["property float z", f"element face {2 * n}", "property list uchar int vertex_indices", "end_header", ""]
    Path(name).write_text("\n".join(lines))
    return name


def estimate(mesh: str, *options: str) -> dict:
    """Return the estimate as JSON."""
    answer = run("geodesic", mesh, *options, "--estimate", "--json")
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.stdout)


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="measures a process")
@pytest.mark.parametrize("options", ["--no-png -o d.vtp", "--sources s.txt -o D.npy", "--robust --png d.png -o d.vtp"])
@pytest.mark.parametrize("mesh", [icosphere(4), torus(150, 100)])
def test_memory_is_near_that_of_runs(mesh: object, options: str) -> None:
    """Peak memory of a run is within a factor of two of the estimate."""
    save_off(mesh, "m.off")
    Path("s.txt").write_text("".join(f"{k}\n" for k in range(40)))
    command = [sys.executable, "-m", "geomhw_cli", "geodesic", "m.off", *options.split()]
    # A process of its own: the memory of this one would count for its child.
    code = f"import os, subprocess; p = subprocess.Popen({command!r}, stdout=subprocess.DEVNULL); "
    code += "print(os.wait4(p.pid, 0)[2].ru_maxrss)"
    peak = 1024 * int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
    assert 0.5 < peak / estimate("m.off", *options.split())["memory"] < 2


def test_the_first_bytes_are_enough() -> None:
    """A mesh of which only the header is there: an estimate, the engine for more memory than this, and no file."""
    before = contents(Path(header(300_000_000)).parent)
    found = estimate("m.ply", "--no-png")
    assert (found["mesh"]["vertices"], found["mesh"]["counts"]) == (300_000_000, "header")
    assert found["memory"] > 100e9
    answer = run("geodesic", "m.ply", "--estimate")
    assert not missing(answer.stdout, "memory ... GB")
    assert contents(Path()) == before


@pytest.mark.parametrize(("gigabytes", "engine"), [(1, "petsc"), (1000, "embedded")])
def test_the_engine(gigabytes: int, engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """PETSc is named where memory does not suffice, for the heat method from one set of sources."""
    monkeypatch.setattr(module, "available_memory", lambda: gigabytes * 10**9)
    found = estimate(header(5_000_000))
    assert found["engine"] == engine
    assert any("--engine petsc" in remark for remark in found["remarks"]) == (engine == "petsc")
    for options in (["--method", "exact"], ["--all-pairs"]):
        found = estimate("m.ply", *options)
        assert found["engine"] == "embedded"
        assert any("less memory" in remark for remark in found["remarks"]) == (gigabytes == 1)


OPTIONS = [
    "",
    "--no-png",
    "--method exact",
    "--refine",
    "--robust",
    "--solver direct",
    "--sources s.txt",
    "--all-pairs",
]


@pytest.mark.parametrize("options", [*OPTIONS, "--all-pairs", "--all-pairs --method exact --limit 1 -o D.npz"])
def test_larger_meshes_take_more(options: str) -> None:
    """Both figures grow with the mesh, solvers aside, which change at a size."""
    Path("s.txt").write_text("".join(f"{k}\n" for k in range(40)))
    found = [estimate(header(n), *options.split()) for n in (1_000, 8_000, 30_000, 100_000, 10**6, 10**8)]
    for key in ("processor_seconds", "memory"):
        values = [one[key] for one in found]
        assert values == sorted(values)
        assert values[0] < values[-1]


def test_options_count() -> None:
    """Sources, parts, pictures, refinement and the output as the options have them."""
    mesh, plain = header(30_000), estimate(header(30_000), "--no-png")
    assert plain["method"] == "multigrid"
    assert estimate(mesh, "--no-png", "--solver", "direct")["method"] == "direct"
    assert estimate(mesh, "--no-png", "--robust")["method"] == "refine"
    assert estimate(mesh, "--no-png", "--robust", "--no-refine")["method"] == "multigrid"
    assert estimate(mesh)["memory"] > plain["memory"]
    whole, part = estimate(mesh, "--all-pairs", "--single"), estimate(mesh, "--all-pairs", "--shard", "2/10")
    assert (whole["queries"], whole["output"], whole["method"]) == (30_000, 4 * 30_000**2, "direct")
    assert part["processor_seconds"] < whole["processor_seconds"] / 5
    Path("pairs.txt").write_text("0 1\n0 2\n5 2\n")
    assert estimate(mesh, "--pairs", "pairs.txt")["queries"] == 2
    assert any("--limit" in remark for remark in estimate(mesh, "--method", "exact", "--limit", "1")["remarks"])


def test_files_without_a_size() -> None:
    """Standard input, a missing file and another format are refused; the format of another extension can be given."""
    answer = run("geodesic", "-", "--format", "off", "--estimate")
    assert (answer.exit_code, missing(answer.stderr, "standard input")) == (2, [])
    one_line(run("geodesic", "nowhere.ply", "--estimate"), "nowhere.ply", "no such file")
    assert run("geodesic", __file__, "--estimate").exit_code != 0
    save_off(icosphere(1), "mesh.dat")
    assert estimate("mesh.dat", "--format", "off")["mesh"]["vertices"] == 42
