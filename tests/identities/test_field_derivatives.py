"""Exact identities of brackets and derivatives: polynomials in the plane, symmetries, scale."""

import numpy as np
import pytest

from geomhw.flow import FieldDerivatives, derivatives_of, random_field, rigid_field
from geomhw.mesh import grid, icosphere, moebius_band
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.scalars import vertex_gradient
from support.hostile import arrays, far_away, flipped
from support.meshes import ZOO, book, zoo_mesh


def crooked_square() -> TriangleMesh:
    """Return a flat square with displaced vertices, also at the boundary."""
    square = grid(9, 9)
    noise = np.random.default_rng(1).uniform(-0.03, 0.03, square.vertices.shape)
    return TriangleMesh(square.vertices + noise * [1, 1, 0], square.faces)


def test_linear_fields_in_the_plane() -> None:
    """[Ax, Bx] = (BA - AB)x, and all derivatives of linear fields, to rounding up to the boundary."""
    mesh = crooked_square()
    chance = np.random.default_rng(2)
    A, B = np.zeros((2, 3, 3))
    A[:2, :2], B[:2, :2] = chance.normal(size=(2, 2, 2))
    U, V = mesh.face_centers @ A.T, mesh.face_centers @ B.T
    derivatives = FieldDerivatives(mesh)
    np.testing.assert_allclose(derivatives.bracket(U, V), mesh.face_centers @ (B @ A - A @ B).T, atol=1e-10)
    np.testing.assert_allclose(derivatives.covariant_derivative(V, U), mesh.face_centers @ (B @ A).T, atol=1e-10)
    np.testing.assert_allclose(derivatives.divergence(V), np.trace(B), atol=1e-10)
    np.testing.assert_allclose(derivatives.curl(V), B[1, 0] - B[0, 1], atol=1e-10)
    np.testing.assert_allclose(derivatives.strain(V), np.broadcast_to((B + B.T) / 2, (mesh.n_faces, 3, 3)), atol=1e-10)
    x, y, _ = mesh.face_centers.T
    turn = np.stack([-y * y, x * x, 0 * x], axis=1)  # curl 2x + 2y
    np.testing.assert_allclose(derivatives.hodge_laplacian(turn), np.tile([2.0, -2.0, 0], (len(x), 1)), atol=1e-8)


@pytest.mark.parametrize("cells", [(12, 1), (2, 2), (1, 1), (12, 2)])
def test_few_faces(cells: tuple[int, int]) -> None:
    """Linear fields have exact derivatives also where the faces do not determine a quadratic."""
    mesh = grid(*cells)
    if cells == (1, 1):  # two faces determine derivatives along one line only
        assert np.isfinite(FieldDerivatives(mesh).divergence(mesh.face_centers)).all()
    else:
        np.testing.assert_allclose(FieldDerivatives(mesh).divergence(mesh.face_centers), 2, atol=1e-10)


@pytest.mark.parametrize("name", ZOO)
def test_bracket_is_antisymmetric_and_torsion_is_zero(name: str) -> None:
    """[U, V] = -[V, U] = ∇_U V - ∇_V U to rounding, on every mesh, with or without enough faces for a fit."""
    mesh = zoo_mesh(name)
    U, V = np.random.default_rng(3).normal(size=(2, mesh.n_faces, 3))
    derivatives = FieldDerivatives(mesh)
    bracket = derivatives.bracket(U, V)
    size = np.abs(bracket).max() + 1
    np.testing.assert_allclose(derivatives.bracket(V, U), -bracket, atol=1e-12 * size)
    torsion = derivatives.covariant_derivative(V, U) - derivatives.covariant_derivative(U, V) - bracket
    assert np.abs(torsion).max() < 1e-9 * size
    assert all(np.isfinite(field.values).all() for field in derivatives_of(mesh, U, V).fields)
    flow = derivatives.directional_derivative(U)
    assert np.abs(flow.sum(axis=1)).max() < 1e-8 * (abs(flow).max() + 1)


