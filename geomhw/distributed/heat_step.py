"""One backward Euler step of the heat equation, (M + tS) u = u0, on a distributed mesh: by sweeps or in rounds."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.poisson import solve_laplace
from geomhw.errors import ConvergenceError
from geomhw.solvers.log_scaled import LogValues

#: Diffusion times in h² up to which sweeps converge sooner than conjugate gradients in rounds.
SHORT = 8.0
#: A round finds u where it is at least this share of the largest unknown value, and solves to this tolerance.
SHARE, TOLERANCE = np.exp(-12.0), 1e-15
#: Rounds at most.
MAX_ROUNDS = 500


class Solve(Protocol):
    """Solves A x = b with x known at held vertices, as `solve_laplace`."""

    def __call__(
        self,
        mesh: LocalMesh,
        matrix: sp.csr_array,
        rhs: NDArray[Any],
        held: NDArray[np.bool_],
        values: NDArray[Any],
        tolerance: float,
    ) -> tuple[NDArray[Any], dict[str, Any]]: ...


def heat_step(
    mesh: LocalMesh,
    assemble: Callable[[], sp.csr_array],
    impulse: NDArray[Any],
    arrival: Floats,
    multiple: float,
    solve: Solve = solve_laplace,
) -> tuple[LogValues, dict[str, Any]]:
    """Solve (M + tS) u = u0, or (M + tK) u = u0 for complex numbers, accurate relative to u at each vertex.

    Parameters
    ----------
    assemble : returns M + tS, (k, k + g), the rows of this rank; it is not kept.
    impulse : u0, (k,), integrated.
    arrival : (k,), path lengths from the sources over √t; inf where no heat arrives.
    multiple : t/h².
    solve : solves the system in rounds.

    Returns
    -------
    u, (k,), and the method with its number of sweeps per vertex, or of rounds and iterations, for a report.

    Raises
    ------
    ConvergenceError
        If heat does not reach the far side.
    """
    if multiple <= SHORT:
        from geomhw.distributed.heat_sweeps import HeatSweeps
        from geomhw.solvers.heat_sweeps import MAX_OMEGA

        sweeps = HeatSweeps(mesh, assemble, arrival)
        if sweeps.omega < MAX_OMEGA:
            with suppress(ConvergenceError):
                u = sweeps(impulse)
                return u, {"method": "sweeps", "per_vertex": sweeps.per_vertex, "exchanges": sweeps.sweeps}
        del sweeps
    return _in_rounds(mesh, assemble(), impulse, np.isfinite(arrival), solve)


def _in_rounds(
    mesh: LocalMesh, matrix: sp.csr_array, impulse: NDArray[Any], reached: NDArray[np.bool_], solve: Solve
) -> tuple[LogValues, dict[str, Any]]:
    """u by conjugate gradients: each round finds the next twelve decay lengths from those that are known."""
    values, known = LogValues.of(np.zeros_like(impulse)), ~reached
    iterations: list[int] = []
    for _ in range(MAX_ROUNDS):
        left = mesh.ranks.sum(int((~known).sum()))
        if not left:
            return values, {"method": "rounds", "rounds": len(iterations), "iterations": iterations}
        scale = _scale(mesh, matrix, known, values.log) if iterations else 0.0
        # Larger values have neighbors that are all known.
        plain = np.where(known & (values.log <= scale), values.sign * np.exp(np.minimum(values.log - scale, 0.0)), 0.0)
        rhs = impulse * np.exp(-scale) if scale > -600.0 else np.zeros_like(impulse)
        u, solved = solve(mesh, matrix, rhs, known, plain, TOLERANCE)
        iterations.append(solved["iterations"])
        size = np.where(known, 0.0, np.abs(u))
        new = ~known & (size >= SHARE * mesh.ranks.max(float(size.max(initial=0.0))))
        found = LogValues.of(u[new], -scale)
        values.log[new], values.sign[new] = found.log, found.sign
        known |= new
    raise ConvergenceError("heat does not reach the far side of the mesh; take a larger time step")


def _scale(mesh: LocalMesh, matrix: sp.csr_array, known: NDArray[np.bool_], log: Floats) -> float:
    """The largest log|u| at a known vertex that has an unknown neighbor."""
    unknown = mesh.with_ghosts(~known).astype(float)
    pattern = sp.csr_array((np.ones_like(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape)
    border = known & (pattern @ unknown > 0)
    return float(mesh.ranks.max(float(log[border].max(initial=-np.inf))))
