"""Solvers that do not converge raise, or fall back to a factorization."""

import numpy as np
import pytest
import scipy.sparse as sp

from geomhw.errors import ConvergenceError, FieldError
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.heat_step import HeatStep
from geomhw.mesh.primitives import grid
from geomhw.solvers.auto import LaplaceSolver
from geomhw.solvers.heat_sweeps import solve_by_sweeps
from geomhw.solvers.multigrid import MultigridSolver


def test_what_does_not_converge_says_so() -> None:
    """Sweeps over a long time and conjugate gradients on an indefinite matrix raise."""
    mesh = grid(40, 40)
    flow = HeatStep(mesh, "1000*h2")
    impulse = np.zeros(mesh.n_vertices)
    impulse[0] = 1
    arrival = edge_path_distance(mesh, np.array([0])) / np.sqrt(flow.time.t)
    with pytest.raises(ConvergenceError, match="solver='direct'"):
        solve_by_sweeps(flow.matrix, impulse, arrival)
    indefinite = sp.csr_array(sp.diags_array(np.resize([1.0, -1.0], 50)))
    every = np.ones(50, dtype=bool)
    with pytest.raises(ConvergenceError, match="solver='direct'"):
        MultigridSolver(indefinite)(np.ones(50))
    with pytest.raises(ConvergenceError, match="solver='direct'"):
        LaplaceSolver(indefinite, every, "multigrid")(np.ones(50))


def test_auto_falls_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where multigrid does not converge, `auto` factors the matrix; small systems are factored at once."""
    monkeypatch.setattr("geomhw.solvers.auto.LARGE", 40)
    indefinite = sp.csr_array(sp.diags_array(np.resize([1.0, -1.0], 50)))
    every = np.ones(50, dtype=bool)
    np.testing.assert_allclose(LaplaceSolver(indefinite, every)(np.ones(50)), np.resize([1.0, -1.0], 50))
    monkeypatch.setattr("geomhw.solvers.auto.LARGE", 60)
    np.testing.assert_allclose(LaplaceSolver(indefinite, every)(np.ones(50)), np.resize([1.0, -1.0], 50))
    with pytest.raises(FieldError, match="auto, multigrid, direct"):
        LaplaceSolver(indefinite, every, "best")  # type: ignore[arg-type]


def test_what_is_no_solution_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A result of the sweeps that does not satisfy the equations raises."""
    mesh = grid(30, 30)
    flow = HeatStep(mesh, "h2", solver="direct")
    impulse = np.bincount([0], minlength=mesh.n_vertices).astype(float)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.TOLERANCE", 1e-2)
    monkeypatch.setattr("geomhw.solvers.heat_sweeps.FINAL_TOLERANCE", 0.0)
    arrival = edge_path_distance(mesh, np.array([0])) / np.sqrt(flow.time.t)
    with pytest.raises(ConvergenceError, match="solver='direct'"):
        solve_by_sweeps(flow.matrix, impulse, arrival)
