"""Commands on hostile meshes whose distances are known: balls, flat pieces, books, single triangles."""

import numpy as np
import pytest

from geomhw.io import read
from support.hostile import BALL, HOSTILE, save, source_of
from support.program import run

pytestmark = pytest.mark.usefixtures("folder")


#: Meshes that contain the unit ball: its first vertex, its scale, and the accuracy of its distances.
BALLS = {
    **{
        name: (0, 1.0, 1e-12) for name in HOSTILE if name.startswith(("doubled", "turned_s", "inside", "two_w", "nest"))
    },
    "same_place": (0, 1.0, 1e-12),
    "loose_first": (1, 1.0, 1e-12),
    "huge": (0, 1e29, 1e-12),
    "tiny": (0, 1e-29, 1e-12),
    "far": (0, 1.0, 1e-6),  # coordinates are known to 10⁻⁸
    "mixed_scales": (162, 1e-6, 1e-7),
}


@pytest.mark.parametrize("name", BALLS)
def test_ball_in_disguise(name: str) -> None:
    """Flipped or duplicated faces, other components, positions and units leave the distances of a ball unchanged."""
    first, scale, accuracy = BALLS[name]
    for option in ("--refine", "--robust"):
        save(*BALL)
        run("geodesic", "m.off", "--source", "7", option, "-o", "ball.vtu")
        save(*HOSTILE[name]())
        run("geodesic", "m.off", "--source", str(first + 7), option, "-o", "out.vtu")
        expected = np.asarray(read("ball.vtu")["distance"])
        found = np.asarray(read("out.vtu")["distance"])[first : first + len(expected)]
        np.testing.assert_allclose(found / scale, expected, rtol=accuracy)


@pytest.mark.parametrize(
    "name", [name for name in HOSTILE if name.startswith(("triangle", "two_t", "fan", "turned_g", "needle", "sheared"))]
)
def test_flat_and_convex(name: str) -> None:
    """On a flat convex mesh distances are straight lines; faces of zero area cost at most 2e-5 of the largest."""
    vertices, faces = HOSTILE[name]()
    save(vertices, faces)
    answer = run("geodesic", "m.off", "--robust", "-o", "out.vtu")
    straight = np.linalg.norm(vertices - vertices[source_of(answer.stdout)], axis=1)
    accuracy = 1e-9 if "lengths +" not in answer.stdout else 2e-5
    np.testing.assert_allclose(read("out.vtu")["distance"], straight, rtol=0, atol=accuracy * straight.max())


@pytest.mark.parametrize("name", ["book_3", "book_5"])
def test_pages_of_a_book(name: str) -> None:
    """On a book, the distance from page to page is the straight line of the two unfolded pages."""
    vertices, faces = HOSTILE[name]()
    save(vertices, faces)
    answer = run("geodesic", "m.off", "--refine", "-o", "out.vtu")
    source = source_of(answer.stdout)
    x, z = np.hypot(vertices[:, 0], vertices[:, 1]), vertices[:, 2]
    along = (vertices[:, :2] @ vertices[source, :2]) / np.maximum(x * x[source], 1e-300)
    across = np.where(np.abs(along - 1) < 1e-9, x - x[source], x + x[source])
    np.testing.assert_allclose(read("out.vtu")["distance"], np.hypot(across, z - z[source]), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "share"), [("triangle", 0.5**0.5), ("two_triangles", 0.5**0.5), ("tetrahedron", 0.75**0.5)]
)
def test_coarsest(name: str, share: float) -> None:
    """On one triangle, a square and a tetrahedron the plain method errs by a known share; `--refine` is exact."""
    vertices, faces = HOSTILE[name]()
    save(vertices, faces)
    worst = 1.0
    for source in range(len(vertices)):
        run("geodesic", "m.off", "--source", str(source), "-o", "out.vtu")
        run("geodesic", "m.off", "--source", str(source), "-o", "fine.vtu", "--refine")
        exact = np.linalg.norm(vertices - vertices[source], axis=1)
        np.testing.assert_allclose(read("fine.vtu")["distance"], exact, rtol=1e-12)
        others = exact > 0
        worst = min(worst, float((read("out.vtu")["distance"][others] / exact[others]).min()))
    assert worst == pytest.approx(share, abs=1e-3)
