"""Identities of the connection Laplacian: symmetry, eq. (4), flat limits, and both connections."""

import numpy as np
import pytest
import scipy.sparse as sp

from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness, connection_stiffness
from geomhw.operators.laplacian import stiffness
from geomhw.operators.parallel_transport import edge_rotations, from_complex, to_complex
from support.meshes import ZOO, zoo_mesh

DELAUNAY = ["triangle", "tetrahedron", "sphere", "torus", "grid", "strip", "annulus", "two_spheres"]


def test_rotations(mesh: TriangleMesh) -> None:
    """R is the rotation from n_i to n_j by the angle between them."""
    i, j = mesh.edges.T
    R = edge_rotations(mesh)
    n = mesh.vertex_normals
    np.testing.assert_allclose(np.einsum("exy,ey->ex", R, n[i]), n[j], atol=1e-14)
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.broadcast_to(np.eye(3), R.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-13)
    np.testing.assert_allclose(np.trace(R, axis1=1, axis2=2), 1 + 2 * np.einsum("ex,ex->e", n[i], n[j]), atol=1e-13)


def test_energy_is_equation_4(mesh: TriangleMesh) -> None:
    """VᵀCV is the sum over edges of w |V_j - R_ij V_i|² for any V; C is symmetric."""
    C = connection_stiffness(mesh)
    assert abs(C - C.T).max() <= 1e-15 * abs(C).max()
    V = np.random.default_rng(2).normal(size=(mesh.n_vertices, 3))
    i, j = mesh.edges.T
    gap = V[j] - np.einsum("exy,ey->ex", edge_rotations(mesh), V[i])
    terms = mesh.edge_cotan_weights * np.einsum("ex,ex->e", gap, gap)
    assert V.ravel() @ (C @ V.ravel()) == pytest.approx(terms.sum(), rel=1e-11, abs=1e-11 * np.abs(terms).sum())


@pytest.mark.parametrize("name", DELAUNAY)
def test_positive_semidefinite(name: str) -> None:
    """No eigenvalue is negative where no cotan weight is."""
    mesh = zoo_mesh(name)
    assert mesh.edge_cotan_weights.min() > -1e-12
    for matrix in (complex_connection_stiffness(mesh), complex_connection_stiffness(mesh, "intrinsic")):
        values = np.linalg.eigvalsh(matrix.toarray())
        assert values[0] > -1e-12 * values[-1]


@pytest.mark.parametrize("name", ["grid", "strip", "annulus"])
def test_flat_is_three_copies(name: str) -> None:
    """On flat meshes C is S ⊗ 1, and both complex forms have the spectrum of S."""
    mesh = zoo_mesh(name)
    S = stiffness(mesh)
    C = connection_stiffness(mesh)
    assert abs(C - sp.kron(S, sp.eye_array(3))).max() < 1e-14
    expected = np.linalg.eigvalsh(S.toarray())
    for connection in ("normals", "intrinsic"):
        found = np.linalg.eigvalsh(complex_connection_stiffness(mesh, connection).toarray())
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_complex_form_is_the_tangent_part(mesh: TriangleMesh) -> None:
    """On tangent fields C and K agree, and C maps them to tangent fields."""
    tangent_all = np.setdiff1d(np.arange(mesh.n_vertices), mesh.unreferenced_vertices)
    rng = np.random.default_rng(4)
    z = rng.normal(size=mesh.n_vertices) + 1j * rng.normal(size=mesh.n_vertices)
    V = from_complex(mesh, z)
    CV = (connection_stiffness(mesh) @ V.ravel()).reshape(-1, 3)
    size = np.abs(CV).max()
    np.testing.assert_allclose(np.einsum("vx,vx->v", CV, mesh.vertex_normals), 0, atol=1e-13 * size)
    K = complex_connection_stiffness(mesh)
    assert abs(K - K.conj().T).max() <= 1e-15 * abs(K).max()
    np.testing.assert_allclose(from_complex(mesh, K @ z)[tangent_all], CV[tangent_all], atol=1e-13 * size)
    np.testing.assert_allclose(to_complex(mesh, V)[tangent_all], z[tangent_all], atol=1e-14)


def test_opposite_normals_do_not_blow_up() -> None:
    """Between opposite normals R is a rotation by 180° about a perpendicular axis."""
    mesh = _folded()
    R = edge_rotations(mesh)
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.broadcast_to(np.eye(3), R.shape), atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-12)
    i, j = mesh.edges.T
    moved = np.einsum("exy,ey->ex", R, mesh.vertex_normals[i])
    np.testing.assert_allclose(moved, mesh.vertex_normals[j], atol=1e-12)


def _folded() -> TriangleMesh:
    """Return two flat fans with opposite normals at vertices 0 and 1, joined by a small face."""
    mesh = TriangleMesh(
        [
            [0, 0, 0],
            [0.1, 0, 0],
            [0, 1, 0],
            [-1, 0, 0],
            [0, -1, 0],
            [0.1, 1, 0],
            [1.1, 0, 0],
            [0.1, -1, 0],
            [0.05, 0.01, 0],
        ],
        [[0, 2, 3], [0, 3, 4], [1, 5, 6], [1, 6, 7], [0, 1, 8]],
    )
    normals = mesh.vertex_normals
    assert normals[0] @ normals[1] == pytest.approx(-1)
    return mesh


def test_zoo_is_covered() -> None:
    """The list names meshes of the zoo."""
    assert set(DELAUNAY) <= set(ZOO)
