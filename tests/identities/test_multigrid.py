"""Iterative solvers give the solutions of a factorization."""

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

from geomhw.errors import ConvergenceError
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_method import HeatDistance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.io import read_mesh
from geomhw.mesh.primitives import grid, icosphere, strip, torus
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.laplacian import stiffness
from geomhw.options import Connection
from geomhw.solvers.auto import FEW, LaplaceSolver
from geomhw.solvers.direct import DirectSolver, permuted
from geomhw.solvers.heat_sweeps import (
    MAX_OMEGA,
    _argsort,
    over_relaxation,
    solve_by_sweeps,
    solve_scaled_by_sweeps,
)
from geomhw.solvers.log_scaled import solve_scaled
from geomhw.solvers.multigrid import MultigridSolver, _sweep_back, _sweep_from_zero
from geomhw.solvers.nullspace import free_unknowns, without_mean
from geomhw.transport.vector_heat import VectorHeat
from support.meshes import ZOO, zoo_mesh
from support.reference import needs_reference, reference


@pytest.mark.parametrize("name", [*sorted(ZOO), "large", "long"])
def test_poisson(name: str) -> None:
    """Multigrid solves S x = b as the factorization does, with one vertex per component held."""
    mesh = {"large": lambda: icosphere(5), "long": lambda: strip(2000)}.get(name, lambda: zoo_mesh(name))()
    S, free = stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices)
    b = np.random.default_rng(1).normal(size=mesh.n_vertices)
    b[mesh.unreferenced_vertices] = 0
    b = without_mean(b, mesh.components)
    x, expected = MultigridSolver(S, free)(b), DirectSolver(S, free)(b)
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    np.testing.assert_array_equal(MultigridSolver(stiffness(mesh), free)(b), x)


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 1e6])
def test_poisson_from_a_guess(size: float) -> None:
    """The solution does not depend on the initial guess."""
    mesh = icosphere(4)
    S, free = stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices)
    rng = np.random.default_rng(1)
    b = without_mean(rng.normal(size=mesh.n_vertices), mesh.components)
    expected = DirectSolver(S, free)(b)
    guess = np.where(free, expected + size * rng.normal(size=mesh.n_vertices), 0.0)
    np.testing.assert_allclose(MultigridSolver(S, free)(b, guess), expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_a_guess_off_by_a_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    """From a multiple of the solution one iteration suffices."""
    mesh = icosphere(4)
    S, free = stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices)
    b = without_mean(np.random.default_rng(3).normal(size=mesh.n_vertices), mesh.components)
    expected = DirectSolver(S, free)(b)
    monkeypatch.setattr("geomhw.solvers.multigrid.MAX_ITERATIONS", 1)
    for factor in (1e-6, -1.0, 1e6):
        found = MultigridSolver(S, free)(b, factor * expected)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_set_up_while_something_else_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """A set-up in the background gives the same bits; its errors are raised, or cured by a factorization, on use."""
    mesh = icosphere(4)
    S, free = stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices)
    b = without_mean(np.random.default_rng(4).normal(size=mesh.n_vertices), mesh.components)
    expected = LaplaceSolver(S, free, "multigrid")(b)
    ahead = LaplaceSolver(S, free, "multigrid")
    ahead.begin()
    np.testing.assert_array_equal(ahead(b), expected)

    def failing(*_: object) -> MultigridSolver:
        raise ConvergenceError("no")

    monkeypatch.setattr("geomhw.solvers.multigrid.MultigridSolver", failing)
    monkeypatch.setattr("geomhw.solvers.auto.LARGE", 100)
    asked, left_open = LaplaceSolver(S, free, "multigrid"), LaplaceSolver(S, free)
    monkeypatch.setattr(left_open, "_iterate", True)
    asked.begin()
    left_open.begin()
    with pytest.raises(ConvergenceError, match="no"):
        asked(b)
    np.testing.assert_allclose(left_open(b), expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_unknowns_without_neighbors() -> None:
    """Separate right triangles, whose cotan weights vanish, give the distances of the factorization."""
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    vertices = corner + 3 * np.arange(300)[:, None, None] * [1.0, 0, 0]
    mesh = TriangleMesh(vertices.reshape(-1, 3), np.arange(900).reshape(-1, 3))
    sources = list(range(0, 900, 3))
    found, expected = (
        HeatDistance(mesh, "h2", solver=solver).from_vertices(sources)["distance"]  # type: ignore[arg-type]
        for solver in ("multigrid", "direct")
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_poisson_with_held_vertices() -> None:
    """Held vertices stay zero."""
    mesh = grid(30, 20)
    free = np.ones(mesh.n_vertices, dtype=bool)
    free[mesh.boundary_vertices] = False
    b = np.random.default_rng(2).normal(size=mesh.n_vertices)
    x = MultigridSolver(stiffness(mesh), free)(b)
    assert not x[~free].any()
    np.testing.assert_allclose(x, DirectSolver(stiffness(mesh), free)(b), atol=1e-8 * np.abs(x).max())
    assert not MultigridSolver(stiffness(mesh), free)(np.zeros_like(b)).any()


@pytest.mark.parametrize("time", ["0.1*h2", "h2", "4*h2"])
@pytest.mark.parametrize(
    ("make", "sources"),
    [(lambda: icosphere(4), [7]), (lambda: grid(50, 40), [3, 1500]), (lambda: strip(1500), [0])],
    ids=["sphere", "grid", "strip"],
)
def test_heat_by_sweeps(make, sources: list[int], time: str) -> None:  # type: ignore[no-untyped-def]
    """Sweeps give the logarithm of heat over thousands of orders of magnitude."""
    mesh = make()
    flow = HeatStep(mesh, time)
    impulse = np.zeros(mesh.n_vertices)
    impulse[sources] = 1
    arrival = edge_path_distance(mesh, np.array(sources)) / np.sqrt(flow.time.t)
    found, expected = (
        solve_by_sweeps(flow.matrix, impulse, arrival),
        flow.from_impulse(impulse),
    )
    np.testing.assert_array_equal(found.sign, 1)
    np.testing.assert_allclose(found.log, expected.log, rtol=0, atol=1e-7)


@pytest.mark.parametrize("window", [25.0, 80.0, 1e6])
def test_width_of_the_window_does_not_matter(window: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The solution does not depend on the width of the window in which sweeps run."""
    mesh = strip(400)
    flow = HeatStep(mesh, "h2")
    impulse = np.bincount([0], minlength=mesh.n_vertices).astype(float)
    arrival = edge_path_distance(mesh, np.array([0])) / np.sqrt(flow.time.t)
    expected = solve_by_sweeps(flow.matrix, impulse, arrival)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.WINDOW", window)
    found = solve_by_sweeps(flow.matrix, impulse, arrival)
    assert expected.log.min() < -300
    np.testing.assert_allclose(found.log, expected.log, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(found.sign, expected.sign)


@pytest.mark.parametrize("time", ["1e-4*h2", "1e-2*h2", "100*h2"])
def test_sweeps_over_short_and_long_times(time: str) -> None:
    """Sweeps are right where an edge is a hundred decay lengths, and where a decay length is ten edges."""
    mesh = torus(60, 24)
    flow = HeatStep(mesh, time, solver="direct")
    impulse = np.bincount([7], minlength=mesh.n_vertices).astype(float)
    arrival = edge_path_distance(mesh, np.array([7])) / np.sqrt(flow.time.t)
    found, expected = solve_by_sweeps(flow.matrix, impulse, arrival), flow.from_impulse(impulse)
    np.testing.assert_array_equal(found.sign, expected.sign)
    np.testing.assert_allclose(found.log, expected.log, rtol=0, atol=1e-7)


def test_over_relaxation() -> None:
    """ω is 2/(1 + sqrt(1 - μ²)): 1 for a diagonal matrix, bounded, and from the third quartile of μ."""
    assert over_relaxation(np.zeros(8)) == pytest.approx(1.0, rel=1e-14)
    assert over_relaxation(np.full(8, 0.8)) == pytest.approx(1.25, rel=1e-14)
    assert over_relaxation(np.full(8, 1 - 1e-9)) == over_relaxation(np.full(8, 3.0)) == MAX_OMEGA
    assert over_relaxation(1 - np.array([0.2, 0.2, 0.4, 0.6, 0.7, 0.7, 0.8, 0.9])) < 1.25


@pytest.mark.parametrize("name", sorted(ZOO))
def test_distances_agree(name: str) -> None:
    """Distances do not depend on the solver, for one and two sources and two boundary conditions."""
    mesh = zoo_mesh(name)
    last = int(mesh.faces.max())
    for sources, boundary in (([0], "neumann"), ([0, last], "neumann"), ([last], "average")):
        answers = [
            np.asarray(
                HeatDistance(mesh, "h2", boundary=boundary, solver=solver).from_vertices(sources)["distance"]  # type: ignore[arg-type]
            )
            for solver in ("direct", "multigrid")
        ]
        size = answers[0][np.isfinite(answers[0])].max()
        np.testing.assert_allclose(answers[1], answers[0], rtol=0, atol=1e-7 * size)


@needs_reference
@pytest.mark.parametrize("file", ["kitten.obj", "fandisk.obj", "armadillo.obj"])
@pytest.mark.parametrize("robust", [False, True])
def test_distances_agree_on_real_meshes(file: str, robust: bool) -> None:
    """Distances do not depend on the solver on real meshes, to 1e-7 of the largest."""
    mesh = read_mesh(reference(f"meshes/closed/{file}"))
    solvers = [HeatDistance(mesh, "h2", robust=robust, refine=False, solver=s) for s in ("direct", "multigrid")]  # type: ignore[arg-type]
    expected, found = (np.asarray(solver.from_vertices([0])["distance"]) for solver in solvers)
    assert [solver.from_vertices([0]).report["solver"] for solver in solvers] == ["direct", "multigrid"]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * expected.max())


@pytest.mark.parametrize("connection", ["normals", "intrinsic"])
@pytest.mark.parametrize("time", ["h2", "0.1*h2"])
def test_vectors_by_sweeps_are_those_by_factoring(connection: Connection, time: str) -> None:
    """Sweeps give the vectors of the factorization, to 1e-7 where opposite paths do not cancel."""
    mesh = torus(60, 24)
    vectors = [[1.0, 2.0, 0.5], [0.0, -1.0, 3.0]]
    swept, factored = (
        VectorHeat(mesh, time, connection, solver=solver).from_vertices([3, 700], vectors)
        for solver in ("multigrid", "direct")
    )
    assert swept.report["solver"] == "multigrid"
    assert factored.report["solver"] == "direct"
    size = np.linalg.norm(factored["diffused"], axis=1)
    np.testing.assert_allclose(swept["diffused"], factored["diffused"], rtol=0, atol=1e-7 * size.max())
    heat = HeatStep(mesh, time).from_impulse(np.bincount([3, 700], minlength=mesh.n_vertices)).plain
    clear = size > 1e-3 * heat
    assert clear.mean() > 0.95
    gap = np.linalg.norm(swept["transported"] - factored["transported"], axis=1)
    assert (gap[clear] <= 1e-7 * np.linalg.norm(factored["transported"], axis=1)[clear]).all()


def test_scaled_sweeps_are_the_scaled_solution() -> None:
    """On a strip where heat underflows, sweeps solve the system scaled by its decay."""
    mesh = grid(1500, 2, 1500.0, 2.0)
    flow = HeatStep(mesh, "h2")
    impulse = np.zeros(mesh.n_vertices)
    impulse[0] = 1
    decay = -flow.from_impulse(impulse).log
    assert decay.max() > 800
    found = solve_scaled_by_sweeps(flow.matrix, impulse, decay)
    np.testing.assert_allclose(found, solve_scaled(flow.matrix, impulse, decay), rtol=1e-6)


def test_heat_that_decays_at_several_rates() -> None:
    """On two strips with different decay, sweeps are right to 1e-6 in both, hundreds of orders apart."""
    fine, coarse = strip(3000), strip(750, cell=4.0)
    vertices = np.concatenate([fine.vertices, coarse.vertices + np.array([0.0, 9.0, 0.0])])
    mesh = TriangleMesh(vertices, np.concatenate([fine.faces, coarse.faces + fine.n_vertices]))
    sources = np.array([0, fine.n_vertices])
    impulse = np.bincount(sources, minlength=mesh.n_vertices).astype(float)
    alone = [HeatStep(part, 1.0).from_impulse(np.eye(1, part.n_vertices)[0]).log for part in (fine, coarse)]
    assert alone[1][-1] - alone[0][-1] > 700
    flow = HeatStep(mesh, 1.0)
    found = solve_by_sweeps(flow.matrix, impulse, edge_path_distance(mesh, sources))
    np.testing.assert_allclose(found.log, np.concatenate(alone), rtol=0, atol=1e-6)
    np.testing.assert_array_equal(flow.from_impulse(impulse).log, found.log)  # where one decay is guessed for all


def test_heat_from_further_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a narrow window leaves residuals, the last sweeps go on until the equations hold."""
    mesh = icosphere(4)
    flow = HeatStep(mesh, "0.2*h2", solver="direct")
    impulse = np.bincount([7], minlength=mesh.n_vertices).astype(float)
    arrival = edge_path_distance(mesh, np.array([7])) / np.sqrt(flow.time.t)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.WINDOW", 5.0)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.WINDOW_EDGES", 0.0)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.MARGIN", 0.0)
    expected = flow.from_impulse(impulse).log
    found = solve_by_sweeps(flow.matrix, impulse, arrival)
    np.testing.assert_allclose(found.log, expected, rtol=0, atol=1e-7)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.FINAL_TOLERANCE", 1.0)
    assert np.abs(solve_by_sweeps(flow.matrix, impulse, arrival).log - expected).max() > 1e-6


def test_an_equation_holds_beside_its_own_terms() -> None:
    """Where two decaying solutions cancel, the residual is measured against the terms of the equation."""
    n = 41
    A = sp.csr_array(sp.diags_array([-1.0, 3.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)))
    b = np.eye(n)[0] - (1 + 1e-9) * np.eye(n)[-1]
    found, expected = solve_by_sweeps(A, b, np.minimum(np.arange(n), np.arange(n)[::-1]).astype(float)), DirectSolver(A)
    x, size = expected(b), expected(np.abs(b))
    assert abs(x[n // 2]) < 1e-8 * size[n // 2]
    np.testing.assert_allclose(found.plain / size, x / size, rtol=0, atol=1e-9)


def test_rows_in_another_order() -> None:
    """A permuted matrix keeps its entries."""
    dense = np.array([[1.0, 2, 0, 3], [4, 5, 0, 0], [0, 0, 0, 6], [7, 0, 8, 9]])
    A = permuted(sp.csr_array(dense), np.array([3, 1, 0, 2]))
    np.testing.assert_array_equal(A.toarray(), dense[[3, 1, 0, 2]][:, [3, 1, 0, 2]])


def test_sweeps_solve_triangular_systems() -> None:
    """Gauss-Seidel sweeps over ascending rows from zero, with their residual, and over descending rows."""
    rng, b = np.random.default_rng(0), np.arange(1.0, 31)
    A = sp.random_array((30, 30), density=0.2, random_state=rng)
    A = sp.csr_array(A + A.T + sp.diags_array(np.full(30, 5.0)))
    A.sort_indices()
    N = sp.csr_array(A - sp.diags_array(A.diagonal()))
    x, residual = np.full(30, np.nan), np.full(30, np.nan)
    _sweep_from_zero(N.indptr, N.indices, N.data, A.diagonal(), x, b, residual)
    np.testing.assert_allclose(x, np.linalg.solve(np.tril(A.toarray()), b), rtol=1e-12)
    np.testing.assert_allclose(residual, b - A @ x, rtol=0, atol=1e-12)
    expected = np.linalg.solve(np.triu(A.toarray()), b - np.tril(A.toarray(), -1) @ x)
    _sweep_back(N.indptr, N.indices, N.data, A.diagonal(), x, b)
    np.testing.assert_allclose(x, expected, rtol=1e-12)


@given(st.lists(st.floats(0, width=32)))
def test_order_of_arrival(values: list[float]) -> None:
    """The order of arrival equals a stable argsort of single-precision numbers."""
    array = np.array(values + values[::-1], dtype=np.float32)
    np.testing.assert_array_equal(_argsort(array), np.argsort(array, kind="stable"))
    near = np.random.default_rng(0).permutation(np.arange(2**30 - 2**17, 2**30 + 2**17, 97, dtype=np.uint32))
    np.testing.assert_array_equal(_argsort(near.view(np.float32)), np.argsort(near, kind="stable"))


def test_many_questions_end_iteration(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a dozen solutions ``auto`` factors; the distances stay the same, and other solvers keep their method."""
    monkeypatch.setattr("geomhw.solvers.auto.LARGE", 100)
    mesh = icosphere(3)
    auto, iterated = HeatDistance(mesh, "h2"), HeatDistance(mesh, "h2", solver="multigrid")
    for vertex in range(FEW + 2):
        assert auto.settings()["solver"] == ("direct" if vertex > FEW else "multigrid")
        distance, other = (solver.from_vertices([vertex])["distance"] for solver in (auto, iterated))
        np.testing.assert_allclose(distance, other, atol=1e-8)
    assert iterated.settings()["solver"] == "multigrid"
