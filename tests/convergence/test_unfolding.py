"""Distances by unfolding: exact where the surface is flat, of first order or better where it is not."""

import numpy as np
import pytest
from conftest import ZOO, crumpled, zoo_mesh

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.unfolding import Unfolding
from geomhw.mesh.curvature import angle_defects
from geomhw.mesh.primitives import cylinder_band, grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh


def unfolded(mesh: TriangleMesh, sources: list[int]) -> np.ndarray:
    """Distances from these vertices, with paths along edges for the order."""
    start = np.full(mesh.n_vertices, np.inf)
    start[sources] = 0
    return Unfolding(mesh, angle_defects(mesh))(start, edge_path_distance(mesh, np.array(sources)))


def shaken_square(seed: int) -> TriangleMesh:
    """A unit square, its inner vertices shaken by up to a fifth of a cell."""
    square = grid(12, 12)
    rng = np.random.default_rng(seed)
    points = square.vertices.copy()
    inner = np.setdiff1d(np.arange(square.n_vertices), square.boundary_vertices)
    points[inner, :2] += rng.uniform(-1, 1, (len(inner), 2)) * np.ptp(points[:, 0]) / 60
    return TriangleMesh(points, square.faces)


@pytest.mark.parametrize("source", [0, 17, 84])
def test_flat_is_exact(source: int) -> None:
    """On a convex flat piece the distance is the chord, whatever the triangles."""
    mesh = shaken_square(3)
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    np.testing.assert_allclose(unfolded(mesh, [source]), chord, rtol=1e-12)


def test_cylinder_is_exact() -> None:
    """A cylinder of flat strips unrolls: distance is the shorter way round, away from where both are alike."""
    n = 24
    mesh = cylinder_band(n, 8, height=2.0)
    width = 2 * n * np.sin(np.pi / n)
    across = np.arange(mesh.n_vertices) % n * (width / n)
    up = mesh.vertices[:, 2] - mesh.vertices[0, 2]
    exact = np.minimum(np.hypot(across, up), np.hypot(width - across, up))
    found = unfolded(mesh, [0])
    both_ways = np.abs(across - width / 2) < 1.5 * width / n
    np.testing.assert_allclose(found[~both_ways], exact[~both_ways], rtol=1e-12)
    np.testing.assert_allclose(found, exact, rtol=1e-3)


def test_sphere_converges() -> None:
    """The mean relative error against great circles at least halves when edges do."""
    errors = []
    for level in (2, 3, 4, 5):
        mesh = icosphere(level)
        exact = np.arccos(np.clip(mesh.vertices @ mesh.vertices[12], -1, 1))
        away = exact > 0
        errors.append(np.mean(np.abs(unfolded(mesh, [12]) - exact)[away] / exact[away]))
    assert errors[-1] < 1e-3
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 0.9).all()


@pytest.mark.parametrize("make", [lambda: grid(9, 7), lambda: shaken_square(1)])
def test_straight_front_is_exact(make) -> None:  # type: ignore[no-untyped-def]
    """From one side of a square, given by its vertices, distance is the height above it."""
    mesh = make()
    side = np.flatnonzero(mesh.vertices[:, 0] == mesh.vertices[:, 0].min())
    height = mesh.vertices[:, 0] - mesh.vertices[:, 0].min()
    np.testing.assert_allclose(unfolded(mesh, side.tolist()), height, atol=1e-12 * height.max())


@pytest.mark.parametrize("name", sorted(ZOO))
def test_between_chord_and_path(name: str) -> None:
    """No shorter than the chord, no longer than along edges, inf where no path leads."""
    mesh = zoo_mesh(name)
    found, path = unfolded(mesh, [0]), edge_path_distance(mesh, np.array([0]))
    assert np.array_equal(np.isinf(found), np.isinf(path))
    there = np.isfinite(path)
    assert (found[there] <= path[there] * (1 + 1e-12)).all()
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)
    assert (found[there] >= chord[there] * (1 - 1e-12)).all()
    assert found[0] == 0
    assert (found[1:] > 0).all()


@pytest.mark.parametrize("name", ["sphere", "torus", "genus_two", "annulus"])
def test_order_does_not_matter(name: str) -> None:
    """Another order, even none, leads to the same distances but for a little."""
    mesh = zoo_mesh(name)
    start = np.full(mesh.n_vertices, np.inf)
    start[3] = 0
    unfold = Unfolding(mesh, angle_defects(mesh))
    expected = unfold(start, edge_path_distance(mesh, np.array([3])))
    for guess in (np.ones(mesh.n_vertices), np.asarray(HeatDistance(mesh).from_vertices([3])["distance"])):
        np.testing.assert_allclose(unfold(start, guess), expected, rtol=5e-3)


@pytest.mark.parametrize("robust", [False, True])
def test_heat_distance_refined(robust: bool) -> None:
    """Refined, the heat method is several times closer to the great circle, and exactly what unfolding gives."""
    mesh = icosphere(3)
    exact = np.arccos(np.clip(mesh.vertices @ mesh.vertices[12], -1, 1))
    plain = HeatDistance(mesh, "h2", robust=robust, refine=False).from_vertices([12])
    refined = HeatDistance(mesh, "h2", robust=robust, refine=True).from_vertices([12])
    assert refined.report["refined"]
    assert not plain.report["refined"]
    assert HeatDistance(mesh, "h2", robust=robust).from_vertices([12]).report["refined"] == robust
    errors = [np.abs(result["distance"] - exact).mean() for result in (plain, refined)]
    assert errors[1] < 0.3 * errors[0]
    np.testing.assert_allclose(refined["distance"], unfolded(mesh, [12]), rtol=1e-9)
    np.testing.assert_array_equal(refined["heat"], plain["heat"])


def test_slivers_do_not_matter() -> None:
    """On a flat grid sheared by ten cells the distance is still the chord."""
    square = grid(20, 20)
    sheared = TriangleMesh(square.vertices @ [[1, 0, 0], [10, 1, 0], [0, 0, 1]], square.faces)
    chord = np.linalg.norm(sheared.vertices - sheared.vertices[0], axis=1)
    np.testing.assert_allclose(unfolded(sheared, [0]), chord, rtol=1e-10)


def test_faces_without_area() -> None:
    """Faces that are lines or points change nothing: here they hang on a flat square."""
    square = grid(6, 6)
    n = square.n_vertices
    points = np.concatenate([square.vertices, square.vertices[:1], [square.vertices[:2].mean(axis=0)]])
    faces = np.concatenate([square.faces, [[0, 1, n + 1], [0, n, 1], [n, 0, n + 1]]])
    found = unfolded(TriangleMesh(points, faces), [5])
    np.testing.assert_allclose(found, np.linalg.norm(points - points[5], axis=1), rtol=1e-12)


def test_scale() -> None:
    """A mesh of another size has distances in proportion, bit for bit for powers of two."""
    mesh = crumpled(icosphere(2))
    large = TriangleMesh(mesh.vertices * 1024, mesh.faces)
    np.testing.assert_array_equal(unfolded(large, [5]), 1024 * unfolded(mesh, [5]))
