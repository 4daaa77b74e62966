"""Vector transport against exact transport: on strips, in the plane, between two sources."""

import numpy as np
import pytest

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.primitives import icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import Connection
from geomhw.transport.vector_heat import VectorHeat, tangent_at
from support.exact import along_great_circles, mean_angle_error
from support.meshes import sheared, split_diagonals, zoo_mesh

CONNECTIONS: tuple[Connection, ...] = ("normals", "intrinsic")


@pytest.mark.parametrize("connection", CONNECTIONS)
def test_transport_on_the_sphere(connection: Connection) -> None:
    """At t = h² the mean angle to transport along great circles is below 0.3, 0.2 and 0.12° on three icospheres.

    They have 642, 2,562 and 10,242 vertices. At t = h² the angle does not vanish with h; it does at t = √h.
    """
    errors = [mean_angle_error(level, connection, "h2") for level in (3, 4, 5)]
    assert all(error <= bound for error, bound in zip(errors, (0.3, 0.2, 0.12), strict=True)), errors


@pytest.mark.parametrize("connection", CONNECTIONS)
def test_reach(connection: Connection) -> None:
    """Along a strip of 3000 cells transport is the identity."""
    mesh = strip(3000)
    X = VectorHeat(mesh, connection=connection).from_vertices([0], [[1.2, 1.6, 0.0]])["transported"]
    np.testing.assert_allclose(X, np.broadcast_to([1.2, 1.6, 0.0], X.shape), atol=1e-9)


def test_reach_with_several_lengths() -> None:
    """Between two sources with lengths 1 and 3, each half of a strip of 3000 cells keeps the nearer length."""
    mesh = strip(3000)
    ends = [int(mesh.vertices[:, 0].argmin()), int(mesh.vertices[:, 0].argmax())]
    X = VectorHeat(mesh).from_vertices(ends, [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])["transported"]
    x = mesh.vertices[:, 0] - mesh.vertices[:, 0].min()
    np.testing.assert_allclose(X[x < 1450, 0], 1, atol=1e-6)
    np.testing.assert_allclose(X[x > 1550, 0], 3, atol=1e-6)


def test_two_sources_keep_their_own() -> None:
    """Vectors of lengths 1 and 3 at opposite points keep their lengths nearby; all lengths lie between them."""
    mesh = icosphere(4)
    a, b = 0, int((mesh.vertices @ mesh.vertices[0]).argmin())
    vectors = [tangent_at(mesh, a, 20), 3 * tangent_at(mesh, b, 70)]
    X = VectorHeat(mesh).from_vertices([a, b], vectors)["transported"]
    length = np.linalg.norm(X, axis=1)
    assert length.min() >= 1 - 1e-12
    assert length.max() <= 3 + 1e-12
    height = mesh.vertices @ mesh.vertices[a]
    np.testing.assert_allclose(length[height > 0.5], 1, atol=1e-3)
    np.testing.assert_allclose(length[height < -0.5], 3, atol=1e-3)
    np.testing.assert_allclose(X[[a, b]], vectors, atol=1e-12)


def test_scalar_extension() -> None:
    """Extended values equal the nearest source's value, and lie between the least and the largest."""
    mesh = icosphere(4)
    a, b = 0, int((mesh.vertices @ mesh.vertices[0]).argmin())
    values = VectorHeat(mesh).extend([b, a], [-2.0, 5.0])
    height = mesh.vertices @ mesh.vertices[a]
    np.testing.assert_allclose(values[height > 0.5], 5, atol=1e-2)
    np.testing.assert_allclose(values[height < -0.5], -2, atol=1e-2)
    assert values.min() >= -2
    assert values.max() <= 5
    assert np.isnan(VectorHeat(zoo_mesh("two_spheres")).extend([0], [1.0])[162:]).all()


def test_large_and_small_times() -> None:
    """As dt → 0, transport converges to that along shortest paths; for large dt it no longer depends on dt."""
    mesh = torus(48, 24)
    vector = tangent_at(mesh, 12, 30)

    def field(dt: str) -> np.ndarray:
        return VectorHeat(mesh, dt).from_vertices([12], [vector])["transported"]

    def gap(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.degrees(np.arccos(np.clip(np.einsum("vx,vx->v", a, b), -1, 1))).mean())

    assert 3 * gap(field("h2"), field("0.5*h2")) < gap(field("h2"), field("1e3"))
    assert gap(field("1e3"), field("1e4")) < 0.1


def test_robust_on_a_flat_mesh() -> None:
    """On flat meshes with degenerate faces robust transport is the identity, and |Y| equals the scalar heat."""
    for mesh in (split_diagonals(), sheared()):
        result = VectorHeat(mesh, "h2", robust=True).from_vertices([40], [[0.6, -0.8, 0]])
        np.testing.assert_allclose(
            result["transported"], np.broadcast_to([0.6, -0.8, 0], mesh.vertices.shape), atol=1e-9
        )
        heat = HeatDistance(mesh, "h2", robust=True).from_vertices([40])["heat"]
        np.testing.assert_allclose(result["diffused"] @ [0.6, -0.8, 0], heat, rtol=1e-6)


def test_robust_on_slivers() -> None:
    """On a sphere with slivers at the equator, `robust` halves the angle error."""
    points = icosphere(3).vertices * [1, 1, 0.1]
    mesh = TriangleMesh(points / np.linalg.norm(points, axis=1)[:, None], icosphere(3).faces)
    gaps = [0.0, 0.0]
    for robust in (False, True):
        solver = VectorHeat(mesh, "h2", robust=robust)
        for source in (0, 30, 100, 200):
            vector = tangent_at(mesh, source, 30)
            moved = solver.from_vertices([source], [vector])["transported"]
            cosines = np.einsum("vx,vx->v", moved, along_great_circles(mesh, source, vector))
            gaps[robust] += np.arccos(np.clip(cosines, -1, 1)).mean()
    assert 2 * gaps[True] < gaps[False]
