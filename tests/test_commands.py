"""The program as a user runs it: what it writes, says and refuses. Every test reopens what was written."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from conftest import needs_reference, reference, split_diagonals, zoo_mesh
from PIL import Image
from test_render import needs_opengl

from geomhw.compare import Ignored, Tolerance, compare_named
from geomhw.io import read, read_csv, write
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field
from geomhw.results import Result as MeshResult
from geomhw_cli.main import program


def run(*arguments: str | Path) -> Result:
    """The program's answer; anything but a clean exit of its own is an error of the test."""
    answer = CliRunner().invoke(program, [str(argument) for argument in arguments])
    if answer.exception is not None and not isinstance(answer.exception, SystemExit):
        raise answer.exception
    return answer


@pytest.fixture(autouse=True)
def in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def save_off(mesh: TriangleMesh, name: str = "ball.off") -> Path:
    """The mesh as an OFF file."""
    lines = ["OFF", f"{mesh.n_vertices} {mesh.n_faces} 0"]
    lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    Path(name).write_text("\n".join(lines) + "\n")
    return Path(name)


def test_geodesic_by_default(in_empty_folder: Path) -> None:
    """VTK and PNG with default names in the current folder, a report in words on stdout."""
    save_off(icosphere(2))
    answer = run("geodesic", "ball.off")
    assert answer.exit_code == 0
    assert sorted(p.name for p in in_empty_folder.iterdir()) == [
        "ball.geodesic.png",
        "ball.geodesic.vtk",
        "ball.off",
    ]
    assert "farthest" in answer.stdout
    assert "ball.geodesic.vtk" in answer.stdout
    assert answer.stderr == ""
    names = {(field.name, field.location) for field in read("ball.geodesic.vtk").fields}
    assert names == {
        ("heat", "vertex"),
        ("divergence", "vertex"),
        ("distance", "vertex"),
        ("heat_gradient", "face"),
        ("direction", "face"),
    }


@needs_reference
@pytest.mark.parametrize("source", [["--source", "868"], []])
def test_geodesic_golden(source: list[str]) -> None:
    """Every value in the file is that of an independent implementation; the report names the farthest vertex."""
    mesh = reference("meshes/closed/moomoo.off")
    answer = run("geodesic", mesh, *source, "-o", "m.vtk", "--json")
    golden = read_csv(reference("golden/moomoo_geodesic.csv"))
    written = {field.name: field.values for field in read("m.vtk").fields if field.location == "vertex"}
    findings = compare_named("vertex", golden, written, Tolerance(), Ignored())
    assert [finding.name for finding in findings] == ["heat", "divergence", "distance"]
    assert all(finding.same for finding in findings), findings
    report = json.loads(answer.stdout)
    assert report["farthest"]["vertex"] == 765
    assert report["farthest"]["distance"] == pytest.approx(66.9407437317, abs=1e-9)
    assert report["sources"] == [868]
    assert not Path("m.png").exists()


def test_geodesic_report_is_json() -> None:
    """--json: command, mesh, parameters after defaults, answers, files, seconds."""
    save_off(icosphere(2))
    report = json.loads(run("geodesic", "ball.off", "--source", "3", "--source", "5", "-o", "b.ply", "--json").stdout)
    assert report["command"] == "geodesic"
    assert report["mesh"]["vertices"] == 162
    assert report["mesh"]["genus"] == 0
    assert report["sources"] == [3, 5]
    assert report["time"]["asked"] == "auto"
    assert report["files"] == ["b.ply"]
    assert set(report["seconds"]) == {"read", "compute", "write"}
    profile = report["profile"]["seconds"]
    assert {"connectivity", "assembly", "paths along edges", "heat", "distance"} < set(profile)
    assert sum(profile.values()) < report["seconds"]["compute"] + 1e-3


def test_quiet_says_nothing() -> None:
    """-q: no word on stdout, nor on stderr."""
    save_off(icosphere(1))
    answer = run("geodesic", "ball.off", "-q", "--no-png")
    assert answer.output == ""
    assert Path("ball.geodesic.vtk").exists()
    assert not Path("ball.geodesic.png").exists()


