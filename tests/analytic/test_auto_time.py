"""The default diffusion time is as good as h² on every mesh at every scale."""

import numpy as np
import pytest

from geomhw.geodesic import HeatDistance, time_step
from geomhw.io import read_mesh
from geomhw.mesh import TriangleMesh, icosphere
from geomhw.options import Connection
from support.exact import mean_angle_error
from support.meshes import sheared, zoo_mesh
from support.reference import needs_reference, reference

SCALES = np.logspace(-6, 6, 25)


def scaled(mesh: TriangleMesh, scale: float) -> TriangleMesh:
    """The same mesh in another unit of length."""
    return TriangleMesh(mesh.vertices * scale, mesh.faces)


def mean_error(mesh: TriangleMesh, time: str | float, exact: np.ndarray, source: int) -> float:
    """Mean relative error of plain distances."""
    found = HeatDistance(mesh, time).from_vertices([source])["distance"]
    known = np.isfinite(exact) & (exact > 0)
    return float(np.abs(found[known] / exact[known] - 1).mean())


@pytest.mark.parametrize(
    "name", ["sphere", "crumpled_sphere", "torus", "crumpled_torus", "genus_two", "grid", "strip", "annulus"]
)
def test_auto_is_as_accurate_as_h2_at_every_scale(name: str) -> None:
    """At 25 scales from 1e-6 to 1e6, and where √h is 0.25 to 1 h²: at most 1.1 times the error of h²."""
    mesh = zoo_mesh(name)
    h, source = mesh.mean_edge_length, mesh.n_vertices // 2
    exact = np.asarray(HeatDistance(mesh, "h2", refine=True).from_vertices([source])["distance"])
    by_square = mean_error(mesh, "h2", exact, source)
    near = [ratio ** (-2 / 3) / h for ratio in (0.26, 0.337, 0.5, 0.7, 0.99)]  # scales at which √h is that many h²
    for scale in [*SCALES, *near]:
        t = time_step("auto", scaled(mesh, scale)).t / (scale * h) ** 2
        error = by_square if t == pytest.approx(1) else mean_error(mesh, f"{float(t)!r}*h2", exact, source)
        assert error <= 1.1 * by_square, scale


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
def test_transport_with_auto_is_as_accurate_as_with_h2(connection: Connection) -> None:
    """On spheres at the same scales, against transport along great circles: at most 1.1 times the error of h²."""
    mesh = icosphere(3)
    h = mesh.mean_edge_length
    by_square = mean_angle_error(3, connection, "h2")
    for scale in [*SCALES, *(ratio ** (-2 / 3) / h for ratio in (0.26, 0.337, 0.5, 0.7, 0.99))]:
        t = time_step("auto", scaled(mesh, scale)).t / (scale * h) ** 2
        error = by_square if t == pytest.approx(1) else mean_angle_error(3, connection, f"{float(t)!r}*h2")
        assert error <= 1.1 * by_square, scale


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_negative_weights_take_h2(scale: float) -> None:
    """√h is not considered where a cotan weight is negative."""
    mesh = sheared(12, 2.0)
    mesh = scaled(mesh, scale * 2 / mesh.mean_edge_length)
    assert time_step("auto", mesh).t == pytest.approx(mesh.mean_edge_length**2)


@needs_reference
def test_moomoo_keeps_the_handouts_time() -> None:
    """On the course's mesh, in its own unit, √h = 0.337 h² is the more accurate of both."""
    mesh = read_mesh(reference("meshes/closed/moomoo.off"))
    assert time_step("auto", mesh).t == np.sqrt(mesh.mean_edge_length)
    smaller = scaled(mesh, 1e-3)
    assert time_step("auto", smaller).t == pytest.approx(smaller.mean_edge_length**2)


@needs_reference
def test_a_plate_in_millimeters() -> None:
    """The same relative errors at any scale: √h would be 5 times as far off in millimeters."""
    mesh = read_mesh(reference("meshes/reported/00_auto_time_plate_in_mm.off"))
    exact = np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)
    errors = [mean_error(scaled(mesh, scale), "auto", scale * exact, 0) for scale in (1e-3, 1.0, 1e3)]
    np.testing.assert_allclose(errors, mean_error(mesh, "h2", exact, 0), rtol=1e-9)


def test_the_choice_does_not_depend_on_the_numbering() -> None:
    """Renumbered and turned, the same time."""
    ball = icosphere(3)
    mesh = scaled(ball, 0.4 ** (-2 / 3) / ball.mean_edge_length)
    order = np.random.default_rng(0).permutation(mesh.n_vertices)
    other = TriangleMesh(mesh.vertices[order] @ np.roll(np.eye(3), 1, axis=0), np.argsort(order)[mesh.faces[::-1]])
    assert time_step("auto", other).t == pytest.approx(time_step("auto", mesh).t, rel=1e-12)
