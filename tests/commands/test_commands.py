"""``geodesic``, ``helmholtz`` and ``info``: their files, reports and options. Each test reads the files back."""

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from PIL import Image

from geomhw.compare import Ignored, Tolerance, compare_files, compare_named
from geomhw.errors import MeshError, Remedy
from geomhw.flow.advection import flow_of
from geomhw.fluid.run import scheme_of
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.io import read, read_csv, write
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.pictures import geodesic_picture
from geomhw.results import Field
from geomhw.results import Result as MeshResult
from geomhw.transport.vector_heat import VectorHeat
from geomhw_cli.main import REMEDIES, program
from support.meshes import split_diagonals, zoo_mesh
from support.messages import missing
from support.pictures import needs_opengl
from support.program import run, save_off
from support.reference import needs_reference, reference

pytestmark = pytest.mark.usefixtures("folder")


def test_geodesic_by_default(folder: Path) -> None:
    """By default ``geodesic`` writes VTK and PNG with default names, and a report in words."""
    save_off(icosphere(2))
    answer = run("geodesic", "ball.off")
    assert answer.exit_code == 0
    assert sorted(p.name for p in folder.iterdir()) == [
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
    """The values in the file equal those of an independent implementation, with the handout's default source."""
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
    """``--json`` prints command, mesh, parameters with defaults, answers, files and seconds."""
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
    """``-q`` prints nothing on stdout and stderr."""
    save_off(icosphere(1))
    answer = run("geodesic", "ball.off", "-q", "--no-png")
    assert answer.output == ""
    assert Path("ball.geodesic.vtk").exists()
    assert not Path("ball.geodesic.png").exists()


def test_several_outputs_hold_the_same() -> None:
    """All formats of a repeated ``-o`` hold the same numbers."""
    save_off(icosphere(1))
    run("geodesic", "ball.off", "-o", "a.vtk", "-o", "a.vtp", "-o", "a.vtu", "-o", "a.ply")
    first = read("a.vtk")
    for other in ("a.vtp", "a.vtu", "a.ply"):
        again = read(other)
        for field in first.fields:
            np.testing.assert_array_equal(again[field.name], field.values)


def test_bytes_repeat() -> None:
    """Two runs of one command, of which the picture keeps the command line, write the same bytes."""
    save_off(icosphere(2))
    written = []
    for _ in range(2):
        run("geodesic", "ball.off", "-o", "a.vtk", "-o", "a.vtp", "-o", "a.ply", "--png", "a.png")
        written.append([Path(f"a.{extension}").read_bytes() for extension in ("vtk", "vtp", "ply", "png")])
    assert written[0] == written[1]


def test_other_component_is_reported() -> None:
    """Unreachable vertices are inf in the file, and a warning counts those that have faces."""
    save_off(zoo_mesh("two_spheres"))
    answer = run("geodesic", "ball.off", "--source", "0", "--no-png")
    assert "162 vertices" in answer.stdout
    assert np.isinf(read("ball.geodesic.vtk")["distance"]).sum() == 163
    report = json.loads(run("geodesic", "ball.off", "--source", "0", "--no-png", "--json").stdout)
    (remark,) = [remark for remark in report["remarks"] if "component" in remark]
    assert not missing(remark, "warning ... 162 vertices ... source ... inf")
    both = json.loads(run("geodesic", "ball.off", "--source", "0,200", "--no-png", "--json").stdout)
    assert "component" not in "".join(both["remarks"])


def test_unreferenced_vertex_is_computed_on() -> None:
    """A vertex without faces keeps its place in the output, with distance inf."""
    ball = icosphere(1)
    vertices = np.insert(ball.vertices, 5, [9, 9, 9], axis=0)
    save_off(TriangleMesh(vertices, ball.faces + (ball.faces >= 5)))
    answer = run("geodesic", "ball.off", "--source", "0", "--no-png")
    assert answer.exit_code == 0
    distance = read("ball.geodesic.vtk")["distance"]
    assert len(distance) == 43
    assert np.flatnonzero(np.isinf(distance)).tolist() == [5]


def test_geodesic_refined_and_boundary() -> None:
    """On a square, ``--refine`` is exact and ``--boundary average`` reduces the error; the report names both."""
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
    """``--robust`` accepts faces of zero area, and reports flips and mollification."""
    save_off(split_diagonals(8))
    refused = run("geodesic", "ball.off")
    assert refused.exit_code == 1
    assert "--robust" in refused.stderr
    report = json.loads(run("geodesic", "ball.off", "--robust", "-o", "a.vtk", "--json").stdout)["robust"]
    assert set(report) == {"edge_flips", "sheets", "mollification", "mean_edge_length"}
    assert report["edge_flips"] >= 2 * 64
    assert report["mollification"] > 0
    assert np.isfinite(read("a.vtk")["distance"]).all()
    words = run("geodesic", "ball.off", "--robust").stdout
    assert f"edge flips {report['edge_flips']}, both sides of the mesh" in words
    assert "robust" not in json.loads(run("geodesic", str(save_off(icosphere(1), "b.off")), "--json").stdout)


def test_helmholtz() -> None:
    """The parts in the file sum to the field; the report holds their shares of the energy."""
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


def test_info() -> None:
    """``info`` prints the mesh summary in words and as JSON."""
    save_off(zoo_mesh("torus"))
    assert json.loads(run("info", "ball.off", "--json").stdout)["mesh"]["genus"] == 1
    lines = run("info", "ball.off").stdout.splitlines()
    assert any(line.split() == ["genus", "1"] for line in lines)


@pytest.mark.parametrize("command", [["geomhw"], *([sys.executable, "-m", name] for name in ("geomhw", "geomhw_cli"))])
def test_installed_program(command: list[str]) -> None:
    """All ways to start the program as installed, in a process of its own, with stdout clean for a script."""
    save_off(icosphere(1))
    beside = Path(sys.executable).parent / command[0]
    command = [str(beside) if beside.exists() else command[0], *command[1:]]
    done = subprocess.run([*command, "geodesic", "ball.off", "--json"], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["farthest"]["vertex"] >= 0
    assert done.stderr == ""


@needs_opengl
def test_panels_and_width() -> None:
    """The picture has the requested panels at the requested width; an unknown panel is refused with the list."""
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
    """The help of each command has an example line."""
    answer = run(command, "--help")
    assert answer.exit_code == 0
    assert re.search(rf"^  Examples?\b[^\n]*:\n(    geomhw .*\n)*    geomhw {command} ", answer.stdout, re.MULTILINE)


# -- defaults and errors of the library --------------------------------------------------------------------------------

FUNCTIONS = {
    "geodesic": [HeatDistance, geodesic_picture],
    "vecdiffuse": [VectorHeat],
    "advect": [flow_of],
    "fluid": [scheme_of],
    "compare": [Tolerance, compare_files],
}
#: Options whose argument in the library has another name; the library names a scheme without a default.
ARGUMENTS = {"smooth": "filter", "spot": "heaviest_spot"}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_defaults_are_the_librarys(name: str) -> None:
    """An option has the default value of the argument that it sets."""
    defaults = {
        argument.name: argument.default
        for function in FUNCTIONS[name]
        for argument in inspect.signature(function).parameters.values()
        if argument.default is not argument.empty
    }
    command = program.commands[name]
    params = command.make_context("", [], resilient_parsing=True).params
    shared = {option: params[option] for option in params if ARGUMENTS.get(option, option) in defaults}
    assert len(shared) >= {"geodesic": 7, "vecdiffuse": 3, "fluid": 3, "compare": 4}.get(name, 1)
    assert shared == {option: defaults[ARGUMENTS.get(option, option)] for option in shared}


def test_the_option_that_helps() -> None:
    """Each remedy of the library has an option, which takes its place in the message."""
    assert {*REMEDIES, ""} == set(get_args(Remedy))
    save_off(split_diagonals(4))
    refused = run("geodesic", "ball.off")
    assert "--robust" in refused.stderr
    assert "robust=True" not in refused.stderr
    with pytest.raises(MeshError, match="robust=True") as error:
        HeatDistance(split_diagonals(4))
    assert error.value.remedy == "robust=True"


@pytest.mark.parametrize(
    ("arguments", "code"), [("info none.off", 1), ("info --check none.off", 2), ("compare none.off none.off", 2)]
)
def test_exit_code_of_a_failure(arguments: str, code: int) -> None:
    """It is 2 where exit code 1 is an answer."""
    answer = run(*arguments.split())
    assert answer.exit_code == code
    assert answer.stderr == "Error: none.off: there is no such file\n"
