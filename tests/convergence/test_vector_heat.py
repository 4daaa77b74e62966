"""Convergence of vector transport to that along great circles."""

import numpy as np
import pytest

from geomhw.mesh.primitives import icosphere
from geomhw.options import Connection
from geomhw.transport.vector_heat import VectorHeat, random_tangent
from support.exact import along_great_circles

CONNECTIONS: tuple[Connection, ...] = ("normals", "intrinsic")


def mean_angle_error(level: int, connection: Connection) -> float:
    """Degrees, over vertices not within 10° of the antipode, averaged over sources of five and six neighbors."""
    mesh = icosphere(level)
    solver = VectorHeat(mesh, "h2", connection)
    errors = []
    for source in (0, 12, 42, 100, 300, 641):
        vector = random_tangent(mesh, source, seed=1)
        X = solver.from_vertices([source], [vector])["transported"]
        np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1, atol=1e-12)
        exact = along_great_circles(mesh, source, vector)
        angle = np.arctan2(np.linalg.norm(np.cross(X, exact), axis=1), np.einsum("vx,vx->v", X, exact))
        kept = mesh.vertices @ mesh.vertices[source] > -np.cos(np.radians(10))
        errors.append(np.degrees(angle[kept]).mean())
    return float(np.mean(errors))


@pytest.mark.parametrize("connection", CONNECTIONS)
def test_transport_on_the_sphere(connection: Connection) -> None:
    """Mean angle error against transport along great circles on 642, 2,562 and 10,242 vertices."""
    errors = [mean_angle_error(level, connection) for level in (3, 4, 5)]
    assert all(error <= bound for error, bound in zip(errors, (0.3, 0.2, 0.12), strict=True)), errors