def test_several_outputs_hold_the_same() -> None:
    """-o may be repeated; all formats hold the same numbers."""
    save_off(icosphere(1))
    run("geodesic", "ball.off", "-o", "a.vtk", "-o", "a.vtp", "-o", "a.vtu", "-o", "a.ply")
    first = read("a.vtk")
    for other in ("a.vtp", "a.vtu", "a.ply"):
        again = read(other)
        for field in first.fields:
            np.testing.assert_array_equal(again[field.name], field.values)


def test_bytes_repeat() -> None:
    """Two runs write the same bytes, data and picture."""
    save_off(icosphere(2))
    for k in (1, 2):
        run("geodesic", "ball.off", "-o", f"{k}.vtk", "-o", f"{k}.vtp", "-o", f"{k}.ply", "--png", f"{k}.png")
    for extension in ("vtk", "vtp", "ply", "png"):
        assert Path(f"1.{extension}").read_bytes() == Path(f"2.{extension}").read_bytes()


def test_other_component_is_reported() -> None:
    """Vertices that no source reaches are inf in the file, and a line says how many."""
    save_off(zoo_mesh("two_spheres"))
    answer = run("geodesic", "ball.off", "--source", "0", "--no-png")
    assert "162 vertices" in answer.stdout
    assert np.isinf(read("ball.geodesic.vtk")["distance"]).sum() == 163
    report = json.loads(run("geodesic", "ball.off", "--source", "0", "--no-png", "--json").stdout)
    assert report["remarks"] == ["warning: 162 vertices lie on components without a source; their distance is inf"]
    assert json.loads(run("geodesic", "ball.off", "--source", "0,200", "--no-png", "--json").stdout)["remarks"] == []


def test_unreferenced_vertex_is_computed_on() -> None:
    """A vertex of no face keeps its place in the output."""
    ball = icosphere(1)
    vertices = np.insert(ball.vertices, 5, [9, 9, 9], axis=0)
    save_off(TriangleMesh(vertices, ball.faces + (ball.faces >= 5)))
    answer = run("geodesic", "ball.off", "--source", "0", "--no-png")
    assert answer.exit_code == 0
    distance = read("ball.geodesic.vtk")["distance"]
    assert len(distance) == 43
    assert np.flatnonzero(np.isinf(distance)).tolist() == [5]


def test_geodesic_refined_and_boundary() -> None:
    """--refine makes distances on a flat square exact, --boundary=average better; the report says which it was."""
    square = grid(12, 12)
    save_off(square, "square.off")
    exact = np.linalg.norm(square.vertices - square.vertices[20], axis=1)
    errors = {}
    for option in ("--no-refine", "--boundary=average", "--refine"):
        answer = run("geodesic", "square.off", "--source", "20", option, "-o", "a.vtu", "--json")
        report = json.loads(answer.stdout)
        assert report["refined"] == (option == "--refine")
        assert report["boundary"] == ("average" if "average" in option else "neumann")
        errors[option] = np.abs(read("a.vtu")["distance"] - exact).max()
    for solver in ("auto", "multigrid", "direct"):
        report = json.loads(run("geodesic", "square.off", "--solver", solver, "--json").stdout)
        assert report["solver"] == ("multigrid" if solver == "multigrid" else "direct")
    assert errors["--refine"] < 1e-12 < errors["--boundary=average"] < errors["--no-refine"]


