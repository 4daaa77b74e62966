"""Identities of the operators on every mesh of the zoo; invariance under scaling, translation, renumbering."""

from collections.abc import Callable

import numpy as np
import pytest
import scipy.sparse as sp

from geomhw.arrays import pieces
from geomhw.mesh.geometry import at_corners
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.topology import edge_graph
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.averaging import faces_to_vertices, vertices_to_faces
from geomhw.operators.crouzeix_raviart import crouzeix_raviart_gradient
from geomhw.operators.directional_derivative import directional_derivative, face_derivative
from geomhw.operators.divergence import divergence, divergence_of
from geomhw.operators.edge_matrix import edge_matrix, weight_sums
from geomhw.operators.gradient import corner_gradients, gradient, gradient_of
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import consistent_mass, lumped_mass
from support.meshes import ZOO, zoo_mesh


def relative(difference: sp.sparray, scale: sp.sparray) -> float:
    """Return the largest entry of one matrix over that of another."""
    return float(abs(difference).max() / abs(scale).max())


def some_field(mesh: TriangleMesh) -> np.ndarray:
    """Return a smooth face field that depends on the normals only."""
    return np.cross(mesh.face_normals, [0.3, -0.5, 0.8])


def test_divergence_of_gradient_is_minus_stiffness(mesh: TriangleMesh) -> None:
    """Div G = -S."""
    S = stiffness(mesh)
    assert relative(divergence(mesh) @ gradient(mesh) + S, S) < 1e-12


def test_stiffness_is_the_dirichlet_form(mesh: TriangleMesh) -> None:
    """S = GᵀAG, symmetric, with constants in its null space."""
    G, S = gradient(mesh), stiffness(mesh)
    A = sp.diags_array(np.repeat(mesh.face_areas, 3))
    assert relative(G.T @ A @ G - S, S) < 1e-12
    assert relative(S - S.T, S) == 0
    assert np.abs(S @ np.ones(mesh.n_vertices)).max() <= 1e-13 * abs(S).max()
    assert np.abs(G @ np.ones(mesh.n_vertices)).max() <= 1e-12 * abs(G).max()


@pytest.mark.parametrize("name", [name for name in ZOO if name != "genus_two"])  # too large for dense eigenvalues
def test_stiffness_is_positive_semidefinite(name: str) -> None:
    """No eigenvalue of S is negative, and there is one zero per component and per vertex without faces."""
    mesh = zoo_mesh(name)
    values = np.linalg.eigvalsh(stiffness(mesh).toarray())
    assert values[0] > -1e-12 * values[-1]
    zeros = mesh.n_components + len(mesh.unreferenced_vertices)
    assert np.count_nonzero(values < 1e-10 * values[-1]) == zeros


def test_gradient_of_a_linear_function(mesh: TriangleMesh) -> None:
    """∇(a·x) is the tangential part of a."""
    a = np.array([0.7, -1.1, 0.4])
    tangent = a - (mesh.face_normals @ a)[:, None] * mesh.face_normals
    np.testing.assert_allclose((gradient(mesh) @ (mesh.vertices @ a)).reshape(-1, 3), tangent, atol=1e-11)


def test_divergence_sums_to_zero(mesh: TriangleMesh) -> None:
    """The integrated divergence of any field sums to zero, also with boundary."""
    spread = divergence(mesh) @ some_field(mesh).ravel()
    assert abs(spread.sum()) < 1e-12 * np.abs(spread).sum() + 1e-14


def test_masses(mesh: TriangleMesh) -> None:
    """Both masses hold the area; rows of the consistent mass sum to the lumped one; it integrates products."""
    M, C = lumped_mass(mesh), consistent_mass(mesh)
    ones = np.ones(mesh.n_vertices)
    np.testing.assert_allclose(C @ ones, M @ ones, rtol=1e-13)
    assert (M @ ones).sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-13)
    x = mesh.vertices[:, 0]
    # Exact for linear functions: edge midpoints integrate quadratics.
    midpoints = (x[mesh.faces] + np.roll(x[mesh.faces], 1, axis=1)) / 2
    assert x @ (C @ x) == pytest.approx((mesh.face_areas / 3) @ (midpoints**2).sum(axis=1), rel=1e-12)


