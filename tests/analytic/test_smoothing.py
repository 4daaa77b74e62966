"""Smoothing against Gaussians of the plane and the heat kernel of the sphere; gradients at vertices."""

import numpy as np
import pytest
from numpy.polynomial.legendre import legval

from geomhw.mesh import TriangleMesh, grid, icosphere
from geomhw.scalars import HeatSmoothing, diffusion_time, smooth, vertex_gradient
from support.rates import fitted_rate

BALL = icosphere(5)


def half_width(distance: np.ndarray, values: np.ndarray, at: int) -> float:
    """Return the full width at half maximum of a bell, by a line through the logarithms next to the half."""
    share = values / values[at]
    near = (share > 0.35) & (share < 0.65)
    slope, start = np.polyfit(np.log(share[near]), distance[near] ** 2, 1)
    return float(2 * np.sqrt(start + slope * np.log(0.5)))


def plane(irregular: bool) -> TriangleMesh:
    """Return a square of 90 x 90 cells, with vertices moved at random or not."""
    mesh = grid(90, 90)
    shift = np.random.default_rng(0).uniform(-0.2, 0.2, (mesh.n_vertices, 3)) / 90 * [1, 1, 0]
    shift[mesh.boundary_vertices] = 0
    return TriangleMesh(mesh.vertices + irregular * shift, mesh.faces)


@pytest.mark.parametrize("irregular", [False, True])
def test_gaussian_of_the_plane(irregular: bool) -> None:
    """A Gaussian of one width becomes one of the root of the sum of squares, to 1 %; a point one of the width."""
    mesh = plane(irregular)
    center = int(np.argmin(np.linalg.norm(mesh.vertices - mesh.vertices.mean(axis=0), axis=1)))
    r = np.linalg.norm(mesh.vertices - mesh.vertices[center], axis=1)
    first, width = 0.12, 0.16
    smoothed = smooth(mesh, np.exp(-4 * np.log(2) * (r / first) ** 2), width)
    assert half_width(r, smoothed, center) == pytest.approx(np.hypot(first, width), rel=0.005)
    spread = smooth(mesh, np.eye(1, mesh.n_vertices, center)[0], width)
    assert half_width(r, spread, center) == pytest.approx(width, rel=0.01)
    areas = mesh.vertex_areas
    variance = areas @ (spread * r**2) / (areas @ spread) / 2
    assert np.sqrt(8 * np.log(2) * variance) == pytest.approx(width, rel=0.01)


@pytest.mark.parametrize("center", [0, 5000])
@pytest.mark.parametrize("width", [0.4, 0.8])
def test_heat_kernel_of_the_sphere(center: int, width: float) -> None:
    """A point becomes the heat kernel of the sphere: its width to 1 %, its values to 1 % in the mean square."""
    t, areas = diffusion_time(width), BALL.vertex_areas
    values = smooth(BALL, np.eye(1, BALL.n_vertices, center)[0] / areas[center], width)
    degrees = np.arange(200)
    kernel = (2 * degrees + 1) / (4 * np.pi) * np.exp(-degrees * (degrees + 1) * t)
    cosine = np.clip(BALL.vertices @ BALL.vertices[center], -1, 1)
    exact = legval(cosine, kernel)
    r = np.arccos(cosine)
    assert half_width(r, values, center) == pytest.approx(half_width(r, exact, center), rel=0.01)
    assert areas @ (values - exact) ** 2 < 1e-4 * (areas @ exact**2)


@pytest.mark.parametrize("edges", [3, 4.9, 5.1])
def test_narrow_gaussians_on_an_irregular_sphere(edges: float) -> None:
    """A point becomes the heat kernel to 1.5 % in the mean square where the width is some edges; sums and 1 stay."""
    moved = BALL.vertices + 0.1 * BALL.mean_edge_length * np.random.default_rng(0).normal(size=BALL.vertices.shape)
    mesh = TriangleMesh(moved / np.linalg.norm(moved, axis=1)[:, None], BALL.faces)
    width, areas, centers = edges * mesh.mean_edge_length, mesh.vertex_areas, [0, 700, 5000]
    points = np.zeros((mesh.n_vertices, 3))
    points[centers, range(3)] = 1 / areas[centers]
    smoothing = HeatSmoothing(mesh, width)
    values, degrees = smoothing(points), np.arange(500)
    kernel = (2 * degrees + 1) / (4 * np.pi) * np.exp(-degrees * (degrees + 1) * smoothing.time)
    exact = legval(np.clip(mesh.vertices @ mesh.vertices[centers].T, -1, 1), kernel)
    assert (areas @ (values - exact) ** 2 < 0.015**2 * (areas @ exact**2)).all()
    np.testing.assert_allclose(areas @ values, 1, rtol=1e-12)
    np.testing.assert_allclose(smoothing(np.full(mesh.n_vertices, 3.0)), 3, rtol=1e-12)


def test_gradient_at_vertices_is_of_third_order() -> None:
    """The gradient of a smooth function on the sphere has an error that falls with the cube of the edge length."""
    errors, sizes = [], []
    for level in (2, 3, 4):
        ball = icosphere(level)
        moved = ball.vertices + np.random.default_rng(0).normal(size=ball.vertices.shape) * 0.1 * ball.mean_edge_length
        points = moved / np.linalg.norm(moved, axis=1, keepdims=True)
        mesh = TriangleMesh(points, ball.faces)
        x, y, z = points.T
        ambient = np.stack([2 * x, z, y], axis=1)
        exact = ambient - (ambient * points).sum(axis=1)[:, None] * points
        error = np.linalg.norm(vertex_gradient(mesh, x**2 + y * z) - exact, axis=1)
        errors.append(np.sqrt((error**2).mean()))
        sizes.append(mesh.mean_edge_length)
    assert fitted_rate(sizes, errors) > 2.7
    assert errors[-1] < 0.001
