"""``signed``: files, report, directions of named curves, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read, write_csv
from geomhw.mesh import TriangleMesh, grid, icosphere, moebius_band, torus
from support.meshes import book, two_spheres
from support.program import run, save_off

BALL = icosphere(3)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a sphere, the height on it, and an eastward circle of latitude."""
    save_off(BALL)
    np.save("height.npy", BALL.vertices[:, 2])
    turn = np.linspace(0, 2 * np.pi, 101)
    rows = [{"x": float(np.cos(a)), "y": float(np.sin(a)), "z": 0.3} for a in turn[:-1]]
    write_csv("ring.csv", [*rows, rows[0]])
    write_csv("part.csv", rows[:40])
    return folder


def signed(*arguments: str) -> tuple[np.ndarray, dict]:
    """Run the command; return the distances and the report."""
    answer = run("signed", *arguments, "-o", "s.vtp", "--json")
    assert answer.exit_code == 0, answer.output
    return np.asarray(read("s.vtp")["signed_distance"]), json.loads(answer.stdout)


def test_ring() -> None:
    """Positive on the left; --flip changes the sign, --no-correct the method; a picture is drawn."""
    d, report = signed("ball.off", "--curve", "ring.csv", "--png", "s.png")
    z = BALL.vertices[:, 2]
    level = np.arcsin(0.3 / np.sqrt(1.09))
    np.testing.assert_allclose(d, np.arcsin(z) - level, atol=0.01)
    assert report["vertices"] == {"exact": BALL.n_vertices, "generalized": 0, "unsigned": 0}
    assert (report["least"], report["largest"]) == (d.min(), d.max())
    flipped, other = signed("ball.off", "--curve", "ring.csv", "--flip")
    np.testing.assert_array_equal(flipped, -d)
    assert (other["least"], other["flipped"]) == (-d.max(), True)
    plain, heat = signed("ball.off", "--curve", "ring.csv", "--no-correct", "--time", "4*h2")
    assert np.abs(plain - d).mean() < 0.05 * BALL.mean_edge_length
    assert (heat["method"], heat["time"]["t_over_h2"]) == ("heat", pytest.approx(4))
    assert Path("s.png").exists()


def test_isolines_keep_their_side() -> None:
    """The signed distance from an isoline has the sign of the array less the level."""
    assert run("isolines", "ball.off", "--array", "height.npy", "--level", "0.31", "-o", "i.vtp").exit_code == 0
    d, _ = signed("ball.off", "--curve", "i.vtp")
    np.testing.assert_array_equal(np.sign(d), np.sign(BALL.vertices[:, 2] - 0.31))


def test_broken_ring() -> None:
    """Gaps are closed and reported; without that, or of a short arc, distances are generalized."""
    rows = np.genfromtxt("ring.csv", delimiter=",", names=True)
    places = np.stack([rows[name] for name in "xyz"], axis=1)
    parts = [range(k, k + 18) for k in range(0, 100, 20)]
    write_csv(
        "parts.csv",
        [dict(zip("xyz", map(float, places[i]), strict=True)) | {"path": k} for k, p in enumerate(parts) for i in p],
    )
    whole, _ = signed("ball.off", "--curve", "ring.csv")
    d, report = signed("ball.off", "--curve", "parts.csv")
    assert report["bridges"]["gaps"] == 5
    np.testing.assert_allclose(d, whole, atol=0.01)
    assert any("5 gaps closed" in line for line in report["remarks"])
    _, opened = signed("ball.off", "--curve", "parts.csv", "--no-bridge")
    assert opened["vertices"]["generalized"] == BALL.n_vertices
    assert any("generalized" in line for line in opened["remarks"])
    _, short = signed("ball.off", "--curve", "part.csv")
    assert short["bridges"]["gaps"] == 0


