"""Distances by unfolding against exact distances on flat and spherical surfaces."""

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import cylinder_band, grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import unfolded


def shaken_square(seed: int) -> TriangleMesh:
    """Return a unit square whose inner vertices are moved by up to a fifth of a cell."""
    square = grid(12, 12)
    rng = np.random.default_rng(seed)
    points = square.vertices.copy()
    inner = np.setdiff1d(np.arange(square.n_vertices), square.boundary_vertices)
    points[inner, :2] += rng.uniform(-1, 1, (len(inner), 2)) * np.ptp(points[:, 0]) / 60
    return TriangleMesh(points, square.faces)


@pytest.mark.parametrize("source", [0, 17, 84])
def test_flat_is_exact(source: int) -> None:
    """On a convex flat mesh of any triangles the distance is the straight line."""
    mesh = shaken_square(3)
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    np.testing.assert_allclose(unfolded(mesh, [source]), chord, rtol=1e-12)


def test_cylinder_is_exact() -> None:
    """On a cylinder the distance is the shorter straight line of its two unfoldings, except where both are alike."""
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


@pytest.mark.parametrize("make", [lambda: grid(9, 7), lambda: shaken_square(1)])
def test_straight_front_is_exact(make) -> None:  # type: ignore[no-untyped-def]
    """From one side of a square, given by its vertices, the distance is the height above it."""
    mesh = make()
    side = np.flatnonzero(mesh.vertices[:, 0] == mesh.vertices[:, 0].min())
    height = mesh.vertices[:, 0] - mesh.vertices[:, 0].min()
    np.testing.assert_allclose(unfolded(mesh, side.tolist()), height, atol=1e-12 * height.max())


@pytest.mark.parametrize("robust", [False, True])
def test_heat_distance_refined(robust: bool) -> None:
    """Refined heat distances equal those by unfolding, and have less than 0.3 of the plain error."""
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
    """On a flat grid sheared by ten cells the distance is the straight line."""
    square = grid(20, 20)
    sheared = TriangleMesh(square.vertices @ [[1, 0, 0], [10, 1, 0], [0, 0, 1]], square.faces)
    chord = np.linalg.norm(sheared.vertices - sheared.vertices[0], axis=1)
    np.testing.assert_allclose(unfolded(sheared, [0]), chord, rtol=1e-10)


def test_faces_without_area() -> None:
    """Faces that are segments or points do not change the distances of a flat square."""
    square = grid(6, 6)
    n = square.n_vertices
    points = np.concatenate([square.vertices, square.vertices[:1], [square.vertices[:2].mean(axis=0)]])
    faces = np.concatenate([square.faces, [[0, 1, n + 1], [0, n, 1], [n, 0, n + 1]]])
    found = unfolded(TriangleMesh(points, faces), [5])
    np.testing.assert_allclose(found, np.linalg.norm(points - points[5], axis=1), rtol=1e-12)
