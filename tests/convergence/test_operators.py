"""Convergence of the cotan Laplacian: its Rayleigh quotient on the sphere."""

from geomhw.mesh.primitives import icosphere
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import consistent_mass
from support.rates import fitted_rate


def test_laplacian_converges_on_the_sphere() -> None:
    """The Rayleigh quotient of x converges with order h² to 2, the eigenvalue of -Δ on the unit sphere."""
    errors, sizes = [], []
    for level in (2, 3, 4, 5):
        mesh = icosphere(level)
        x = mesh.vertices[:, 0]
        errors.append(abs(x @ (stiffness(mesh) @ x) / (x @ (consistent_mass(mesh) @ x)) - 2))
        sizes.append(mesh.mean_edge_length)
    assert fitted_rate(sizes, errors) > 1.95
