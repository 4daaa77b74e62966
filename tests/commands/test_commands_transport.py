"""``vecdiffuse`` and ``operators``: files, reports and options."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from geomhw import operators
from geomhw.io import read
from geomhw.mesh.named_points import default_source
from geomhw.mesh.primitives import icosphere
from geomhw.transport.vector_heat import VectorHeat, tangent_at
from support.meshes import split_diagonals, zoo_mesh
from support.program import files, run, save_off

BALL = icosphere(1)
#: The library function of each flag.
OPERATORS = {
    "gradient": operators.gradient,
    "divergence": operators.divergence,
    "stiffness": operators.stiffness,
    "mass": operators.lumped_mass,
    "consistent-mass": operators.consistent_mass,
    "faces-to-vertices": operators.faces_to_vertices,
    "vertices-to-faces": operators.vertices_to_faces,
    "connection": operators.connection_stiffness,
    "complex-connection": operators.complex_connection_stiffness,
}


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(BALL)
    return folder


# -- vecdiffuse --------------------------------------------------------------------------------------------------


def test_vecdiffuse_by_default(folder: Path) -> None:
    """By default ``vecdiffuse`` writes VTK and PNG, two arrays per vertex and the time, and a report in words."""
    answer = run("vecdiffuse", "ball.off")
    assert answer.exit_code == 0
    assert answer.stderr == ""
    assert files(folder) == ["ball.off", "ball.vecdiffuse.png", "ball.vecdiffuse.vtk"]
    written = read("ball.vecdiffuse.vtk")
    places = {field.name: (field.location, np.shape(field.values)) for field in written.fields}
    assert places == {"diffused": ("vertex", (42, 3)), "transported": ("vertex", (42, 3)), "dt": ("mesh", (1,))}
    assert f"source    {default_source(BALL)}\n" in answer.stdout
    for word in ("42 vertices", "dt", "ball.vecdiffuse.vtk", "ball.vecdiffuse.png"):
        assert word in answer.stdout


def test_vecdiffuse_is_the_library() -> None:
    """The arrays in the file equal those of the library, to the last bit."""
    run("vecdiffuse", "ball.off", "--source", "7", "--vector", "1", "0.5", "0", "--dt", "h2", "-o", "a.vtp", "-q")
    expected = VectorHeat(BALL, "h2").from_vertices([7], [[1, 0.5, 0]])
    for name in ("diffused", "transported"):
        np.testing.assert_array_equal(read("a.vtp")[name], expected[name])


def test_several_times(folder: Path) -> None:
    """Repeated ``--dt`` gives numbered arrays in that order, and field data with the times."""
    answer = run("vecdiffuse", "ball.off", "--dt", "h2", "--dt", "0.25", "--dt", "3*h2", "-o", "a.vtk")
    assert answer.exit_code == 0
    written = read("a.vtk")
    h2 = BALL.mean_edge_length**2
    np.testing.assert_allclose(written["dt"], [h2, 0.25, 3 * h2], rtol=1e-15)
    names = {f"{name}_{k}" for name in ("diffused", "transported") for k in range(3)}
    assert {field.name for field in written.fields} == names | {"dt"}
    lengths = [np.linalg.norm(written[f"diffused_{k}"], axis=1).max() for k in range(3)]
    assert lengths[1] > lengths[0] > lengths[2]  # the longer, the flatter
    assert files(folder) == ["a.vtk", "ball.off"]


def test_a_vector_is_laid_on_the_tangent_plane() -> None:
    """The normal component of ``--vector`` is dropped; at the source, `transported` is the tangential part."""
    normal = BALL.vertex_normals[4]
    tangent = tangent_at(BALL, 4, 25.0)
    for name, vector in (("plain.vtp", tangent), ("raised.vtp", tangent + 3 * normal)):
        run("vecdiffuse", "ball.off", "--source", "4", "--vector", *map(repr, vector.tolist()), "-o", name)
    plain, raised = read("plain.vtp"), read("raised.vtp")
    np.testing.assert_allclose(raised["diffused"], plain["diffused"], atol=1e-12)
    for written in (plain, raised):
        np.testing.assert_allclose(written["transported"][4], tangent, atol=1e-14)
        np.testing.assert_allclose(np.einsum("vx,vx->v", written["transported"], BALL.vertex_normals), 0, atol=1e-14)


def test_angle() -> None:
    """``--angle`` counts counterclockwise from the tangent frame, in degrees."""
    run("vecdiffuse", "ball.off", "--source", "4", "--angle", "30", "-o", "a.vtp")
    e1, e2 = BALL.tangent_frames[4]
    np.testing.assert_allclose(read("a.vtp")["transported"][4], np.sqrt(3) / 2 * e1 + e2 / 2, atol=1e-14)


def test_seed() -> None:
    """``--seed`` determines the vector; the default is 0."""
    for name, seed in (("none", []), ("zero", ["--seed", "0"]), ("one", ["--seed", "1"]), ("again", ["--seed", "1"])):
        run("vecdiffuse", "ball.off", *seed, "-o", f"{name}.vtp")
    data = {name: Path(f"{name}.vtp").read_bytes() for name in ("none", "zero", "one", "again")}
    assert data["none"] == data["zero"]
    assert data["one"] == data["again"]
    assert data["zero"] != data["one"]


def test_two_sources_keep_their_lengths() -> None:
    """At two sources the lengths are 1 and 3, in the order of the options, and between them elsewhere."""
    sources = ("--source", "9", "--source", "2")
    vectors = [
        part for s, k in ((9, 1), (2, 3)) for part in ("--vector", *map(repr, (k * tangent_at(BALL, s, 0)).tolist()))
    ]
    run("vecdiffuse", "ball.off", *sources, *vectors, "-o", "a.vtp")
    length = np.linalg.norm(read("a.vtp")["transported"], axis=1)
    np.testing.assert_allclose(length[[9, 2]], [1, 3], rtol=1e-14)
    assert length.min() >= 1 - 1e-12
    assert length.max() <= 3 + 1e-12


def test_one_angle_serves_all_sources() -> None:
    """A single ``--angle`` applies to both of two sources."""
    run("vecdiffuse", "ball.off", "--source", "9", "--source", "2", "--angle", "10", "-o", "a.vtp")
    transported = read("a.vtp")["transported"]
    for source in (2, 9):
        np.testing.assert_allclose(transported[source], tangent_at(BALL, source, 10), atol=1e-14)


def test_connections_differ() -> None:
    """``--connection intrinsic`` gives another field, and the report names it."""
    reports = [
        json.loads(run("vecdiffuse", "ball.off", "--connection", name, "-o", f"{name}.vtp", "--json").stdout)
        for name in ("normals", "intrinsic")
    ]
    assert [report["connection"] for report in reports] == ["normals", "intrinsic"]
    one, other = (read(f"{name}.vtp")["transported"] for name in ("normals", "intrinsic"))
    assert 1e-3 < np.abs(one - other).max() < 1


def test_vecdiffuse_report_is_json() -> None:
    """``--json`` prints command, mesh, sources, vectors, times with their reasons, files and seconds."""
    answer = run("vecdiffuse", "ball.off", "--source", "5", "--angle", "0", "--dt", "h2", "-o", "a.ply", "--json")
    report = json.loads(answer.stdout)
    assert report["command"] == "vecdiffuse"
    assert report["mesh"]["vertices"] == 42
    assert report["sources"] == [5]
    np.testing.assert_allclose(report["vectors"], [tangent_at(BALL, 5, 0)], atol=1e-15)
    assert [step["asked"] for step in report["times"]] == ["h2"]
    assert report["times"][0]["t_over_h2"] == pytest.approx(1)
    assert report["unreachable_vertices"] == 0
    assert report["files"] == ["a.ply"]
    assert set(report["seconds"]) == {"read", "compute", "write"}


def test_vecdiffuse_bytes_repeat() -> None:
    """Two runs write the same bytes, data and picture."""
    names = ["a.vtk", "a.vtp", "a.ply", "a.png"]
    written = []
    for _ in range(2):  # by one command line, which the picture names
        run("vecdiffuse", "ball.off", *(word for name in names[:3] for word in ("-o", name)), "--png", names[3], "-q")
        written.append([Path(name).read_bytes() for name in names])
        for name in names:
            Path(name).unlink()
    assert written[0] == written[1]


def test_component_without_a_source() -> None:
    """Vertices of a component without a source have zero vectors, and a warning counts them."""
    spheres = zoo_mesh("two_spheres")
    save_off(spheres, "two.off")
    answer = run("vecdiffuse", "two.off", "--source", "0", "-o", "a.vtp")
    assert answer.exit_code == 0
    assert "162 vertices" in answer.stdout
    written = read("a.vtp")
    other = np.arange(spheres.n_vertices) >= 162  # the lone vertex, too
    for name in ("diffused", "transported"):
        assert not written[name][other].any()
    np.testing.assert_allclose(np.linalg.norm(written["transported"][~other], axis=1), 1, rtol=1e-12)


def test_vecdiffuse_robust() -> None:
    """``--robust`` accepts faces of zero area, which are refused without it."""
    save_off(split_diagonals(4), "flat.off")
    refused = run("vecdiffuse", "flat.off")
    assert refused.exit_code == 1
    assert "--robust" in refused.stderr
    answer = run("vecdiffuse", "flat.off", "--robust", "--vector", "1", "2", "0", "-o", "a.vtp", "--json")
    report = json.loads(answer.stdout)
    assert report["robust"]["sheets"] == 2
    np.testing.assert_allclose(read("a.vtp")["transported"], np.broadcast_to([1, 2, 0], (41, 3)), atol=1e-12)


# -- operators ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OPERATORS)
def test_each_matrix_is_the_librarys(name: str) -> None:
    """.npz and .mtx files hold the library's matrix to the last bit; the report has its size."""
    expected = OPERATORS[name](BALL)
    for file in ("a.npz", "a.mtx"):
        answer = run("operators", "ball.off", f"--{name}", "-o", file)
        assert answer.exit_code == 0
        rows, columns = expected.shape
        assert answer.stdout.startswith(f"wrote {file}: {name}, {rows} x {columns}, ")
    for found in (sp.load_npz("a.npz"), scipy.io.mmread("a.mtx", spmatrix=False)):
        assert found.shape == expected.shape
        np.testing.assert_array_equal(found.toarray(), expected.toarray())


def test_operators_bytes_repeat() -> None:
    """Two processes write the same bytes."""
    for k in (1, 2):
        for file in (f"{k}.npz", f"{k}.mtx"):
            command = [sys.executable, "-m", "geomhw_cli", "operators", "ball.off", "--connection", "-q", "-o", file]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            assert done.stdout + done.stderr == ""
    for extension in ("npz", "mtx"):
        assert Path(f"1.{extension}").read_bytes() == Path(f"2.{extension}").read_bytes()


@pytest.mark.parametrize("file", ["A.NPZ", "A.MTX"])
def test_extension_in_capitals(file: str, folder: Path) -> None:
    """File extensions in capitals are accepted."""
    assert run("operators", "ball.off", "--mass", "-o", file).exit_code == 0
    found = sp.load_npz(file) if file.endswith("NPZ") else scipy.io.mmread(file, spmatrix=False)
    assert found.trace() == pytest.approx(BALL.face_areas.sum())
    assert files(folder) == [file, "ball.off"]