def test_geodesic_robust() -> None:
    """--robust takes a mesh with faces without area and reports flips, rounds and mollification, in words and JSON."""
    save_off(split_diagonals(8))
    refused = run("geodesic", "ball.off")
    assert refused.exit_code == 1
    assert "--robust" in refused.stderr
    report = json.loads(run("geodesic", "ball.off", "--robust", "-o", "a.vtk", "--json").stdout)["robust"]
    assert set(report) == {"edge_flips", "flip_rounds", "sheets", "mollification", "mean_edge_length"}
    assert report["edge_flips"] >= 2 * 64
    assert report["mollification"] > 0
    assert np.isfinite(read("a.vtk")["distance"]).all()
    words = run("geodesic", "ball.off", "--robust").stdout
    assert f"edge flips {report['edge_flips']}, rounds {report['flip_rounds']}, both sides of the mesh" in words
    assert "robust" not in json.loads(run("geodesic", str(save_off(icosphere(1), "b.off")), "--json").stdout)


GOOD = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, ["bad.off", "no such file"]),
        ("", ["bad.off", "empty"]),
        (GOOD[:40], ["bad.off", "ends"]),
        (GOOD.replace("4 4 0", "5 4 0"), ["bad.off"]),
        (GOOD.replace("3 0 1 3", "3 0 1 4"), ["bad.off", "line 8", "4"]),
        (GOOD.replace("1 0 0", "nan 0 0", 1), ["bad.off", "line 4", "nan"]),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", ["bad.off", "0 faces"]),
        (GOOD.replace("3 0 1 3", "3 0 1 1"), ["bad.off", "line 8"]),
        (GOOD.replace("0 0 1\n", "0.5 0 0\n"), ["face 1", "zero area"]),
    ],
)
def test_bad_mesh_is_one_sentence(text: str | None, words: list[str], in_empty_folder: Path) -> None:
    """Each kind of broken file: one line on stderr, exit code 1, nothing written."""
    if text is not None:
        Path("bad.off").write_text(text)
    answer = run("geodesic", "bad.off")
    assert answer.exit_code == 1
    assert answer.stdout == ""
    assert len(answer.stderr.strip().splitlines()) == 1
    for word in words:
        assert word in answer.stderr
    assert {p.name for p in in_empty_folder.iterdir()} <= {"bad.off"}


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--source", "12"], 1, "source 12 is not a vertex"),
        (["--source", "-1"], 1, "source -1"),
        (["--source", "top"], 2, "'top' is no source"),
        (["--time", "soon"], 1, "time step"),
        (["--time", "-1"], 1, "positive"),
        (["-o", "nowhere/a.vtk"], 1, "no folder nowhere"),
        (["-o", "a.xyz"], 1, "'.xyz'"),
        (["-o", "ball.off"], 1, "'.off'"),
        (["--png", "a.jpg"], 1, "'.jpg'"),
        (["--png", "a.png", "--no-png"], 2, "exclude"),
        (["--sauce", "3"], 2, "No such option"),
    ],
)
def test_bad_arguments(arguments: list[str], code: int, words: str, in_empty_folder: Path) -> None:
    """What is asked for wrongly is refused before anything is written."""
    save_off(icosphere(0))
    answer = run("geodesic", "ball.off", *arguments)
    assert answer.exit_code == code
    assert words in answer.stderr
    assert [p.name for p in in_empty_folder.iterdir()] == ["ball.off"]


def test_failure_keeps_what_was_there() -> None:
    """A run that fails leaves an older result as it was."""
    save_off(icosphere(0))
    Path("a.vtk").write_text("older")
    assert run("geodesic", "ball.off", "--source", "99", "-o", "a.vtk").exit_code == 1
    assert Path("a.vtk").read_text() == "older"


def test_input_is_never_overwritten() -> None:
    """A mesh is not written over itself, under another name either."""
    write(MeshResult(icosphere(1)), "ball.ply")
    os.symlink("ball.ply", "link.ply")
    before = Path("ball.ply").read_bytes()
    for target in ("ball.ply", "link.ply", "./ball.ply"):
        answer = run("geodesic", "ball.ply", "-o", target)
        assert answer.exit_code == 1
        assert "input" in answer.stderr
    assert Path("ball.ply").read_bytes() == before


