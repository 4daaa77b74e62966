"""Factorizations: exact against dense algebra, in blocks as alone, refused where singular."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import lu_factor, lu_solve

from geomhw.errors import ConvergenceError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators import backward_euler, complex_connection_stiffness, stiffness
from geomhw.solvers.direct import BLOCK, DirectSolver, SparseLU
from geomhw.solvers.nullspace import free_unknowns, without_mean
from support.meshes import ZOO, zoo_mesh


def systems(name: str) -> dict[str, sp.csr_array]:
    """Real, complex and unsymmetric systems on a mesh of the zoo; unused vertices have rows of their own."""
    mesh = zoo_mesh(name)
    areas = np.where(mesh.vertex_areas > 0, mesh.vertex_areas, 1.0)
    t = mesh.mean_edge_length**2
    A = backward_euler(areas, stiffness(mesh), t)
    scale = np.exp(0.3 * np.sin(np.arange(mesh.n_vertices)))
    found = {"real": A, "scaled": sp.csr_array(A.multiply(scale[:, None] / scale))}
    if mesh.is_orientable:
        found["complex"] = backward_euler(areas, complex_connection_stiffness(mesh), t)
    return found


@pytest.mark.parametrize("name", sorted(ZOO))
def test_solutions_are_those_of_dense_algebra(name: str) -> None:
    """One right-hand side, a few, and a block of them, real and complex, to rounding."""
    rng = np.random.default_rng(0)
    for A in systems(name).values():
        solve, dense = SparseLU(A), lu_factor(A.toarray())
        for shape in ((), (3,), (BLOCK + 1,)):
            real, imaginary = rng.normal(size=(2, A.shape[0], *shape))
            for b in (real, real + 1j * imaginary):
                expected = lu_solve(dense, b)
                np.testing.assert_allclose(solve(b), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_columns_of_a_block_are_solutions_alone() -> None:
    """A block is solved by compiled loops, one column by SuperLU; they agree to rounding, for real and complex."""
    rng = np.random.default_rng(1)
    for A in systems("crumpled_torus").values():
        b = rng.normal(size=(A.shape[0], 40)).astype(A.dtype)
        solve = SparseLU(A)
        x = solve(b)
        for column in (0, 17, 39):
            np.testing.assert_allclose(x[:, column], solve(b[:, column]), rtol=1e-12, atol=1e-14 * np.abs(x).max())


def test_held_unknowns_are_zero() -> None:
    """A semidefinite matrix with one vertex per component held, and unused vertices: S x = b, zero where held."""
    mesh = zoo_mesh("two_spheres")
    free = free_unknowns(mesh.components, mesh.unreferenced_vertices)
    b = without_mean(np.sin(np.arange(mesh.n_vertices)), mesh.components)
    b[mesh.unreferenced_vertices] = 0
    x = DirectSolver(stiffness(mesh), free)(np.stack([b] * BLOCK, axis=1))
    assert not x[~free].any()
    for column in (0, BLOCK - 1):
        np.testing.assert_allclose(stiffness(mesh) @ x[:, column], b, atol=1e-12)
    assert DirectSolver(stiffness(mesh), np.zeros_like(free))(b).shape == b.shape


@pytest.mark.parametrize("columns", [1, BLOCK])
def test_singular_matrices_are_refused(columns: int) -> None:
    """An empty row, or a Laplacian without a held vertex and an unbalanced right-hand side."""
    chain = sp.csr_array(sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(30, 30))).tolil()
    chain[7], chain[:, [7]] = 0, 0
    with pytest.raises(ConvergenceError, match="no finite solution"):
        SparseLU(chain.tocsr())(np.ones((30, columns)))


@pytest.mark.parametrize("name", ["sphere", "two_spheres"])
def test_means_are_removed(name: str) -> None:
    """The rest has mean zero on each component, by weights if there are any; integrals sum to zero; columns alike."""
    mesh = zoo_mesh(name)
    labels, areas = mesh.components, mesh.vertex_areas
    f = np.exp(mesh.vertices[:, 0])
    columns = np.stack([f, f**2], axis=1)
    for component in np.unique(labels[mesh.faces]):
        inside = labels == component
        assert abs(without_mean(f, labels)[inside].mean()) < 1e-12
        assert abs((areas * without_mean(f, labels, areas))[inside].sum()) < 1e-12
        assert abs(without_mean(areas * f, labels, areas, integrated=True)[inside].sum()) < 1e-12
    np.testing.assert_allclose(
        without_mean(areas * f, labels, areas, integrated=True), areas * without_mean(f, labels, areas), atol=1e-13
    )
    for options in ({}, {"weights": areas}, {"weights": areas, "integrated": True}):
        alone = [without_mean(column, labels, **options) for column in columns.T]  # type: ignore[arg-type]
        together = without_mean(columns, labels, **options)  # type: ignore[arg-type]
        np.testing.assert_allclose(together, np.stack(alone, axis=1), atol=1e-13)


def test_dense_rows_are_eliminated_last() -> None:
    """A bipyramid of 2,000 faces has two rows of 1,000 neighbors: little fill, and the solution of dense algebra."""
    n = 1000
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    i = np.arange(n)
    sides = [np.stack([i, np.roll(i, s), np.full(n, n + k)], axis=1) for k, s in enumerate((-1, 1))]
    mesh = TriangleMesh(np.vstack([ring, [[0, 0, 1], [0, 0, -1]]]), np.vstack(sides))
    solve = SparseLU(A := backward_euler(mesh.vertex_areas, stiffness(mesh), mesh.mean_edge_length**2))
    assert set(solve._order[-2:]) == {n, n + 1}
    assert solve._lu.L.nnz <= 5 * (n + 2)
    b = np.random.default_rng(0).normal(size=n + 2)
    np.testing.assert_allclose(solve(b), np.linalg.solve(A.toarray(), b), rtol=0, atol=1e-11)
