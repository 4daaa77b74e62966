"""``mpirun -n K geomhw geodesic MESH --engine petsc``: files, report, options, and ranks that fail."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista

from geomhw.geodesic import HeatDistance
from geomhw.io import read, write
from geomhw.mesh import TriangleMesh
from geomhw.mesh.primitives import icosphere, moebius_band
from geomhw.results import Result
from support.hostile import flipped, pinched_meshes
from support.meshes import book

BALL = icosphere(4)
ENVIRONMENT = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
GEOMHW = [sys.executable, "-m", "geomhw_cli"]


def command(ranks: int, *arguments: str, name: str = "geodesic") -> list[str]:
    start = ["mpirun", "--oversubscribe", "--quiet", "-n", str(ranks)] if ranks else []
    return [*start, *GEOMHW, name, *arguments, "--engine", "petsc"]


def over_ranks(ranks: int, folder: Path, *arguments: str, name: str = "geodesic") -> "subprocess.CompletedProcess[str]":
    words = command(ranks, *arguments, name=name)
    return subprocess.run(words, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write(Result(BALL), tmp_path / "ball.ply")
    return tmp_path


@pytest.fixture(scope="module")
def distance() -> np.ndarray:
    return np.asarray(HeatDistance(BALL, "h2", solver="direct").from_vertices([7])["distance"])


def opened(path: Path) -> Any:
    """Return what VTK reads from an index of pieces, as ParaView does."""
    from vtkmodules.vtkIOXML import vtkXMLPPolyDataReader, vtkXMLPUnstructuredGridReader

    reader = vtkXMLPUnstructuredGridReader() if path.suffix == ".pvtu" else vtkXMLPPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def sentences(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("Error: ")]


@pytest.mark.parametrize("ranks", [0, 1, 3])
def test_files(ranks: int, folder: Path, distance: np.ndarray) -> None:
    """Pieces that VTK opens, and files in the order of the input, with equal distances; also without mpirun."""
    outputs = ["a.pvtu", "a.pvtp", "a.vtu", "a.vtp", "a.npy"]
    options = [word for name in outputs for word in ("-o", name)]
    answer = over_ranks(ranks, folder, "ball.ply", "--source", "7", *options, "--json")
    assert answer.returncode == 0, answer.stderr
    report = json.loads(answer.stdout)
    assert report["engine"]["ranks"] == max(ranks, 1)
    assert sum(report["engine"]["vertices"]) == BALL.n_vertices
    assert report["engine"]["bytes_per_vertex"] > 0
    assert report["farthest"]["distance"] == pytest.approx(distance.max(), rel=1e-8)
    assert set(report["files"]) == {path.name for path in folder.iterdir()} - {"ball.ply"}
    for name in outputs[:2]:
        whole = pyvista.wrap(opened(folder / name))
        assert whole.n_cells == BALL.n_faces
        assert np.allclose(whole["distance"], distance[whole["vertex"]], rtol=0, atol=1e-8)
        assert np.array_equal(whole.points, BALL.vertices[whole["vertex"]])
        corners = whole["vertex"][whole.cells_dict[5] if name == "a.pvtu" else whole.regular_faces]
        assert {tuple(sorted(face)) for face in corners.tolist()} == {tuple(sorted(f)) for f in BALL.faces.tolist()}
    for name in outputs[2:4]:
        found = read(folder / name)
        assert np.array_equal(found.mesh.faces, BALL.faces)
        assert np.array_equal(found.mesh.vertices, BALL.vertices)
        assert np.allclose(found["distance"], distance, rtol=0, atol=1e-8)
        assert pyvista.read(folder / name).n_cells == BALL.n_faces
    assert np.allclose(np.load(folder / "a.npy"), distance, rtol=0, atol=1e-8)


def test_sources(folder: Path) -> None:
    """Sources in faces and near places, with their remarks, as one process has them."""
    sources = ["ball.ply", "--source", "face:3:0.2,0.3,0.5", "--source", "near:0,0,1.5", "--source", "12-14", "--time"]
    report = json.loads(over_ranks(2, folder, *sources, "h2", "--json", "-o", "a.npy").stdout)
    alone = [*GEOMHW, "geodesic", *sources, "h2", "-o", "b.vtp", "--json"]
    expected = json.loads(subprocess.run(alone, cwd=folder, check=True, capture_output=True, text=True).stdout)
    assert sorted(map(str, report["sources"])) == sorted(map(str, expected["sources"]))
    assert [line for line in report["remarks"] if "near:0,0,1.5" in line]
    assert set(report["remarks"]) <= set(expected["remarks"])
    assert np.abs(np.load(folder / "a.npy") - read(folder / "b.vtp")["distance"]).max() <= 1e-8


def test_vectors(folder: Path) -> None:
    """``vecdiffuse`` writes pieces and gathered files with the vectors of one process, also for the default angle."""
    options = ["ball.ply", "--source", "7", "--source", "2000", "--angle", "30", "--angle", "-70.5", "--dt", "h2"]
    files = ["--dt", "0.5*h2", "-o", "a.pvtp", "-o", "a.vtu"]
    answer = over_ranks(3, folder, *options, *files, "--json", name="vecdiffuse")
    assert answer.returncode == 0, answer.stderr
    report = json.loads(answer.stdout)
    assert set(report["files"]) == {path.name for path in folder.iterdir()} - {"ball.ply"}
    alone = [*GEOMHW, "vecdiffuse", *options, "--dt", "0.5*h2", "--solver", "direct", "-o", "b.vtp", "--json"]
    expected = json.loads(subprocess.run(alone, cwd=folder, check=True, capture_output=True, text=True).stdout)
    assert report["sources"] == expected["sources"] == [7, 2000]
    assert np.allclose(report["vectors"], expected["vectors"], rtol=0, atol=1e-12)
    assert [step["t_over_h2"] for step in report["times"]] == pytest.approx([1, 0.5])
    known, gathered, pieces = read(folder / "b.vtp"), read(folder / "a.vtu"), pyvista.wrap(opened(folder / "a.pvtp"))
    for name in ("diffused_0", "transported_0", "diffused_1", "transported_1"):
        scale = np.linalg.norm(known[name], axis=1).max()
        away = np.linalg.norm(known[name] - gathered[name], axis=1) <= 1e-8 * scale
        assert away.mean() > 0.97  # the cut locus
        assert np.array_equal(pieces[name], gathered[name][pieces["vertex"]])


VECTOR_MESHES = {
    "one-sided": lambda: moebius_band(40, 4),
    "pinched": lambda: TriangleMesh(*pinched_meshes()["pinched_torus"]),
    "edges of three faces": book,
    "faces turned": lambda: TriangleMesh(*flipped((BALL.vertices, BALL.faces))),
}


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
@pytest.mark.parametrize("name", VECTOR_MESHES)
def test_vectors_on_any_surface(name: str, connection: str, folder: Path) -> None:
    """The vector at the default angle, the vectors and the remarks are those of one process."""
    write(Result(VECTOR_MESHES[name]()), folder / "mesh.ply")
    options = ["mesh.ply", "--source", "5", "--dt", "h2", "--connection", connection, "--json"]
    answer = over_ranks(3, folder, *options, "-o", "a.vtu", name="vecdiffuse")
    assert answer.returncode == 0, answer.stderr
    alone = [*GEOMHW, "vecdiffuse", *options, "--solver", "direct", "-o", "b.vtu"]
    expected = json.loads(subprocess.run(alone, cwd=folder, check=True, capture_output=True, text=True).stdout)
    report = json.loads(answer.stdout)
    assert np.allclose(report["vectors"], expected["vectors"], rtol=0, atol=1e-12)
    assert (report["remarks"], report["connection"]) == (expected["remarks"], connection)
    assert report["mesh"]["mean_edge_length"] == pytest.approx(expected["mesh"]["mean_edge_length"], rel=1e-12)
    found, known = (read(folder / path)["diffused"] for path in ("a.vtu", "b.vtu"))
    assert np.abs(found - known).max() <= 1e-8 * np.linalg.norm(known, axis=1).max()


@pytest.mark.parametrize(
    ("arguments", "words", "code"),
    [
        (["ball.ply", "--robust"], ["--robust", "--engine petsc"], 2),
        (["ball.ply", "--solver", "direct"], ["--solver", "--engine petsc"], 2),
        (["ball.ply", "--source", "7", "--angle", "1", "--angle", "2"], ["2 times", "1 source"], 2),
        (["ball.ply", "--source", "7", "--vector", "0", "0", "0"], ["zero"], 2),
        (["ball.ply", "-o", "a.npy"], [".npy", ".pvtu"], 2),
    ],
)
def test_refused_vectors(arguments: list[str], words: list[str], code: int, folder: Path) -> None:
    """What ``vecdiffuse`` does not have over ranks is refused in one sentence, and no file is left."""
    before = {path.name for path in folder.iterdir()}
    answer = over_ranks(2, folder, *arguments, name="vecdiffuse")
    (sentence,) = sentences(answer.stderr)
    assert all(word in sentence for word in words), sentence
    assert answer.returncode == code
    assert {path.name for path in folder.iterdir()} == before


def test_default_source_and_file(folder: Path) -> None:
    """By default the source is the vertex of largest y, and the file a .pvtu."""
    answer = over_ranks(2, folder, "ball.ply", "--json")
    expected = HeatDistance(BALL, "h2").from_vertices([int(BALL.vertices[:, 1].argmax())])
    report = json.loads(answer.stdout)
    assert report["sources"] == [int(BALL.vertices[:, 1].argmax())]
    assert report["mean_distance"] == pytest.approx(expected.report["mean_distance"], rel=1e-8)
    assert (folder / "ball.geodesic.pvtu").exists()


@pytest.mark.parametrize(
    ("arguments", "words", "code"),
    [
        (["ball.ply", "--robust"], ["--robust", "--engine petsc"], 2),
        (["ball.ply", "--png", "a.png"], ["--png", "--engine petsc"], 2),
        (["ball.ply", "--source", "boundary"], ["sources", "face:17"], 2),
        (["ball.ply", "--source", "face:99999"], ["face 99999"], 2),
        (["ball.ply", "--source", "99999"], ["99999"], 2),
        (["ball.ply", "--time", "-1"], ["time"], 2),
        (["ball.ply", "-o", "a.obj"], [".obj", ".pvtu"], 2),
        (["ball.ply", "-o", "none/a.pvtu"], ["none"], 1),
        (["ball.obj"], [".obj", "PLY"], 1),
        (["text.ply"], ["text", "PLY"], 1),
        (["-"], ["standard input"], 2),
    ],
)
def test_refused(arguments: list[str], words: list[str], code: int, folder: Path) -> None:
    """What the engine does not have or cannot read is refused in one sentence, by one rank, and no file is left."""
    write(Result(BALL), folder / "ball.vtk")
    (folder / "ball.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "text.ply").write_text("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n")
    before = {path.name for path in folder.iterdir()}
    answer = over_ranks(2, folder, *arguments)
    (sentence,) = sentences(answer.stderr)
    assert all(word in sentence for word in words), sentence
    assert answer.returncode == code
    assert answer.stdout == ""
    assert {path.name for path in folder.iterdir()} == before


KILLED = """
import os, signal
import geomhw.distributed
from geomhw_cli.main import main

distribute = geomhw.distributed.distribute

def distributed(ranks, file):
    mesh = distribute(ranks, file)
    if ranks.rank == ranks.size - 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return mesh

geomhw.distributed.distribute = distributed
main()
"""


def test_killed_rank(folder: Path) -> None:
    """When a rank is killed, mpirun ends the others with its exit code; one sentence, and no file is left."""
    words = command(2, "ball.ply", "-o", "a.pvtu")
    start = words.index("-m")
    words[start : start + 2] = ["-c", KILLED]
    run = subprocess.run(words, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    (sentence,) = sentences(run.stderr)
    assert "killed" in sentence
    assert run.returncode == 128 + signal.SIGKILL
    assert [path.name for path in folder.iterdir()] == ["ball.ply"]
