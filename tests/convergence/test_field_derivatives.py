"""Second order of brackets and derivatives of fields on spheres, on regular and on random triangulations."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from geomhw.flow import FieldDerivatives, rigid_field, tangential
from geomhw.mesh import cylinder_band, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators import directional_derivative
from support.meshes import scattered_sphere
from support.rates import fitted_rate

FAMILIES: dict[str, Callable[[int], TriangleMesh]] = {
    "icospheres": icosphere,
    "scattered": lambda level: scattered_sphere(10 * 4**level),
}
X, Y, Z = np.eye(3)


@cache
def derivatives_on(family: str, level: int) -> FieldDerivatives:
    """Return the derivatives on a sphere of a family, once."""
    return FieldDerivatives(FAMILIES[family](level))


def on_sphere(mesh: TriangleMesh, field: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Sample a field on the sphere above the face centers: its tangential part, along the faces."""
    x = mesh.face_centers / np.linalg.norm(mesh.face_centers, axis=1)[:, None]
    return tangential(mesh, tangent(x, field(x)))


def tangent(x: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the part of vectors along the sphere at x."""
    return vectors - np.einsum("ix,ix->i", vectors, x)[:, None] * x


def wavy(x: np.ndarray) -> np.ndarray:
    """Return a smooth field without symmetry."""
    return np.stack([np.sin(2 * x[:, 1]), x[:, 2] * x[:, 0], np.cos(x[:, 0] + x[:, 1])], axis=1)


def other(x: np.ndarray) -> np.ndarray:
    """Return another one."""
    return np.stack([x[:, 2], np.exp(x[:, 0]), x[:, 0] * x[:, 1]], axis=1)


def third(x: np.ndarray) -> np.ndarray:
    """Return a third one."""
    return np.stack([x[:, 0] * x[:, 1], x[:, 2] ** 2, np.sin(x[:, 1])], axis=1)


def rate(family: str, error: Callable[[FieldDerivatives], np.ndarray], *, largest: bool = False) -> float:
    """Return the fitted rate of the L2 norm, or of the largest error, on three levels."""
    sizes, errors = [], []
    for level in (3, 4, 5):
        derivatives = derivatives_on(family, level)
        values, mesh = error(derivatives), derivatives.mesh
        rows = np.linalg.norm(values.reshape(len(values), -1), axis=1)
        weights = mesh.face_areas if len(rows) == mesh.n_faces else mesh.vertex_areas
        sizes.append(mesh.n_vertices**-0.5)
        errors.append(float(rows.max() if largest else np.sqrt(weights @ rows**2 / weights.sum())))
    return fitted_rate(sizes, errors)


@pytest.mark.parametrize("family", FAMILIES)
def test_bracket_of_rotations(family: str) -> None:
    """[X, Y] = -Z for the rotations about the axes, with second order also in the largest error.

    The fields may be sampled on the faces, as `rigid_field` does, or on the sphere above them.
    """

    def in_space(derivatives: FieldDerivatives) -> np.ndarray:
        U, V, W = (rigid_field(derivatives.mesh, axis) for axis in (X, Y, Z))
        return derivatives.bracket(U, V) + W

    def above(derivatives: FieldDerivatives) -> np.ndarray:
        U, V, W = (on_sphere(derivatives.mesh, lambda x, axis=axis: np.cross(axis, x)) for axis in (X, Y, Z))
        return derivatives.bracket(U, V) + W

    assert rate(family, in_space) > 1.9
    assert rate(family, in_space, largest=True) > 1.8
    assert rate(family, above) > 1.9


@pytest.mark.parametrize("family", FAMILIES)
def test_commutator_on_functions(family: str) -> None:
    """D_U D_V - D_V D_U of local fits converges with second order; that of piecewise constant fields does not."""

    def exact(x: np.ndarray) -> np.ndarray:
        slope = np.stack([np.exp(x[:, 0]) + x[:, 1], x[:, 0], 0 * x[:, 0]], axis=1)
        return -np.einsum("ix,ix->i", np.cross(Z, x), slope)

    def error(derivatives: FieldDerivatives, kind: str) -> np.ndarray:
        mesh = derivatives.mesh
        x = mesh.vertices
        f = np.exp(x[:, 0]) + x[:, 0] * x[:, 1]
        U, V = rigid_field(mesh, X), rigid_field(mesh, Y)
        if kind == "fitted":
            return derivatives.commutator(U, V) @ f - exact(x)
        if kind == "bracket":
            return derivatives.directional_derivative(derivatives.bracket(U, V)) @ f - exact(x)
        A, B = directional_derivative(mesh, U), directional_derivative(mesh, V)
        return (A @ (B @ f) - B @ (A @ f)) - exact(x)

    assert rate(family, lambda derivatives: error(derivatives, "bracket")) > 1.8
    assert rate(family, lambda derivatives: error(derivatives, "fitted")) > (1.8 if family == "icospheres" else 1.6)
    assert rate(family, lambda derivatives: error(derivatives, "constant")) < 1.2


@pytest.mark.parametrize("family", FAMILIES)
def test_covariant_derivative_of_a_rotation(family: str) -> None:
    """∇_Z Z is the tangential part of ω x (ω x r); its divergence is 0, its curl 2z, its Hodge Laplacian 2Z."""

    def error(derivatives: FieldDerivatives, part: str) -> np.ndarray:
        mesh, W = derivatives.mesh, rigid_field(derivatives.mesh, Z)
        if part == "covariant":
            exact = on_sphere(mesh, lambda x: np.cross(Z, np.cross(Z, x)))
            return derivatives.covariant_derivative(W, W) - exact
        if part == "curl":
            return derivatives.curl(W) - 2 * mesh.vertices[:, 2]
        if part == "hodge":
            return derivatives.hodge_laplacian(W) - 2 * W
        return derivatives.strain(W) if part == "strain" else derivatives.divergence(W)

    for part in ("covariant", "curl", "hodge", "strain", "divergence"):
        assert rate(family, lambda derivatives, part=part: error(derivatives, part)) > 1.9, part


@pytest.mark.parametrize("family", FAMILIES)
def test_metric_compatibility_and_jacobi(family: str) -> None:
    """U⟨V, W⟩ = ⟨∇_U V, W⟩ + ⟨V, ∇_U W⟩ with second order; the Jacobi identity holds to the order of the fits."""

    def metric(derivatives: FieldDerivatives) -> np.ndarray:
        U, V, W = (on_sphere(derivatives.mesh, field) for field in (wavy, other, third))
        v, w = derivatives.at_vertices(V), derivatives.at_vertices(W)
        u = derivatives.at_vertices(U)
        left = derivatives.directional_derivative(U) @ np.einsum("ix,ix->i", v, w)
        right = np.einsum("ixy,iy,ix->i", derivatives.covariant(V), u, w)
        return left - right - np.einsum("ixy,iy,ix->i", derivatives.covariant(W), u, v)

    def jacobi(derivatives: FieldDerivatives) -> np.ndarray:
        bracket = derivatives.bracket
        U, V, W = (on_sphere(derivatives.mesh, field) for field in (wavy, other, third))
        return bracket(U, bracket(V, W)) + bracket(V, bracket(W, U)) + bracket(W, bracket(U, V))

    assert rate(family, metric) > 1.8
    assert rate(family, jacobi) > 1.5


def test_parallel_fields_of_a_cylinder() -> None:
    """The fields along and around a cylinder, a flat surface, are parallel."""
    sizes, errors = [], []
    for count in (16, 32, 64):
        mesh = cylinder_band(count, count // 4)
        derivatives = FieldDerivatives(mesh)
        around = np.cross(Z, mesh.face_centers)
        around /= np.linalg.norm(around, axis=1)[:, None]
        constant = np.tile(Z, (mesh.n_faces, 1))
        sizes.append(mesh.mean_edge_length)
        found = [derivatives.covariant_derivative(field, around + constant) for field in (around, constant)]
        errors.append(float(np.abs(found).max()))
    assert fitted_rate(sizes, errors) > 1.8
