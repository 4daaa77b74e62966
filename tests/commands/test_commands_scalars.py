"""``smooth``, ``gradient``, ``extrema`` and ``rois``: arrays, reports, masks and refusals."""

import json

import numpy as np
import pytest
from scipy.spatial import Delaunay

from geomhw.io import read, read_field, write
from geomhw.mesh import TriangleMesh, icosphere
from geomhw.results import Field, Result
from support.messages import missing
from support.program import run, save_off

pytestmark = pytest.mark.usefixtures("folder")
BALL = icosphere(3)
X, Y, Z = BALL.vertices.T


@pytest.fixture
def files(folder: object) -> None:
    """The sphere alone, with one array and with two, and arrays in files of their own."""
    save_off(BALL)
    write(Result(BALL, [Field("one", "vertex", Z)]), "one.vtp")
    write(Result(BALL, [Field("a", "vertex", X), Field("b", "face", BALL.face_areas)]), ["two.vtp"])
    write(Result(BALL, [Field("height", "vertex", Z), Field("side", "vertex", (X > 0).astype(int))]), "arrays.func.gii")
    np.save("v.npy", BALL.vertices)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("arguments", [["one.vtp"], ["one.vtp:one"], ["ball.off", "--array", "arrays.func.gii:height"]])
def test_smooth_keeps_name_and_integral(arguments: list[str]) -> None:
    """The array keeps its name, the integral stays, and a spherical harmonic decays as heat does."""
    answer = run("smooth", *arguments, "--fwhm", "1", "-o", "s.vtp", "-o", "s.func.gii", "--no-png", "--json")
    assert answer.exit_code == 0, answer.stderr
    report = json.loads(answer.stdout)
    (field,) = read("s.vtp").fields
    assert field.name == ("height" if "--array" in arguments else "one")
    np.testing.assert_allclose(field.values, Z * np.exp(-2 * report["time"]), atol=2e-3)
    assert abs(report["integral"]["after"] - report["integral"]["before"]) < 1e-12
    np.testing.assert_allclose(read_field(f"s.func.gii:{field.name}", BALL).values, field.values, rtol=1e-6)


@pytest.mark.usefixtures("files")
def test_smooth_does_not_leak_through_a_mask() -> None:
    """Values outside do not matter inside, and stay themselves; the integral inside is kept."""
    inside = X > 0
    for name, outside in (("p", 0.0), ("q", 1e6)):
        np.save(f"{name}.npy", np.where(inside, Z, outside))
        line = ["--array", f"{name}.npy", "--mask", "arrays.func.gii:side", "--fwhm", "0.8", "-o", f"{name}.vtp"]
        assert run("smooth", "ball.off", *line, "--no-png").exit_code == 0
    p, q = (np.asarray(read(f"{name}.vtp")[name]) for name in "pq")
    np.testing.assert_array_equal(p[inside], q[inside])
    assert (q[~inside] == 1e6).all()
    assert not np.array_equal(p[inside], Z[inside])


