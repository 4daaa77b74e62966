"""Convergence of distances by unfolding to those along great circles."""

import numpy as np

from geomhw.mesh.primitives import icosphere
from support.exact import unfolded
from support.rates import fitted_rate


def test_sphere_converges() -> None:
    """The mean relative error against great circles is of order h² on these meshes."""
    errors, sizes = [], []
    for level in (2, 3, 4, 5):
        mesh = icosphere(level)
        exact = np.arccos(np.clip(mesh.vertices @ mesh.vertices[12], -1, 1))
        away = exact > 0
        errors.append(np.mean(np.abs(unfolded(mesh, [12]) - exact)[away] / exact[away]))
        sizes.append(mesh.mean_edge_length)
    assert errors[-1] < 1e-3
    assert fitted_rate(sizes, errors) > 2.0
