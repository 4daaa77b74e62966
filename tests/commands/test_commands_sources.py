"""``--source``: every spec, files of specs, and how report and output name the sources."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.flow.initial_fields import blob, bump
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.io import read
from geomhw.mesh.named_points import face_point, vertex_points
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.surface_points import concatenate
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw_cli.specs.sources import SourceSpecs
from support.messages import missing
from support.program import run, save_off

BALL, SHEET = icosphere(2), grid(6, 6)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a ball and a sheet in it."""
    save_off(BALL, "ball.off")
    save_off(SHEET, "sheet.off")
    return folder


def points(mesh: TriangleMesh, *texts: str) -> list[object]:
    """Return the points that the specs name, in order."""
    return SourceSpecs.parse(texts).resolve(mesh).report()


def inside(face: int, *weights: float) -> dict[str, object]:
    return {"face": face, "barycentric": pytest.approx(list(weights or [1 / 3] * 3), rel=1e-15)}


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["12"], [12]),
        (["12,40-44"], [12, 40, 41, 42, 43, 44]),
        (["3", "20"], [3, 20]),
        ([" 3 , 20  5,"], [3, 20, 5]),
        (["7-7"], [7]),
        (["face:17"], [inside(17)]),
        (["face:17,3"], [inside(17), 3]),
        (["face:17:0.2,0.3,0.5"], [inside(17, 0.2, 0.3, 0.5)]),
        (["face:17:.2,3e-1,0.5,12,face:2"], [inside(17, 0.2, 0.3, 0.5), 12, inside(2)]),
        (["max-x,min-x,max-y,min-y"], [6, 0, 42, 0]),
        ([], [42]),
        (["boundary"], sorted({*range(7), *range(42, 49), *range(0, 49, 7), *range(6, 49, 7)})),
        (["near:0.5,0.5,3"], [24]),
        (["near:-1,+1e0,0"], [42]),
        (["near:0.5,0.5,0,max-y"], [24, 42]),
    ],
)
def test_specs(texts: list[str], expected: list[object]) -> None:
    """Each spec names the expected vertices of a flat grid; several specs are concatenated in order."""
    assert points(SHEET, *texts) == expected


def test_nearest_point_is_named() -> None:
    """``near:`` gives a point within a face where no vertex is nearest."""
    (found,) = points(SHEET, "near:0.51,0.52,9")
    sources = SourceSpecs.parse(["near:0.51,0.52,9"]).resolve(SHEET)
    assert isinstance(found, dict)
    np.testing.assert_allclose(sources.positions(SHEET), [[0.51, 0.52, 0]], atol=1e-14)


def test_file_of_specs() -> None:
    """A file holds one or several specs a line, with comments, blank lines and any line ends."""
    Path("my seeds.txt").write_bytes(b"\xef\xbb\xbf# seeds\r\n12, 40-41   # two\r\n\r\nface:3 max-y\n5")
    assert points(SHEET, "@my seeds.txt", "1") == [12, 40, 41, inside(3), 42, 5, 1]


def test_geodesic_is_the_library() -> None:
    """Sources of repeated options give the library's arrays to the last bit; the report names the points."""
    arguments = ("geodesic", "ball.off", "--source", "9,face:17:0.2,0.3,0.5", "--source", "4", "-o", "a.vtp")
    answer = run(*arguments, "--json")
    sources = concatenate([vertex_points(BALL, [9]), face_point(BALL, 17, [0.2, 0.3, 0.5]), vertex_points(BALL, [4])])
    expected = HeatDistance(BALL).from_sources(sources)
    written = read("a.vtp")
    for field in expected.fields:
        np.testing.assert_array_equal(written[field.name], field.values)
    assert json.loads(answer.stdout)["sources"] == [4, 9, {"face": 17, "barycentric": [0.2, 0.3, 0.5]}]
    assert "source    4, 9, face 17 (0.2, 0.3, 0.5)\n" in run(*arguments).stdout


def test_many_sources_are_counted() -> None:
    """For many sources the report has their number and the first few."""
    for command in ("geodesic", "vecdiffuse"):
        answer = run(command, "sheet.off", "--source", "boundary", "-o", "a.vtp", "--json")
        report = json.loads(answer.stdout)
        assert report["source_count"] == 24
        assert report["sources"] == [*range(8), 13, 14, 20, 21, 27, 28, 34, 35, 41, *range(42, 45)]
        assert len(report.get("vectors", [0] * 20)) == 20
        words = run(command, "sheet.off", "--source", "boundary", "-o", "a.vtp").stdout
        assert "source    24 points: 0, 1, 2, 3, 4, 5, 6, 7, ...\n" in words
    few = json.loads(run("geodesic", "sheet.off", "--source", "0-19", "-o", "a.vtp", "--json").stdout)
    assert few["sources"] == list(range(20))
    assert "source_count" not in few


def test_below_zero_is_said() -> None:
    """A remark counts the vertices where the method came out below zero."""
    square = grid(24, 24)
    save_off(TriangleMesh(square.vertices + 20 * square.vertices[:, [1, 2, 2]], square.faces), "slivers.off")
    answer = run("geodesic", "slivers.off", "--source", "312,313", "-o", "a.vtp")
    assert "not positive" in answer.stdout
    assert "not positive" not in run("geodesic", "sheet.off", "--source", "boundary", "-o", "a.vtp").stdout


def test_vecdiffuse_within_a_face() -> None:
    """``--angle`` counts from the first edge of the face; values follow the order of the options."""
    angles = ("--angle", "90", "--angle", "30")
    answer = run("vecdiffuse", "sheet.off", "--source", "face:20", "--source", "3", *angles, "-o", "a.vtp", "--json")
    report = json.loads(answer.stdout)
    assert report["sources"] == [3, inside(20)]
    a, b = SHEET.vertices[SHEET.faces[20, :2]]
    along = (b - a) / np.linalg.norm(b - a)
    np.testing.assert_allclose(report["vectors"][1], np.cross([0, 0, 1], along), atol=1e-14)
    assert run("vecdiffuse", "sheet.off", "--source", "0-2", *angles).exit_code == 2


def test_blob_at_any_point() -> None:
    """A blob is a bump about the point of a source spec, which must be a single point."""
    for spec, center in (("face:20", SHEET.face_centers[20]), ("near:0.31,0.44,1", [0.31, 0.44, 0.0]), ("7", None)):
        run("advect", "sheet.off", "--color", f"blob:{spec}", "--steps", "1", "--every", "1", "-o", "a.pvd", "-q")
        (first, *_) = sorted(Path().glob("a.*.vtp"))
        expected = blob(SHEET, 7) if center is None else bump(SHEET, np.array(center))
        np.testing.assert_allclose(read(first)["color"], expected, rtol=1e-12)
    answer = run("advect", "sheet.off", "--color", "blob:boundary")
    assert answer.exit_code == 2
    assert not missing(answer.stderr, "'blob:boundary' ... 24 points ... one")