@pytest.mark.usefixtures("files")
def test_gradient_extrema_and_rois() -> None:
    """The gradient of the height is tangent, its extrema are the poles, and a disk has the area of a cap."""
    assert run("gradient", "one.vtp", "-o", "g.vtp", "--no-png").exit_code == 0
    found = read("g.vtp")
    exact = [0, 0, 1] - Z[:, None] * BALL.vertices
    by_place = {(field.name, field.location): np.asarray(field.values) for field in found.fields}
    np.testing.assert_allclose(by_place["gradient", "vertex"], exact, atol=0.02)
    np.testing.assert_allclose(by_place["gradient_magnitude", "vertex"], np.linalg.norm(exact, axis=1), atol=0.02)
    assert by_place["gradient", "face"].shape == (BALL.n_faces, 3)
    report = json.loads(run("extrema", "one.vtp", "--distance", "1", "-o", "e.vtp", "--no-png", "--json").stdout)
    assert [row["value"] for row in report["maxima"] + report["minima"]] == [Z.max(), Z.min()]
    assert np.flatnonzero(read("e.vtp")["extrema"]).tolist() == sorted([Z.argmax(), Z.argmin()])
    line = ["--center", "5,9", "--radius", "0.6", "--gaussian", "0.2", "-o", "r.vtp", "--no-png", "--json"]
    report = json.loads(run("rois", "ball.off", *line).stdout)
    np.testing.assert_allclose(report["rois"][0]["area"], 2 * np.pi * (1 - np.cos(0.6)), rtol=0.15)
    assert read("r.vtp")["roi_9"].sum() == pytest.approx(1)
    assert run("rois", "ball.off", "--signed", "arrays.func.gii:side", "-o", "d.vtp", "--no-png").exit_code == 0
    assert ((read("d.vtp")["signed_distance"] < 0) == (X > 0)).all()


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("threshold", [["--above", "2"], ["--below", "-2"]])
def test_thresholds_and_edges_of_masks(threshold: list[str]) -> None:
    """Thresholds leave extrema out; so does the edge of a mask."""
    report = json.loads(run("extrema", "one.vtp", *threshold, "--no-png", "-o", "e.vtp", "--json").stdout)
    assert len(report["maxima"]) + len(report["minima"]) == 1
    line = ["extrema", "ball.off", "--array", "v.npy"]
    assert run(*line, "-o", "e.vtp").exit_code == 1
    np.save("x.npy", X)
    line = ["--array", "x.npy", "--mask", "arrays.func.gii:side", "--no-png", "-o", "e.vtp", "--json"]
    report = json.loads(run("extrema", "ball.off", *line).stdout)
    assert [row["vertex"] for row in report["maxima"]] == [X.argmax()]
    assert report["minima"] == []


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--fwhm", "0.08"], 1, "a constant 1 would become ... at vertex ... --robust"),
        (["--fwhm", "0.3"], 0, "values pass those of the array by ... % of their range ... --robust"),
        (["--fwhm", "0.08", "--robust"], 0, ""),
        (["--fwhm", "0.3", "--robust"], 0, ""),
    ],
)
def test_smooth_among_very_obtuse_angles(options: list[str], code: int, words: str) -> None:
    """Values that pass the range are reported, and a width is refused at which a constant would become negative."""
    x, y = np.random.default_rng(0).random((2, 80))
    mesh = TriangleMesh(np.column_stack([x, 0.1 * y, 0 * x]), Delaunay(np.column_stack([x, y])).simplices)
    write(Result(mesh, [Field("f", "vertex", x * y)]), "flat.vtp")
    answer = run("smooth", "flat.vtp", *options, "--no-png", "-o", "s.vtp")
    assert answer.exit_code == code
    assert not missing(answer.stdout + answer.stderr, words)
    assert ("--robust" in answer.stdout + answer.stderr) == bool(words)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("smooth two.vtp --fwhm 1", 1, "two.vtp holds no single array ... a, b"),
        ("smooth two.vtp:c --fwhm 1", 1, "no array 'c' ... a, b"),
        ("smooth two.vtp:b --fwhm 1", 1, "'b' is per face"),
        ("smooth ball.off --fwhm 1", 1, "there are none ... --array"),
        ("smooth one.vtp --fwhm 0", 2, "--fwhm"),
        ("smooth one.vtp", 2, "--fwhm"),
        ("smooth none.vtp:a --fwhm 1", 1, "no such file"),
        ("gradient ball.off --array v.npy", 1, "3 components"),
        ("extrema one.vtp --distance -1", 2, "--distance"),
        ("rois ball.off --radius 1", 2, "--center"),
        ("rois ball.off --radius 1 --signed arrays.func.gii:side", 2, "--signed"),
        ("rois ball.off --signed v.npy", 1, "one number per vertex"),
        ("rois ball.off --radius 1 --center face:3", 2, "vertex"),
    ],
)
def test_refusals(line: str, code: int, words: str) -> None:
    """What is impossible is refused in one sentence."""
    answer = run(*line.split(), "-o", "x.vtp", "--no-png")
    assert answer.exit_code == code, answer.stderr
    assert not missing(answer.stderr, words)
