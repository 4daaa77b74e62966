"""Distances between the corners of an icosahedron, which are known up to symmetry."""

import numpy as np

from geomhw.geodesic.heat_method import HeatDistance
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.primitives import icosphere


def test_symmetry_is_that_of_the_mesh() -> None:
    """Between the 12 corners of an icosphere there are three positive distances, 5, 5 and 1 times."""
    mesh = icosphere(4)
    rows = HeatDistance(mesh, "h2", queries=12).rows([vertex_points(mesh, [v]) for v in range(12)])[:, :12]
    np.testing.assert_allclose(np.sort(rows, axis=1), np.tile(np.sort(rows[0]), (12, 1)), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(np.diff(np.sort(rows[0]))[[1, 2, 3, 4, 6, 7, 8, 9]], 0, atol=1e-12)
    np.testing.assert_allclose(rows.max(), np.pi, rtol=0.02)
