"""Pushforward by a rotation of the sphere is the rotated field; fields without divergence keep none."""

import numpy as np
import pytest

from geomhw.flow import Pushforward, random_field, rigid_field, tangential
from geomhw.mesh import grid, icosphere, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators import divergence
from support.meshes import scattered_sphere
from support.rates import fitted_rate

ANGLE = 1.0
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]])
Z = np.array([0.0, 0, 1])


def wavy(x: np.ndarray) -> np.ndarray:
    """Return a smooth field on the sphere without symmetry."""
    V = np.stack([np.sin(2 * x[:, 1]), x[:, 2] * x[:, 0], np.cos(x[:, 0] + x[:, 1])], axis=1)
    return V - np.einsum("ix,ix->i", V, x)[:, None] * x


def turned(x: np.ndarray) -> np.ndarray:
    """Return that field, rotated with the sphere."""
    return wavy(x @ TURN) @ TURN.T


def error(mesh: TriangleMesh, kind: str) -> float:
    """Return the root mean square error of a field or function after the rotation."""
    flow = Pushforward(mesh, rigid_field(mesh, Z))
    x = mesh.face_centers / np.linalg.norm(mesh.face_centers, axis=1)[:, None]
    start, exact = (tangential(mesh, field(x)) for field in (wavy, turned))
    if kind == "function":
        difference = flow.function(wavy(mesh.vertices), ANGLE) - wavy(mesh.vertices @ TURN)
        return float(np.sqrt(np.mean(difference**2)))
    if kind == "rotation":
        start, exact = rigid_field(mesh, [1, 0, 0]), rigid_field(mesh, TURN[:, 0])
    difference = flow.field(start, ANGLE, "form" if kind == "form" else "vector") - exact
    return float(np.sqrt(mesh.face_areas @ (difference**2).sum(axis=1) / mesh.face_areas.sum()))


@pytest.mark.parametrize("kind", ["rotation", "vector", "form", "function"])
def test_rotated_fields(kind: str) -> None:
    """Rates on icospheres and on random triangulations."""
    regular = [icosphere(level) for level in (2, 3, 4)]
    assert fitted_rate([mesh.mean_edge_length for mesh in regular], [error(mesh, kind) for mesh in regular]) > 1.85
    scattered = [scattered_sphere(count) for count in (160, 640, 2560)]
    assert fitted_rate([mesh.n_vertices**-0.5 for mesh in scattered], [error(mesh, kind) for mesh in scattered]) > 1


@pytest.mark.parametrize("name", ["icosphere", "scattered", "torus"])
def test_divergence_stays_zero(name: str) -> None:
    """A field n x ∇ψ has no divergence after the flow of a rotation, nor after that of another such field."""
    mesh = {"icosphere": icosphere(3), "scattered": scattered_sphere(600), "torus": torus(40, 20)}[name]
    V = random_field(mesh, 1)
    for U in (rigid_field(mesh, Z), random_field(mesh, 2)):
        flow = Pushforward(mesh, U)
        assert flow.keeps_divergence_zero(V)
        moved = flow.field(V, 1.0)
        assert np.abs(divergence(mesh) @ moved.ravel()).max() < 1e-12 * np.linalg.norm(V, axis=1).max()
        assert np.linalg.norm(moved - V) > 0.05 * np.linalg.norm(V)
    source = tangential(mesh, np.tile(Z, (mesh.n_faces, 1)))
    assert not Pushforward(mesh, source).keeps_divergence_zero(V)
    assert not flow.keeps_divergence_zero(source)


def test_parallel_transport_in_the_plane() -> None:
    """In the plane a constant field is parallel, along any flow, with inflow and outflow."""
    mesh = grid(10, 10)
    U = np.stack([1 + mesh.face_centers[:, 1], np.sin(mesh.face_centers[:, 0]), np.zeros(mesh.n_faces)], axis=1)
    constant = np.tile([1.0, 2.0, 0.0], (mesh.n_faces, 1))
    flow = Pushforward(mesh, U)
    np.testing.assert_allclose(flow.field(constant, 0.4, "parallel"), constant, atol=1e-10)
    entering = np.flatnonzero((mesh.vertices[:, 0] == 0) & (mesh.vertices[:, 1] > 0))
    rows = abs(flow.operator("vector")).sum(axis=1).reshape(-1, 3).sum(axis=1)
    assert len(entering)
    assert (rows[entering] == 0).all()
    assert (rows[np.setdiff1d(np.arange(mesh.n_vertices), mesh.boundary_vertices)] > 0).all()


@pytest.mark.parametrize("scale", [1e-20, 1e20])
def test_scaled_and_renumbered(scale: float) -> None:
    """The pushforward does not depend on scale and numbering, and a field is pushed to itself by its own flow."""
    mesh = icosphere(2)
    U, V = rigid_field(mesh, Z), rigid_field(mesh, [1, 2, 3])
    moved = Pushforward(mesh, U).field(V, ANGLE)
    order = np.random.default_rng(4).permutation(mesh.n_vertices)
    other = TriangleMesh(scale * mesh.vertices[order], np.argsort(order)[mesh.faces])
    np.testing.assert_allclose(Pushforward(other, scale * U).field(V, ANGLE), moved, atol=1e-9)
    assert np.abs(Pushforward(mesh, U).field(U, ANGLE) - U).max() < 0.02
