"""Convergence of vector transport to that along great circles."""

import pytest

from geomhw.mesh.primitives import icosphere
from geomhw.options import Connection
from support.exact import mean_angle_error
from support.rates import fitted_rate


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
def test_transport_on_the_sphere(connection: Connection) -> None:
    """At t = √h the mean angle to transport along great circles is of order h^1.6 on these meshes."""
    errors = [mean_angle_error(level, connection, "sqrt-h") for level in (3, 4, 5)]
    assert all(error <= bound for error, bound in zip(errors, (0.045, 0.015, 0.0045), strict=True)), errors
    assert fitted_rate([icosphere(level).mean_edge_length for level in (3, 4, 5)], errors) > 1.6
