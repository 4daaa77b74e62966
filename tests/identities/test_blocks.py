"""Nested dissection and Cholesky factorization in blocks: what is exact, what is small, what is refused."""

import numpy as np
import pytest
import scipy.sparse as sp

from geomhw.errors import ConvergenceError
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import lumped_mass
from geomhw.solvers.cost_model import Work, cheapest
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.dissection import Dissection
from geomhw.solvers.fronts import BlockCholesky
from geomhw.solvers.superlu import SuperLU
from support.meshes import ZOO, zoo_mesh

#: So many solutions that blocks are the cheapest at any size.
MANY = Work(solves=10**6, at_once=64)


def heat_matrix(name: str) -> sp.csr_array:
    """M + h²S on a mesh of the zoo, with 1 for vertices without faces; larger ones by name."""
    mesh = {"large": lambda: icosphere(4), "long": lambda: strip(900), "flat": lambda: grid(40, 30)}.get(
        name, lambda: zoo_mesh(name)
    )()
    A = lumped_mass(mesh) + mesh.mean_edge_length**2 * stiffness(mesh)
    empty = np.zeros(mesh.n_vertices)
    empty[mesh.unreferenced_vertices] = 1
    return sp.csr_array(A + sp.diags_array(empty))


@pytest.mark.parametrize("leaf", [1, 4, 64])
@pytest.mark.parametrize("name", [*sorted(ZOO), "large", "long", "flat"])
def test_halves_do_not_touch(name: str, leaf: int) -> None:
    """Every entry of the matrix is between a node of the tree and one above or below it, or within one."""
    A = heat_matrix(name).tocoo()
    tree = Dissection.of(heat_matrix(name), leaf)
    assert tree.nodes.min() >= 1
    assert tree.nodes.max() < 2 << tree.depth
    a, b = np.sort(tree.nodes[np.stack(A.coords)], axis=0)
    levels = np.frexp(b)[1] - np.frexp(a)[1]
    np.testing.assert_array_equal(b >> levels, a)


def test_separators_are_short() -> None:
    """A grid is cut across, by a line of vertices, and a strip by an edge; a sphere by a great circle of 80."""
    for mesh, most in ((strip(900), 2), (grid(80, 20), 21), (icosphere(4), 82)):
        nodes = Dissection.of(stiffness(mesh)).nodes
        assert np.count_nonzero(nodes == 1) <= most
        halves = [np.count_nonzero(nodes >> (np.frexp(nodes)[1] - 2) == side) for side in (2, 3)]
        assert max(halves) <= 0.51 * mesh.n_vertices


