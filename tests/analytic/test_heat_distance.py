"""The heat method against exact distances and an independent implementation."""

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance, heat_distance
from geomhw.mesh.named_points import default_source
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import great_circle
from support.meshes import book, sheared, split_diagonals
from support.reference import needs_reference, reference


@needs_reference
@pytest.mark.parametrize("source", [[868], None])
def test_golden_values(source: list[int] | None) -> None:
    """Heat, divergence and distance equal those of an independent implementation, on the handout's mesh."""
    from geomhw.io import read_mesh

    mesh = read_mesh(reference("meshes/closed/moomoo.off"))
    result = HeatDistance(mesh).from_vertices(source or [default_source(mesh)])
    golden = np.genfromtxt(reference("golden/moomoo_geodesic.csv"), delimiter=",", names=True)
    for name in ("heat", "divergence", "distance"):
        expected = golden[name]
        np.testing.assert_allclose(result[name], expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    assert result.report["farthest"]["vertex"] == 765
    assert result.report["farthest"]["distance"] == pytest.approx(66.9407437317, abs=1e-9)
    assert mesh.mean_edge_length == pytest.approx(2.06515566663802, rel=1e-14)
    assert result.report["mean_distance"] == pytest.approx(35.5256774654, abs=1e-9)


def test_no_silent_underflow() -> None:
    """On a strip of 3000 cells, where heat underflows by 1000 orders of magnitude, far distances are within 1 %."""
    mesh = strip(3000)
    for time in ("auto", "0.3*h2", "h2", "20*h2"):
        result = HeatDistance(mesh, time).from_vertices([0])
        far = result["distance"][np.isclose(mesh.vertices[:, 0], 2999)]
        np.testing.assert_allclose(far, 2999, rtol=0.01)
        np.testing.assert_allclose(np.linalg.norm(result["direction"], axis=1), 1, atol=1e-12)


def test_several_sources() -> None:
    """From three vertices: zero at each source only, and close to the least of the three exact distances."""
    mesh = icosphere(4)
    sources = [0, 500, 1700]
    distance = heat_distance(mesh, sources)
    assert np.flatnonzero(distance <= 0).tolist() == sources
    least = np.min([great_circle(mesh, s) for s in sources], axis=0)
    assert np.abs(distance - least).mean() < 0.03 * least.mean()


def test_sources_in_a_row() -> None:
    """From one side of a square, the distance is the height above that side."""
    mesh = grid(20, 20, 1.0, 1.0)
    y = mesh.vertices[:, 1] - mesh.vertices[:, 1].min()
    side = np.flatnonzero(y == 0)
    distance = heat_distance(mesh, side)
    np.testing.assert_allclose(distance, y, atol=0.02)
    assert distance[side].tolist() == [0] * len(side)


def flat_error(mesh: TriangleMesh, exact: np.ndarray, source: int, robust: bool) -> float:
    """Return the mean relative error in %, at t = h²."""
    distance = heat_distance(mesh, [source], "h2", robust=robust, refine=False)
    others = np.arange(mesh.n_vertices) != source
    return 100 * float(np.mean(np.abs(distance - exact)[others] / exact[others]))


def test_robust_on_slivers() -> None:
    """On a flat grid sheared by 20, `robust` is within 1.5 % of the exact distance; the plain method fails."""
    mesh = sheared(24, 20.0)
    for source in (0, 312, 400):
        exact = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
        assert flat_error(mesh, exact, source, robust=True) < 1.5
        assert flat_error(mesh, exact, source, robust=False) > 20


def test_robust_where_faces_have_no_area() -> None:
    """Faces of zero area do not change robust distances; face fields are zero there."""
    mesh, clean = split_diagonals(), grid(16, 16, diagonal="uniform")
    assert mesh.degenerate_faces.size == 256
    for source in (0, 150):
        exact, reference_exact = (np.linalg.norm(m.vertices - m.vertices[source], axis=1) for m in (mesh, clean))
        assert flat_error(mesh, exact, source, True) < 1.1 * flat_error(clean, reference_exact, source, False)
    result = HeatDistance(mesh, robust=True).from_vertices([0])
    for name in ("direction", "heat_gradient"):
        assert np.isfinite(result[name]).all()
        assert not result[name][mesh.degenerate_faces].any()
    good = np.setdiff1d(np.arange(mesh.n_faces), mesh.degenerate_faces)
    np.testing.assert_allclose(np.linalg.norm(result["direction"][good], axis=1), 1, rtol=1e-12)
    assert result.report["robust"]["mollification"] == pytest.approx(1e-5 * mesh.mean_edge_length, rel=1e-6)


def test_robust_where_three_pages_meet() -> None:
    """On flat pages that meet in one edge, the distance between pages is the straight line of the unfolded pair."""
    mesh = book(3, 20)
    across = np.hypot(*mesh.vertices[:, :2].T)
    page = np.round(np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) * 3 / (2 * np.pi)).astype(int) % 3
    source = int(np.flatnonzero((page == 1) & np.isclose(across, 0.5))[3])
    side = np.where(page == page[source], across, -across)
    exact = np.hypot(side - across[source], mesh.vertices[:, 2] - mesh.vertices[source, 2])
    assert flat_error(mesh, exact, source, robust=True) < 2.3  # two such pages as one flat grid: 2.24


def test_robust_has_no_underflow() -> None:
    """Robust distances are within 1 % at the far end of a strip of 3000 slanted cells."""
    mesh = strip(3000)
    slanted = TriangleMesh(mesh.vertices + 3 * mesh.vertices[:, [1, 2, 2]], mesh.faces)
    distance = heat_distance(slanted, [0], "h2", robust=True)
    exact = np.linalg.norm(slanted.vertices - slanted.vertices[0], axis=1)
    far = exact > 100
    np.testing.assert_allclose(distance[far], exact[far], rtol=0.01)


def test_average_is_best_next_to_the_boundary() -> None:
    """On a square, the mean of both boundary conditions has less error at the boundary than each of them."""
    mesh = grid(40, 40)
    for source in (20 * 41 + 20, 4 * 41 + 4):
        exact = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)[mesh.boundary_vertices]
        errors = {}
        for boundary in ("neumann", "dirichlet", "average"):
            solver = HeatDistance(mesh, "h2", boundary=boundary)  # type: ignore[arg-type]
            found = solver.from_vertices([source])["distance"][mesh.boundary_vertices]
            errors[boundary] = np.mean(np.abs(found - exact) / exact)
        assert errors["average"] < 0.75 * min(errors["neumann"], errors["dirichlet"])


def test_boundary_conditions_at_any_extent() -> None:
    """On a strip of 1,500 cells, where heat underflows, the averaged condition is within 0.5 % at the far end."""
    mesh = grid(1500, 3, width=1500.0, height=3.0)
    result = HeatDistance(mesh, "h2", boundary="average").from_vertices([1501 + 0])
    exact = np.linalg.norm(mesh.vertices - mesh.vertices[1501], axis=1)
    far = exact > 1000
    np.testing.assert_allclose(result["distance"][far], exact[far], rtol=5e-3)
