"""Spectra against closed forms: sphere, flat torus, disc and rectangle, and their Hodge and connection Laplacians."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import jn_zeros

from geomhw.intrinsic import IntrinsicMesh
from geomhw.mesh.primitives import grid, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators import stiffness
from geomhw.results import Result
from geomhw.spectral import (
    connection_spectrum,
    hodge_spectrum,
    laplacian_spectrum,
    mean_mass,
    smallest_eigenpairs,
)
from support.meshes import annulus, disc
from support.rates import fitted_rate

SPHERE = np.concatenate([[degree * (degree + 1)] * (2 * degree + 1) for degree in range(6)])


def eigenvalues(result: Result) -> np.ndarray:
    """Return the eigenvalues of a report."""
    return np.array(result.report["eigenvalues"])


def functions(result: Result) -> np.ndarray:
    """Return the eigenfunctions in columns."""
    return np.stack([field.values for field in result.fields], axis=-1)


def test_sphere_converges_with_second_order() -> None:
    """The eigenvalues l(l+1) have multiplicity 2l+1; the errors fall with the square of the edge length."""
    errors = []
    for level in (3, 4, 5):
        found = eigenvalues(laplacian_spectrum(icosphere(level), 36))
        assert abs(found[0]) < 1e-12
        errors.append(float(np.abs(found[1:] / SPHERE[1:] - 1).max()))
    assert errors[-1] < 8e-4
    assert fitted_rate([1 / 8, 1 / 16, 1 / 32], errors) > 1.85


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
def test_orthonormal_pairs_at_any_scale(scale: float) -> None:
    """Eigenfunctions are orthonormal, residuals are rounding, and eigenvalues scale with 1/length²."""
    ball = icosphere(3)
    mesh = TriangleMesh(scale * ball.vertices, ball.faces)
    result = laplacian_spectrum(mesh, 20)
    phi, M = functions(result), mean_mass(mesh)
    np.testing.assert_allclose(phi.T @ (M @ phi), np.eye(20), atol=1e-11)
    assert max(result.report["residuals"]) < 1e-10
    np.testing.assert_allclose(eigenvalues(result) * scale**2, eigenvalues(laplacian_spectrum(ball, 20)), atol=1e-9)
    energies = np.einsum("ik,ik->k", phi, stiffness(mesh) @ phi)
    np.testing.assert_allclose(energies * scale**2, eigenvalues(result) * scale**2, atol=1e-9)


def test_rectangle_and_disc() -> None:
    """Rectangle: π²(a² + b²) with both conditions. Disc of radius 1: squares of Bessel zeros."""
    side = np.pi**2 * np.array([0, 1, 1, 2, 4, 4, 5, 5])
    mesh = grid(40, 40)
    np.testing.assert_allclose(eigenvalues(laplacian_spectrum(mesh, 8)), side, rtol=4e-3, atol=1e-10)
    inner = np.pi**2 * np.array([2, 5, 5, 8])
    np.testing.assert_allclose(eigenvalues(laplacian_spectrum(mesh, 4, "dirichlet")), inner, rtol=8e-3)
    zeros = np.sort([*jn_zeros(0, 2), *np.repeat(jn_zeros(1, 1), 2), *np.repeat(jn_zeros(2, 1), 2)])[:5]
    errors = []
    for rings in (16, 32, 64):
        found = eigenvalues(laplacian_spectrum(disc(rings), 5, "dirichlet"))
        errors.append(float(np.abs(found / zeros**2 - 1).max()))
    assert errors[-1] < 1e-3
    assert fitted_rate([1 / 16, 1 / 32, 1 / 64], errors) > 1.8


def test_components_and_lone_vertices() -> None:
    """Each component has a constant, 0 elsewhere; a vertex without faces has the value 0."""
    ball = icosphere(2)
    n = ball.n_vertices
    vertices = np.concatenate([ball.vertices, 2 * ball.vertices + 9, [[50.0, 0, 0]]])
    mesh = TriangleMesh(vertices, np.concatenate([ball.faces, ball.faces + n]))
    result = laplacian_spectrum(mesh, 3)
    np.testing.assert_allclose(eigenvalues(result)[:2], 0, atol=1e-12)
    phi = functions(result)
    constant = 1 / np.sqrt(ball.face_areas.sum())
    np.testing.assert_allclose(phi[:n, 0], constant, rtol=1e-9)
    np.testing.assert_allclose(phi[n:, 0], 0, atol=1e-9)
    np.testing.assert_allclose(phi[n : 2 * n, 1], constant / 2, rtol=1e-9)
    assert (phi[-1] == 0).all()


def test_basis_is_the_same_for_another_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """Multiplets have a canonical basis: another start of the iteration gives the same functions."""
    ball = icosphere(3)
    one = functions(laplacian_spectrum(ball, 25))
    chance = np.random.default_rng(7)
    monkeypatch.setattr("geomhw.spectral.eigenpairs.start_vectors", lambda n, count: chance.normal(size=(n, count)))
    np.testing.assert_allclose(functions(laplacian_spectrum(ball, 25)), one, atol=1e-8)


def test_fields_on_the_sphere() -> None:
    """Hodge Laplacian: l(l+1), twice 2l+1 fields; connection Laplacian: l(l+1) - 1, as complex pairs."""
    result = hodge_spectrum(icosphere(4), 16)
    np.testing.assert_allclose(eigenvalues(result), [2] * 6 + [6] * 10, rtol=3e-3)
    mesh, fields = result.mesh, functions(result)
    products = np.einsum("fxi,fxj,f->ij", fields, fields, mesh.face_areas)
    np.testing.assert_allclose(products, np.eye(16), atol=1e-10)
    assert sorted(result.report["kinds"][:6]) == ["coexact"] * 3 + ["gradient"] * 3
    found = eigenvalues(connection_spectrum(icosphere(4), 8, "intrinsic"))
    np.testing.assert_allclose(found, [1] * 3 + [5] * 5, rtol=5e-3)


def test_flat_torus() -> None:
    """On the flat torus of sides 2π, given by edge lengths alone: a² + b² for integers a and b, with second order."""
    errors = []
    for count in (12, 24, 48):
        ring = torus(count, count)
        x, y, z = ring.vertices.T
        angles = np.stack([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y) - 1.0)], axis=1)
        steps = (angles[ring.edges[:, 1]] - angles[ring.edges[:, 0]] + np.pi) % (2 * np.pi) - np.pi
        flat = replace(IntrinsicMesh.of(ring), lengths=np.linalg.norm(steps, axis=1))
        found = eigenvalues(laplacian_spectrum(ring, 13, surface=flat))
        errors.append(float(np.abs(found[1:] / np.repeat([1, 2, 4], 4) - 1).max()))
    assert errors[-1] < 5e-3
    assert fitted_rate([1 / 12, 1 / 24, 1 / 48], errors) > 1.9


def test_harmonic_fields_come_first() -> None:
    """On a torus two fields have the eigenvalue 0; a disc has none."""
    result = hodge_spectrum(torus(24, 12), 6)
    assert result.report["kinds"][:2] == ["harmonic", "harmonic"]
    assert eigenvalues(result)[2] > 0.1
    mesh = grid(12, 12)
    flow = hodge_spectrum(mesh, 8)
    assert set(flow.report["kinds"]) == {"gradient", "coexact"}
    square = np.pi**2 * np.sort([1, 1, 2, 2, 4, 4, 5, 5])
    np.testing.assert_allclose(eigenvalues(flow), square, rtol=3e-2)
    ring = annulus()
    kinds = hodge_spectrum(ring, 4).report["kinds"]
    assert kinds.count("harmonic") == 1


@pytest.mark.parametrize("copies", [5, 30])
def test_no_copy_of_a_multiple_eigenvalue_is_missed(copies: int) -> None:
    """Equal components give each eigenvalue many times, more often than a block has columns."""
    ball = icosphere(1)
    n = ball.n_vertices
    vertices = np.concatenate([ball.vertices + np.array([3.0 * k, 0, 0]) for k in range(copies)])
    mesh = TriangleMesh(vertices, np.concatenate([ball.faces + n * k for k in range(copies)]))
    single = eigenvalues(laplacian_spectrum(ball, 4))
    found = eigenvalues(laplacian_spectrum(mesh, 4 * copies))
    np.testing.assert_allclose(found, np.repeat(single, copies), rtol=1e-9, atol=1e-11)


def test_equal_values_at_the_end_and_invariant_subspaces() -> None:
    """Copies of one value fill the upper half of those computed; a block that is nearly invariant stays orthogonal."""
    ball = icosphere(2)
    points = np.concatenate([ball.vertices + np.array([3.0 * k, 0, 0]) for k in range(12)])
    faces = np.concatenate([ball.faces + ball.n_vertices * k for k in range(12)])
    S, M = stiffness(TriangleMesh(points, faces)), mean_mass(TriangleMesh(points, faces))
    np.testing.assert_allclose(smallest_eigenpairs(S, M, 2).values, 0, atol=1e-12)
    stretched = TriangleMesh(icosphere(4).vertices * [1, 1, 40], icosphere(4).faces)
    report = laplacian_spectrum(stretched, 100).report
    assert max(report["residuals"]) < 1e-9
