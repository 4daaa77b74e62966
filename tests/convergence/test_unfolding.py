"""Convergence of distances by unfolding to those along great circles."""

import numpy as np

from geomhw.mesh.primitives import icosphere
from support.exact import unfolded


def test_sphere_converges() -> None:
    """The mean relative error against great circles at least halves when edges do."""
    errors = []
    for level in (2, 3, 4, 5):
        mesh = icosphere(level)
        exact = np.arccos(np.clip(mesh.vertices @ mesh.vertices[12], -1, 1))
        away = exact > 0
        errors.append(np.mean(np.abs(unfolded(mesh, [12]) - exact)[away] / exact[away]))
    assert errors[-1] < 1e-3
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 0.9).all()
