"""Convergence of the stream function of a rigid rotation of the sphere."""

import numpy as np

from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.mesh.primitives import icosphere
from support.rates import fitted_rate


def test_rotation_of_the_sphere() -> None:
    """The rigid rotation e_z × r is coexact; its stream function converges to -z with order h²."""
    errors, sizes = [], []
    for level in (3, 4, 5):
        mesh = icosphere(level)
        result = HelmholtzDecomposition(mesh)(np.cross([0, 0, 1], mesh.face_centers))
        errors.append(np.sqrt(np.mean((result["stream_function"] + mesh.vertices[:, 2]) ** 2)))
        sizes.append(mesh.mean_edge_length)
        assert result.report["energy_shares"]["coexact"] > 0.999
    assert fitted_rate(sizes, errors) > 1.8