def test_no_opengl_loses_no_data(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing can be drawn, the data are written and one line says which package is missing."""
    from geomhw.render import offscreen

    monkeypatch.setattr(offscreen, "missing_opengl", lambda: "there is no OpenGL library (libEGL.so.1)")
    monkeypatch.setattr(offscreen, "has_display", lambda: False)
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)
    save_off(icosphere(1))
    answer = run("geodesic", "ball.off")
    assert answer.exit_code == 1
    assert Path("ball.geodesic.vtk").exists()
    assert not Path("ball.geodesic.png").exists()
    assert len(answer.stderr.strip().splitlines()) == 1
    for word in ("libegl1", "ball.geodesic.vtk is written", "--no-png"):
        assert word in answer.stderr


def test_helmholtz() -> None:
    """Parts in the file add up to the field; the report has their shares."""
    ball = icosphere(2)
    save_off(ball)
    V = np.cross([0.0, 0.0, 1.0], ball.face_centers)
    write(MeshResult(ball, [Field("wind", "face", V)]), "wind.vtp")
    answer = run("helmholtz", "ball.off", "--field", "wind.vtp:wind", "--json")
    assert answer.exit_code == 0
    parts = read("ball.helmholtz.vtk")
    np.testing.assert_allclose(parts["curl_free"] + parts["coexact"] + parts["harmonic"], parts["field"], atol=1e-12)
    assert json.loads(answer.stdout)["energy_shares"]["coexact"] > 0.99
    assert Path("ball.helmholtz.png").exists()


@pytest.mark.parametrize(
    ("spec", "words"),
    [("none.vtp:wind", "none.vtp"), ("wind.vtp:gale", "gale"), ("wind.vtp:scalar", "no vector field")],
)
def test_helmholtz_refusals(spec: str, words: str) -> None:
    """A missing file, a missing array and a scalar are told apart."""
    ball = icosphere(1)
    save_off(ball)
    fields = [Field("wind", "face", ball.face_normals), Field("scalar", "vertex", ball.vertices[:, 0])]
    write(MeshResult(ball, fields), "wind.vtp")
    answer = run("helmholtz", "ball.off", "--field", spec)
    assert answer.exit_code == 1
    assert words in answer.stderr


def test_info() -> None:
    """The mesh part of the report, in words and as JSON."""
    save_off(zoo_mesh("torus"))
    assert json.loads(run("info", "ball.off", "--json").stdout)["mesh"]["genus"] == 1
    lines = run("info", "ball.off").stdout.splitlines()
    assert any(line.split() == ["genus", "1"] for line in lines)


@pytest.mark.parametrize("command", [["geomhw"], [sys.executable, "-m", "geomhw_cli"]])
def test_installed_program(command: list[str]) -> None:
    """Both ways to start the program as installed, in a process of its own, with stdout clean for a script."""
    save_off(icosphere(1))
    beside = Path(sys.executable).parent / command[0]
    command = [str(beside) if beside.exists() else command[0], *command[1:]]
    done = subprocess.run([*command, "geodesic", "ball.off", "--json"], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["farthest"]["vertex"] >= 0
    assert done.stderr == ""


@needs_opengl
def test_panels_and_width() -> None:
    """A picture of the panels asked for, each as wide; another name is refused, with those that there are."""
    save_off(icosphere(2))
    asked = ["--panel", "gradient", "--panel", "divergence", "--width", "150"]
    assert run("geodesic", "ball.off", *asked).exit_code == 0
    with Image.open("ball.geodesic.png") as picture:
        assert picture.size[0] == 300
    refused = run("geodesic", "ball.off", "--panel", "flux")
    assert refused.exit_code == 2
    assert "'gradient'" in refused.stderr
    assert run("geodesic", "ball.off", "--width", "3").exit_code == 2


@pytest.mark.parametrize("command", list(program.commands))
def test_help_has_an_example(command: str) -> None:
    """Each command's help shows how it is used, on a line of its own; test_docs runs it."""
    answer = run(command, "--help")
    assert answer.exit_code == 0
    assert re.search(rf"^  Examples?\b[^\n]*:\n(    geomhw .*\n)*    geomhw {command} ", answer.stdout, re.MULTILINE)
