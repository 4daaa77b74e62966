"""Convergence of the cotan Laplacian: its Rayleigh quotient on the sphere."""

import numpy as np

from geomhw.mesh.primitives import icosphere
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import consistent_mass


def test_laplacian_converges_on_the_sphere() -> None:
    """x is an eigenfunction of -Δ on the unit sphere with eigenvalue 2: the Rayleigh quotient converges as h²."""
    errors, sizes = [], []
    for level in (2, 3, 4):
        mesh = icosphere(level)
        x = mesh.vertices[:, 0]
        errors.append(abs(x @ (stiffness(mesh) @ x) / (x @ (consistent_mass(mesh) @ x)) - 2))
        sizes.append(mesh.mean_edge_length)
    rate = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert rate > 1.9
