"""``geomhw design``: arrays, points, report and refusals."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read, read_cloud
from geomhw.mesh.primitives import cylinder_band, grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.program import run, save_off

pytestmark = pytest.mark.usefixtures("folder")


def test_arrays_points_and_report() -> None:
    """n arrays per vertex; the singularities of the report are those of the points; runs agree."""
    save_off(icosphere(2))
    for name in ("a", "b"):
        line = ["-n", "4", "--points", f"{name}.csv", "-o", f"{name}.vtp", "--json"]
        report = json.loads(run("design", "ball.off", *line).stdout)
    assert report["index_sum"] == report["euler_characteristic"] == 2
    assert [field.name for field in read("a.vtp").fields] == [f"direction_{k}" for k in range(4)]
    with Path("a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["index"]) for row in rows] == [item["index"] for item in report["singularities"]]
    assert [int(row["face"]) for row in rows] == [item["face"] for item in report["singularities"]]
    for name in ("vtp", "csv"):
        assert Path(f"a.{name}").read_bytes() == Path(f"b.{name}").read_bytes()


def test_prescribed_singularities_as_points() -> None:
    """A vertex with index 1 and two faces with 1/2; the directions at a singular vertex are zero."""
    save_off(icosphere(2))
    line = ["-n", "2", "--singularity", "max-z=1", "--singularity", "face:3=0.5"]
    line += ["--singularity", "face:300=1/2", "--points", "p.vtp", "-o", "x.vtp"]
    answer = run("design", "ball.off", *line)
    assert "3 singularities; indices sum to 2, Euler characteristic 2" in answer.stdout
    cloud = read_cloud("p.vtp")
    top = int(np.argmax(icosphere(2).vertices[:, 2]))
    assert cloud["vertex"].tolist() == [top, -1, -1]
    assert cloud["index"].tolist() == [1.0, 0.5, 0.5]
    assert not read("x.vtp")["direction_0"][top].any()


def test_constraints() -> None:
    """Points, curves, the boundary and curvature together, a map alone; open meshes report boundary turns."""
    band = cylinder_band(16, 4)
    save_off(band, "band.off")
    Path("line.txt").write_text("0,16,32\n")
    np.savetxt("map.txt", np.arange(band.n_vertices), fmt="%d")
    for line in (
        ["--align", "5:z", "--align", "face:3:0,0,1"],
        ["--along", "line.txt", "-n", "2"],
        ["--boundary", "--curvature", "1", "-n", "4"],
        ["--map", "map.txt", "-s", "0.5"],
    ):
        report = json.loads(run("design", "band.off", *line, "-o", "x.vtp", "--json").stdout)
        assert report["index_sum"] == 0
        assert len(report["boundary_turns"]) == 2
        assert report["settings"]
    run("design", "band.off", "--align", "5:z", "-o", "x.vtp")
    np.testing.assert_allclose(read("x.vtp")["direction"], np.tile([0.0, 0, 1], (80, 1)), atol=5e-3)


def test_two_meshes_at_once() -> None:
    """The second mesh is written with its field; both have the right sum of indices."""
    save_off(icosphere(1))
    save_off(TriangleMesh(icosphere(1).vertices * [1, 1, 1.2], icosphere(1).faces), "long.off")
    np.savetxt("map.txt", np.arange(42), fmt="%d")
    line = ["--map", "map.txt", "--other", "long.off", "--other-output", "l.vtp", "-o", "x.vtp", "--json"]
    report = json.loads(run("design", "ball.off", *line).stdout)
    assert report["index_sum"] == report["other"]["index_sum"] == 2
    apart = np.asarray(read("x.vtp")["direction"]) - np.asarray(read("l.vtp")["direction"])
    assert np.median(np.linalg.norm(apart, axis=1)) < 0.2


@pytest.mark.parametrize(
    ("line", "code", "word"),
    [
        ("-n 3", 2, "1"),
        ("-s 2", 2, "1"),
        ("--align 5", 2, "no alignment"),
        ("--align 5:0,0,0", 2, "no axis"),
        ("--align max-z:z", 2, "normal to the surface"),
        ("--curvature 1", 2, "2 or 4"),
        ("--singularity 5", 2, "no singularity"),
        ("--singularity 5=1", 2, "Euler characteristic, 2"),
        ("--singularity 5=1.3 --singularity 9=0.7", 2, "multiple of 1/1"),
        ("--singularity 5=2 --boundary", 2, "exclude"),
        ("--singularity face:5=2", 2, "too coarse"),
        ("--singularity 5=2 -s 1", 2, "--energy"),
        ("--singularity 5=2 --map a.txt", 2, "no such file"),
        ("--points p.xyz", 2, ".csv"),
        ("--other ball.off", 2, "go together"),
        ("--singularity 5=2 --relax 3", 2, "--relax"),
        ("-n 6 --singularity 0=1 --singularity 0=1", 2, "too coarse"),
    ],
)
def test_refusals(line: str, code: int, word: str) -> None:
    """What cannot be computed is one sentence."""
    save_off(icosphere(1))
    answer = run("design", "ball.off", *line.split(), "-o", "x.vtp")
    assert answer.exit_code == code or (answer.exit_code == 1 and "no such file" in answer.stderr)
    assert word in answer.stderr
    assert answer.stderr.count("Error") <= 1


def test_boundary_vertices_and_meshes_that_are_not_manifold() -> None:
    """Singular boundary vertices, edges of three faces and one-sided surfaces are one sentence."""
    save_off(grid(4, 4), "plate.off")
    assert "boundary" in run("design", "plate.off", "--singularity", "0=1", "-o", "x.vtp").stderr
    Path("fan.off").write_text("OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 -1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 1 4\n")
    answer = run("design", "fan.off", "-o", "x.vtp")
    assert answer.exit_code == 1
    assert "3 faces meet at edge 0-1" in answer.stderr
    Path("pair.off").write_text("OFF\n6 2 0\n0 0 0\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n7 7 7\n3 0 1 2\n3 0 3 4\n")
    assert run("design", "pair.off", "-n", "4", "-o", "x.vtp").exit_code == 0
