"""Refined distances against straight lines on flat surfaces and great circles."""

import numpy as np
import pytest

from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.exact import cylinder


def refined(mesh: TriangleMesh, sources: list[int]) -> np.ndarray:
    """Return refined distances on any mesh."""
    return np.asarray(HeatDistance(mesh, robust=True).from_vertices(sources)["distance"])


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
    np.testing.assert_allclose(refined(mesh, [source]), chord, rtol=1e-12)


def test_cylinder_is_exact() -> None:
    """On a cylinder the distance is the shorter straight line of its two unfoldings."""
    mesh, exact = cylinder()
    found = refined(mesh, [0])
    np.testing.assert_allclose(found, exact, rtol=1e-12)


@pytest.mark.parametrize("robust", [False, True])
def test_heat_distance_refined(robust: bool) -> None:
    """Refined distances are exact ones, with less than 0.3 of the plain error; heat stays as it is."""
    mesh = icosphere(3)
    exact = np.arccos(np.clip(mesh.vertices @ mesh.vertices[12], -1, 1))
    plain = HeatDistance(mesh, "h2", robust=robust, refine=False).from_vertices([12])
    exact_ones = HeatDistance(mesh, "h2", robust=robust, refine=True).from_vertices([12])
    assert exact_ones.report["refined"]
    assert not plain.report["refined"]
    assert HeatDistance(mesh, "h2", robust=robust).from_vertices([12]).report["refined"] == robust
    errors = [np.abs(result["distance"] - exact).mean() for result in (plain, exact_ones)]
    assert errors[1] < 0.3 * errors[0]
    np.testing.assert_array_equal(exact_ones["distance"], ExactDistance(mesh).from_vertices([12])["distance"])
    np.testing.assert_array_equal(exact_ones["heat"], plain["heat"])


def test_slivers_do_not_matter() -> None:
    """On a flat grid sheared by ten cells the distance is the straight line."""
    square = grid(20, 20)
    sheared = TriangleMesh(square.vertices @ [[1, 0, 0], [10, 1, 0], [0, 0, 1]], square.faces)
    chord = np.linalg.norm(sheared.vertices - sheared.vertices[0], axis=1)
    np.testing.assert_allclose(refined(sheared, [0]), chord, rtol=1e-10)


def test_faces_without_area() -> None:
    """Faces that are segments or points do not change the distances of a flat square."""
    square = grid(6, 6)
    n = square.n_vertices
    points = np.concatenate([square.vertices, square.vertices[:1], [square.vertices[:2].mean(axis=0)]])
    faces = np.concatenate([square.faces, [[0, 1, n + 1], [0, n, 1], [n, 0, n + 1]]])
    found = refined(TriangleMesh(points, faces), [5])
    np.testing.assert_allclose(found, np.linalg.norm(points - points[5], axis=1), rtol=1e-12)