def test_averages_are_stochastic(mesh: TriangleMesh) -> None:
    """P and Q map constants to constants, with nonnegative weights [OATVF, eq. 6]."""
    P, Q = faces_to_vertices(mesh), vertices_to_faces(mesh)
    surface = np.ones(mesh.n_vertices)
    surface[mesh.unreferenced_vertices] = 0
    np.testing.assert_allclose(P @ np.ones(mesh.n_faces), surface, rtol=1e-14)
    np.testing.assert_allclose(Q @ np.ones(mesh.n_vertices), 1, rtol=1e-14)
    assert P.data.min() > 0
    assert Q.data.min() > 0


def test_averages_are_adjoint(mesh: TriangleMesh) -> None:
    """M P = QᵀA: both averages have the same integrals."""
    M, A = lumped_mass(mesh), sp.diags_array(mesh.face_areas)
    left = M @ faces_to_vertices(mesh)
    assert relative(left - vertices_to_faces(mesh).T @ A, left) < 1e-14


def test_directional_derivative(mesh: TriangleMesh) -> None:
    """D_V 1 = 0, D_V^F f = V·∇f, D_V = P D_V^F, and D_V is linear in V."""
    V = some_field(mesh)
    D = directional_derivative(mesh, V)
    size = abs(D).max()
    assert np.abs(D @ np.ones(mesh.n_vertices)).max() < 1e-12 * size
    f = np.sin(mesh.vertices @ [1.0, 2.0, -1.0])
    slope = (gradient(mesh) @ f).reshape(-1, 3)
    along = np.einsum("fx,fx->f", V, slope)
    np.testing.assert_allclose(face_derivative(mesh, V) @ f, along, atol=1e-12 * size)
    np.testing.assert_allclose(D @ f, faces_to_vertices(mesh) @ along, atol=1e-12 * size)
    assert relative(directional_derivative(mesh, -2 * V) + 2 * D, D) < 1e-13


def test_edge_functions_fill_what_gradients_leave(closed_mesh: tuple[TriangleMesh, int]) -> None:
    """Rotated edge gradients are orthogonal to gradients; both leave a space of dimension 2g."""
    mesh, genus = closed_mesh
    G, E = gradient(mesh), crouzeix_raviart_gradient(mesh)
    area = np.repeat(mesh.face_areas, 3)
    turned = sp.block_diag([sp.csr_array(np.cross(np.eye(3), n).T) for n in mesh.face_normals]).tocsr() @ E
    cross = G.T @ sp.diags_array(area) @ turned
    assert abs(cross).max() < 1e-12 * abs(stiffness(mesh)).max()
    if mesh.n_vertices < 300:
        ranks = [np.linalg.matrix_rank(B.toarray(), tol=1e-9 * abs(B).max()) for B in (G, turned)]
        assert 2 * mesh.n_faces - sum(ranks) == 2 * genus


OPERATORS: dict[str, tuple[Callable[[TriangleMesh], sp.sparray], int, str, str]] = {
    "gradient": (gradient, -1, "face3", "vertex"),
    "divergence": (divergence, 1, "vertex", "face3"),
    "stiffness": (stiffness, 0, "vertex", "vertex"),
    "lumped_mass": (lumped_mass, 2, "vertex", "vertex"),
    "consistent_mass": (consistent_mass, 2, "vertex", "vertex"),
    "faces_to_vertices": (faces_to_vertices, 0, "vertex", "face"),
    "vertices_to_faces": (vertices_to_faces, 0, "face", "vertex"),
    "face_derivative": (lambda mesh: face_derivative(mesh, some_field(mesh)), -1, "face", "vertex"),
    "directional_derivative": (lambda mesh: directional_derivative(mesh, some_field(mesh)), -1, "vertex", "vertex"),
}


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scaling(mesh: TriangleMesh, operator: str, factor: float) -> None:
    """Each operator scales with the power of length in its units."""
    build, power, _, _ = OPERATORS[operator]
    small = build(mesh)
    large = build(TriangleMesh(mesh.vertices * factor, mesh.faces))
    assert relative(large / factor**power - small, small) < 1e-12


@pytest.mark.parametrize("operator", OPERATORS)
def test_moving(mesh: TriangleMesh, operator: str) -> None:
    """A translation by 1000 times the size changes operators by the rounding of the coordinates only."""
    size = np.ptp(mesh.vertices, axis=0).max()
    moved = TriangleMesh(mesh.vertices + 1e3 * size * np.array([1.0, -1.0, 0.5]), mesh.faces)
    before, after = OPERATORS[operator][0](mesh), OPERATORS[operator][0](moved)
    rounding = 1e3 * np.finfo(float).eps * size / mesh.edge_lengths.min()
    sharpest = np.abs(1 / np.sin(mesh.angles)).max() ** 2
    assert relative(after - before, before) < 20 * rounding * sharpest


