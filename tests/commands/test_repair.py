"""``geomhw repair``: each step is counted, arrays follow, and the result has no defect that it repairs."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import MeshError
from geomhw.io import read, write
from geomhw.mesh import TriangleMesh, findings, icosphere, repair
from geomhw.results import Field, Result
from support.messages import missing
from support.program import run

pytestmark = pytest.mark.usefixtures("folder")


def broken_sphere(seed: int, size: float = 1.0) -> tuple[TriangleMesh, TriangleMesh]:
    """A sphere, and the same as separate triangles with cracks, copies, reversed faces and loose vertices."""
    chance, ball = np.random.default_rng(seed), icosphere(2)
    soup = ball.vertices[ball.faces].reshape(-1, 3)
    soup = soup + 1e-9 * chance.standard_normal(soup.shape)
    points = np.concatenate([soup, chance.random((7, 3))])
    faces = np.arange(len(soup)).reshape(-1, 3)
    flipped = np.where(chance.random(len(faces))[:, None] < 0.3, faces[:, ::-1], faces)
    return ball, TriangleMesh(size * points, np.concatenate([flipped, faces[[3, 8, 8]]]))


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_a_broken_sphere_is_whole_again(size: float) -> None:
    """Separate triangles become the sphere, at any size."""
    ball, mesh = broken_sphere(4, size)
    done = repair(mesh)
    assert (done.mesh.n_vertices, done.mesh.n_faces) == (ball.n_vertices, ball.n_faces)
    assert not [found for found in findings(done.mesh) if found.kind == "defect"]
    assert done.steps["welded_vertices"] == 3 * ball.n_faces - ball.n_vertices
    assert done.steps["duplicate_faces"] == 3
    assert done.steps["unreferenced_vertices"] == 7
    assert done.steps["reversed_faces"] > 0
    np.testing.assert_array_equal(done.mesh.vertices, mesh.vertices[done.vertices])


def test_repaired_meshes_stay_as_they_are() -> None:
    """Repairing twice changes nothing, nor does repairing a sound mesh."""
    for mesh in (icosphere(2), repair(broken_sphere(1)[1]).mesh):
        done = repair(mesh)
        assert set(done.steps.values()) == {0}
        np.testing.assert_array_equal(done.mesh.vertices, mesh.vertices)
        np.testing.assert_array_equal(done.mesh.faces, mesh.faces)


@pytest.mark.parametrize("columns", [(), (3,)])
def test_arrays_of_a_sound_mesh(columns: tuple[int, ...]) -> None:
    """Arrays at vertices are carried over where no vertices are joined."""
    mesh = icosphere(1)
    values = np.arange(42.0 * (columns or (1,))[0]).reshape(42, *columns)
    write(Result(mesh, [Field("u", "vertex", values)]), "in.vtp")
    answer = run("repair", "in.vtp", "-o", "out.vtp")
    assert answer.exit_code == 0, answer.output
    np.testing.assert_array_equal(read("out.vtp")["u"], values)


def test_degenerate_faces() -> None:
    """Faces of zero area, and faces that welding folds, are removed; if none is left, that is an error."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [0, 1e-9, 0]]
    done = repair(TriangleMesh(points, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]))
    assert done.steps == {
        "welded_vertices": 1,
        "degenerate_faces": 2,
        "duplicate_faces": 0,
        "reversed_faces": 0,
        "unreferenced_vertices": 1,
    }
    assert done.faces.tolist() == [0]
    with pytest.raises(MeshError, match="zero area"):
        repair(TriangleMesh(points, [[0, 1, 3]]))


@pytest.mark.parametrize("extension", ["vtk", "vtp", "vtu", "ply"])
def test_arrays_follow(extension: str) -> None:
    """Arrays on vertices and faces keep their values; values that differ at joined vertices are counted."""
    mesh = broken_sphere(2)[1]
    fields = [
        Field("height", "vertex", mesh.vertices[:, 0]),
        Field("number", "vertex", np.arange(mesh.n_vertices)),
        Field("face", "face", np.arange(mesh.n_faces)),
    ]
    write(Result(mesh, fields), "in.vtp")
    answer = run("repair", "in.vtp", "-o", f"out.{extension}")
    assert answer.exit_code == 0
    assert not missing(
        answer.stdout, "step ... joined ... zero area ... 3 faces with ... reversed ... 7 vertices ... note"
    )
    assert "array 'number' has other values" in answer.stdout
    result, done = read(f"out.{extension}"), repair(mesh)
    np.testing.assert_array_equal(result["number"], done.vertices)
    np.testing.assert_array_equal(result["face"], done.faces)
    np.testing.assert_array_equal(result["height"], mesh.vertices[done.vertices, 0])


def test_tolerance_and_report() -> None:
    """``--tolerance`` is a length; ``--json`` has the counts; ``-q`` prints nothing."""
    write(Result(broken_sphere(3)[1]), "in.vtk")
    exact = json.loads(run("repair", "in.vtk", "-o", "a.ply", "--tolerance", "0", "--json").stdout)
    wide = json.loads(run("repair", "in.vtk", "-o", "b.ply", "--json").stdout)
    assert exact["tolerance"] == 0 < wide["tolerance"]
    assert exact["steps"]["welded_vertices"] < wide["steps"]["welded_vertices"]
    assert wide["files"] == ["b.ply"]
    assert run("repair", "in.vtk", "-o", "c.ply", "-q").stdout == ""
    assert Path("c.ply").read_bytes() == Path("b.ply").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["in.vtk"], 2, "-o"),
        (["in.vtk", "-o", "in.vtk"], 1, "in.vtk"),
        (["in.vtk", "-o", "a.off"], 2, "a.off"),
        (["in.vtk", "-o", "a.ply", "--tolerance", "-1"], 2, "--tolerance"),
        (["in.vtk", "-o", "a.ply", "--tolerance", "nan"], 2, "--tolerance"),
        (["in.vtk", "-o", "a.ply", "--tolerance", "1e300"], 2, "1e300"),
    ],
)
def test_refusals(arguments: list[str], code: int, words: str) -> None:
    """Wrong values are refused, and no file is written."""
    write(Result(icosphere(1)), "in.vtk")
    answer = run("repair", *arguments)
    assert answer.exit_code == code
    assert words in answer.stderr
    assert [path.name for path in Path().iterdir()] == ["in.vtk"]