def test_named_curves() -> None:
    """The boundary is positive inside; a border is positive at the higher label, unsigned between two borders."""
    square = grid(6, 6)
    save_off(square, "square.off")
    x, y = square.vertices[:, :2].T
    d, _ = signed("square.off", "--curve", "boundary")
    np.testing.assert_allclose(d, np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y)), atol=1e-12)
    np.save("halves.npy", (square.face_centers[:, 0] > 0.5).astype(int))
    np.testing.assert_allclose(signed("square.off", "--curve", "border:halves.npy")[0], x - 0.5, atol=1e-12)
    np.save("thirds.npy", (3 * square.face_centers[:, 0]).astype(int))
    d, report = signed("square.off", "--curve", "border:thirds.npy")
    assert report["vertices"]["unsigned"] == 7  # halfway between the borders
    assert (d[x < 0.3] < 0).all()


def test_where_no_side_is_known() -> None:
    """One meridian of a torus, and another component: warnings."""
    ring = torus(24, 12)
    save_off(ring, "torus.off")
    np.save("x.npy", ring.vertices[:, 0])
    assert (
        run(
            "isolines", "torus.off", "--array", "x.npy", "--level", "0.013", "-o", "pair.vtp", "-o", "pair.csv"
        ).exit_code
        == 0
    )
    table = np.genfromtxt("pair.csv", delimiter=",", names=True)
    write_csv(
        "one.csv", [{"x": float(r["x"]), "y": float(r["y"]), "z": float(r["z"])} for r in table if r["path"] == 0]
    )
    d, report = signed("torus.off", "--curve", "one.csv")
    assert (d >= 0).all()
    assert any("warning" in line and "unsigned" in line for line in report["remarks"])
    pair, report = signed("torus.off", "--curve", "pair.vtp")
    assert report["vertices"]["exact"] == ring.n_vertices
    np.testing.assert_array_equal(np.sign(pair), np.sign(ring.vertices[:, 0] - 0.013))
    save_off(two_spheres(), "balls.off")
    d, report = signed("balls.off", "--curve", "ring.csv")
    assert np.isinf(d).sum() == report["unreachable_vertices"] + 1
    assert any("without a curve" in line for line in report["remarks"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["ball.off"], ["--curve"]),
        (["ball.off", "--curve", "none.csv"], ["none.csv"]),
        (["ball.off", "--curve", "far.csv"], ["far.csv", "from the surface"]),
        (["ball.off", "--curve", "point.csv"], ["point.csv", "one point"]),
        (["ball.off", "--curve", "boundary"], ["no boundary"]),
        (["cube.off", "--curve", "edges:angle>40"], ["edges:angle>40", "direction"]),
        (["band.off", "--curve", "band.csv"], ["one-sided"]),
        (["book.off", "--curve", "pages.csv"], ["3 faces meet"]),
        (["balls.off", "--curve", "both.csv"], ["different components"]),
        (["ball.off", "--curve", "ring.csv", "--no-correct", "--time", "soon"], ["soon"]),
        (["ball.off", "--curve", "ring.csv", "--time", "soon"], ["soon"]),
    ],
)
def test_refusals(arguments: list[str], words: list[str]) -> None:
    """One sentence, and no file."""
    Path("far.csv").write_text("x,y,z\n5,0,0\n6,0,0\n")
    Path("point.csv").write_text("x,y,z\n1,0,0\n1,0,0\n")
    Path("pages.csv").write_text("x,y,z\n0.5,0,0.4\n-0.25,0.433,0.4\n")
    Path("both.csv").write_text("x,y,z\n1,0,0\n3.5,0,0\n")
    band = moebius_band(40, 4)
    Path("band.csv").write_text("x,y,z\n" + "\n".join(",".join(map(str, band.vertices[k])) for k in (0, 9)) + "\n")
    save_off(band, "band.off")
    save_off(book(3), "book.off")
    save_off(two_spheres(), "balls.off")
    roof = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 1], [0, -1, 1]], [[0, 1, 2], [1, 0, 3]])
    save_off(roof, "cube.off")
    answer = run("signed", *arguments, "-o", "o.vtp")
    assert answer.exit_code in (1, 2)
    message = answer.stderr.splitlines()[-1]
    assert [word for word in words if word not in message] == [], message
    assert not Path("o.vtp").exists()