@pytest.mark.parametrize("operator", OPERATORS)
def test_renumbering(mesh: TriangleMesh, operator: str) -> None:
    """Renumbering vertices and faces and rotating corners permutes each operator."""
    rng = np.random.default_rng(3)
    vertex, face = rng.permutation(mesh.n_vertices), rng.permutation(mesh.n_faces)
    new_name = np.empty_like(vertex)
    new_name[vertex] = np.arange(mesh.n_vertices)
    shuffled = TriangleMesh(mesh.vertices[vertex], np.roll(new_name[mesh.faces[face]], 1, axis=1))
    order = {
        "vertex": vertex,
        "face": face,
        "face3": (3 * face[:, None] + np.arange(3)).ravel(),
    }
    build, _, rows, columns = OPERATORS[operator]
    before = sp.csr_array(build(mesh))[order[rows]][:, order[columns]]
    assert relative(sp.csr_array(build(shuffled)) - before, before) < 1e-12


def test_matrix_over_edges() -> None:
    """The matrix is Hermitian; multiple edges are summed, and an edge to its own vertex counts twice."""
    edges = np.array([[2, 0], [0, 1], [2, 0], [1, 1]], dtype=np.int32)
    values, diagonal = np.array([1 + 2j, 3.0, 10j, 5 - 1j]), np.array([0.5, -1.0, 7.0])
    expected = np.diag(diagonal).astype(complex)
    for (i, j), value in zip(edges, values, strict=True):
        expected[i, j] += value
        expected[j, i] += np.conj(value)
    np.testing.assert_array_equal(edge_matrix(edges, values, diagonal).toarray(), expected)
    np.testing.assert_array_equal(edge_matrix(edges, values.real, diagonal).toarray(), expected.real)
    np.testing.assert_array_equal(weight_sums(edges, values.real, 3), [4, 13, 1])
    assert [edge_graph(edges, values, 3)[[i]].data.tolist() for i in range(3)] == [[3], [5 - 1j], [1 + 2j, 10j]]


def test_gradient_beside_faces_without_area(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gradient is zero on faces of zero area only, in any piece of the mesh."""
    ball = icosphere(1)
    flat = np.array([[0, 42, 1], [0, 42, 1]])
    vertices = np.concatenate([ball.vertices, ball.vertices[[0, 1]].mean(axis=0)[None]])
    mesh = TriangleMesh(vertices, np.concatenate([ball.faces[:10], flat[:1], ball.faces[10:], flat[1:]]))
    np.testing.assert_array_equal(mesh.degenerate_faces, [10, 81])
    monkeypatch.setattr("geomhw.arrays.PIECE", 7)
    corners = at_corners(mesh.vertices @ [1.0, 2.0, 3.0], mesh.faces)
    slopes = np.concatenate([corner_gradients(mesh, faces, corners[faces]) for faces in pieces(mesh.n_faces)])
    assert not slopes[[10, 81]].any()
    whole = gradient_of(ball, ball.vertices @ [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(np.delete(slopes, [10, 81], axis=0), whole)


def test_flat_grid_stencil() -> None:
    """On a square grid the cotan Laplacian is the five-point stencil."""
    S = stiffness(grid(4, 4, 4.0, 4.0)).toarray()
    middle = 12
    row = {int(j): round(float(S[middle, j]), 12) for j in np.flatnonzero(np.abs(S[middle]) > 1e-12)}
    assert sorted(row.values()) == [-1, -1, -1, -1, 4]


def test_zoo_has_a_loose_vertex_and_a_boundary() -> None:
    """The zoo has a vertex without faces and a mesh with boundary."""
    assert zoo_mesh("two_spheres").unreferenced_vertices.size
    assert zoo_mesh("annulus").boundary_vertices.size


def test_divergence_of_one_field(mesh: TriangleMesh) -> None:
    """The divergence without its matrix is the same."""
    field = np.random.default_rng(8).normal(size=(mesh.n_faces, 3))
    expected = divergence(mesh) @ field.ravel()
    np.testing.assert_allclose(divergence_of(mesh, field), expected, atol=1e-13 * np.abs(expected).max())