@pytest.mark.parametrize("name", [*sorted(ZOO), "large", "long", "flat"])
def test_solutions(name: str) -> None:
    """What SuperLU finds, for one right-hand side, several, and impulses; A x = b to rounding."""
    A = heat_matrix(name)
    n = A.shape[0]
    solver, exact = BlockCholesky(A), SuperLU(A)
    b = np.random.default_rng(0).normal(size=(n, 7))
    x = solver(b)
    np.testing.assert_allclose(x, exact(b), rtol=0, atol=1e-12 * np.abs(x).max())
    np.testing.assert_allclose(solver(b[:, 0]), x[:, 0], rtol=0, atol=1e-13 * np.abs(x).max())
    np.testing.assert_array_equal(BlockCholesky(A)(b), x)
    impulses = np.zeros((n, 3))
    impulses[[0, n // 2, n - 1], [0, 1, 2]] = 1
    np.testing.assert_allclose(solver(impulses), exact(impulses), rtol=0, atol=1e-13 * exact(impulses).max())
    assert not solver(np.zeros((n, 2))).any()


def test_right_entry_by_entry() -> None:
    """Heat along 700 cells falls by a hundred orders of magnitude, and is right at each: a tridiagonal system in closed
    form, and a strip as SuperLU has it."""
    n, t = 700, 1.0
    A = sp.csr_array(
        sp.diags_array([np.full(n - 1, -t), np.full(n, 1 + 2 * t), np.full(n - 1, -t)], offsets=[-1, 0, 1])
    )
    grown = np.sinh(np.arange(n, 0, -1) * np.arccosh(1 + 1 / (2 * t)))  # u_i ∝ sinh((n + 1 - i)θ), 2t cosh θ = 1 + 2t
    impulse = np.eye(n)[0]
    u = BlockCholesky(A)(impulse)
    assert u[-1] < 1e-250
    np.testing.assert_allclose(u, grown / ((1 + 2 * t) * grown[0] - t * grown[1]), rtol=1e-12)
    A = heat_matrix("long")
    impulse = np.eye(A.shape[0])[0]
    expected = SuperLU(A)(impulse)
    there = expected > 1e-300
    assert 500 < np.count_nonzero(there) < len(there)
    np.testing.assert_allclose(BlockCholesky(A)(impulse)[there], expected[there], rtol=1e-10)


def test_hermitian_systems() -> None:
    """Connection Laplacians: complex right-hand sides, one and several."""
    mesh = icosphere(4)
    A = sp.csr_array(lumped_mass(mesh) + mesh.mean_edge_length**2 * complex_connection_stiffness(mesh, "normals"))
    rng = np.random.default_rng(0)
    b = rng.normal(size=(mesh.n_vertices, 5)) + 1j * rng.normal(size=(mesh.n_vertices, 5))
    x = BlockCholesky(A)(b)
    np.testing.assert_allclose(A @ x, b, rtol=0, atol=1e-12 * np.abs(b).max())
    np.testing.assert_allclose(BlockCholesky(A)(b[:, 2]), x[:, 2], rtol=0, atol=1e-13 * np.abs(x).max())


def test_work_is_little() -> None:
    """Numbers in the factors grow like n log n: for four times the vertices by less than six times."""
    held = [
        sum(block.size for block in (*solver._inverses, *solver._carriers)) / mesh.n_vertices
        for mesh in (icosphere(3), icosphere(4), icosphere(5))
        for solver in [BlockCholesky(sp.csr_array(lumped_mass(mesh) + stiffness(mesh)))]
    ]
    assert held[-1] < 120
    assert held[1] < 1.5 * held[0]
    assert held[2] < 1.5 * held[1]


def test_not_positive_definite() -> None:
    """Cholesky refuses; the front door turns to SuperLU, and says so."""
    A = sp.csr_array(sp.diags_array(np.resize([1.0, -1.0], 300)))
    with pytest.raises(ConvergenceError, match="not positive definite"):
        BlockCholesky(A)
    solver = DirectSolver(A, work=MANY)
    assert solver.factorization == "superlu"
    np.testing.assert_array_equal(solver(np.ones(300)), np.resize([1.0, -1.0], 300))
    with pytest.raises(ConvergenceError, match="no finite solution"):
        DirectSolver(stiffness(grid(9, 9)) * 0.0, work=MANY)


def test_cholmod() -> None:
    """Where it is installed: solutions real and complex, alone and at once; a refusal, where SuperLU steps in."""
    pytest.importorskip("kvxopt")
    from geomhw.solvers.cholmod import Cholmod

    mesh = icosphere(3)
    A = heat_matrix("sphere")
    Z = sp.csr_array(A + mesh.mean_edge_length**2 * complex_connection_stiffness(mesh, "normals"))
    rng = np.random.default_rng(0)
    b = rng.normal(size=(mesh.n_vertices, 3))
    for matrix, rhs in ((A, b), (A, b[:, 0]), (Z, b + 1j * b[::-1]), (A, b + 1j * b[::-1])):
        x = Cholmod(matrix)(rhs)
        np.testing.assert_allclose(matrix @ x, rhs, rtol=0, atol=1e-12 * np.abs(rhs).max())
        np.testing.assert_array_equal(Cholmod(matrix)(rhs), x)
    for n in (2, 300):
        with pytest.raises(ConvergenceError, match="not positive definite"):
            Cholmod(sp.csr_array(sp.diags_array(np.resize([1.0, -1.0], n))))
    n = 6000
    chain = sp.csr_array(
        sp.diags_array([np.full(n - 1, -1.0), np.full(n, 2.1), np.full(n - 1, -1.0)], offsets=[-1, 0, 1])
    )
    free = np.arange(n) % 1000 > 0
    solver = DirectSolver(chain, free, Work(20, 1))
    assert solver.factorization == "cholmod"
    expected = DirectSolver(chain, free, MANY)(np.ones((n, 2)))
    np.testing.assert_allclose(solver(np.ones((n, 2))), expected, rtol=1e-12)


def test_the_extra_is_none_of_the_requirements(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without kvxopt the choice is between SuperLU and blocks; with it, it takes what it is best at."""
    sizes = [(n, work) for n in (100, 3000, 30_000, 300_000) for work in (Work(1, 1), Work(100, 1), MANY)]
    monkeypatch.setattr("geomhw.solvers.cost_model.installed", lambda: False)
    assert {cheapest(*size) for size in sizes} == {"superlu", "blocks"}
    monkeypatch.setattr("geomhw.solvers.cost_model.installed", lambda: True)
    assert [cheapest(30_000, work) for work in (Work(1, 1), Work(100, 1), MANY)] == ["cholmod", "cholmod", "blocks"]


def test_the_front_door_goes_by_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """One solution of a small system is SuperLU's, thousands are not; both are the same."""
    monkeypatch.setattr("geomhw.solvers.cost_model.installed", lambda: False)
    mesh = icosphere(4)
    A = lumped_mass(mesh) + 0.01 * stiffness(mesh)
    free = np.ones(mesh.n_vertices, dtype=bool)
    free[::7] = False
    few, many = DirectSolver(A, free), DirectSolver(A, free, MANY)
    assert [few.factorization, many.factorization] == ["superlu", "blocks"]
    b = np.random.default_rng(1).normal(size=(mesh.n_vertices, 3))
    np.testing.assert_allclose(many(b), few(b), rtol=0, atol=1e-12 * np.abs(few(b)).max())
    assert not many(b)[~free].any()