@pytest.mark.parametrize("scale", [1e-20, 1e20])
def test_moved_scaled_and_renumbered(scale: float) -> None:
    """Brackets turn and scale with the mesh, and do not depend on the numbering or on the orientation."""
    mesh = icosphere(2)
    U, V = random_field(mesh, 1), rigid_field(mesh, [1, 2, 3])
    bracket = FieldDerivatives(mesh).bracket(U, V)
    size = np.abs(bracket).max()
    chance = np.random.default_rng(4)
    Q, _ = np.linalg.qr(chance.normal(size=(3, 3)))
    vertices, faces = chance.permutation(mesh.n_vertices), chance.permutation(mesh.n_faces)
    corners = np.argsort(vertices)[mesh.faces[faces]]
    corners[::3] = corners[::3, ::-1]
    other = TriangleMesh(scale * (mesh.vertices[vertices] @ Q.T), corners)
    found = FieldDerivatives(other).bracket(scale * U[faces] @ Q.T, V[faces] @ Q.T)
    np.testing.assert_allclose(found, bracket[faces] @ Q.T, atol=1e-9 * size)


def test_one_sided_surface() -> None:
    """A Moebius band has brackets: they need no orientation."""
    mesh = moebius_band(60, 9)
    bracket = FieldDerivatives(mesh).bracket(rigid_field(mesh, [0, 0, 1]), rigid_field(mesh, [1, 0, 0]))
    assert np.isfinite(bracket).all()
    lengths = np.linalg.norm(bracket, axis=1)
    assert lengths.max() < 5 * np.median(lengths)


def cube() -> TriangleMesh:
    """Return a cube of 4 x 4 x 4 cells, each side divided along the grid."""
    side = grid(4, 4)
    points = [np.roll(np.insert(side.vertices[:, :2], 2, z, axis=1), k, axis=1) for k in range(3) for z in (0, 1)]
    faces = [side.faces[:, ::-1] if k % 2 == 0 else side.faces for k in range(6)]
    every = np.concatenate([face + k * side.n_vertices for k, face in enumerate(faces)])
    vertices, names = np.unique(np.concatenate(points).round(12), axis=0, return_inverse=True)
    return TriangleMesh(vertices, names.ravel()[every])


def test_faces_orthogonal_to_the_normal_of_a_vertex() -> None:
    """On a cube, where the side on which a face lies is rounding, the bracket turns with the mesh."""
    mesh = cube()
    U, V = mesh.face_centers @ np.random.default_rng(4).normal(size=(2, 3, 3))
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turned = FieldDerivatives(TriangleMesh(mesh.vertices @ turn.T, mesh.faces)).bracket(U @ turn.T, V @ turn.T)
    np.testing.assert_allclose(turned, FieldDerivatives(mesh).bracket(U, V) @ turn.T, atol=1e-9)


def test_far_from_the_origin() -> None:
    """A million sizes away, derivatives are those of the mesh moved back, to rounding."""
    far = TriangleMesh(*far_away(arrays(icosphere(3))))
    near = TriangleMesh(far.vertices - far.vertices[0], far.faces)
    U, V = near.face_centers @ np.random.default_rng(6).normal(size=(2, 3, 3))
    np.testing.assert_allclose(FieldDerivatives(far).bracket(U, V), FieldDerivatives(near).bracket(U, V), atol=1e-9)


def test_sheets_that_meet_at_an_edge() -> None:
    """Pages of a book, flipped or not, each have the derivatives of a plane."""
    mesh = book()
    other = TriangleMesh(*flipped(arrays(mesh)))
    page = np.arange(mesh.n_faces) < mesh.n_faces // 3
    U, V = mesh.face_centers @ np.random.default_rng(7).normal(size=(2, 3, 3))
    bracket = FieldDerivatives(mesh).bracket(U, V)
    np.testing.assert_allclose(FieldDerivatives(other).bracket(U, V), bracket, atol=1e-10)
    alone = FieldDerivatives(TriangleMesh(mesh.vertices, mesh.faces[page])).bracket(U[page], V[page])
    np.testing.assert_allclose(bracket[page], alone, atol=1e-10)
    z = mesh.vertices[:, 2]
    np.testing.assert_allclose(vertex_gradient(other, z), np.tile([0.0, 0.0, 1.0], (len(z), 1)), atol=1e-10)
