"""Geodesic distance by the heat method [GIH, algorithm 1] on a mesh that is distributed over MPI ranks."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.distributed.assembly import LocalOperators, assemble, own_sum
from geomhw.distributed.edge_paths import edge_path_distance
from geomhw.distributed.heat_sweeps import HeatSweeps
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.poisson import solve_laplace
from geomhw.errors import ArgumentError
from geomhw.geodesic.unit_field import unit_field
from geomhw.operators.divergence import divergence_of
from geomhw.operators.laplacian import backward_euler
from geomhw.solvers.log_scaled import LogValues


@dataclass(frozen=True)
class LocalResult:
    """Arrays at the vertices of a rank, each (k,) or (k, 3), and a report, the same on all ranks."""

    mesh: LocalMesh
    fields: dict[str, Floats]
    report: dict[str, Any] = field(default_factory=dict)


def distributed_distance(mesh: LocalMesh, sources: Ints, time: str | float = "h2", bound: bool = True) -> LocalResult:
    """Return the distance from the nearest of some source vertices, at the vertices of each rank.

    Parameters
    ----------
    mesh : the part of each rank.
    sources : (s,) vertices as numbers of the file, the same on all ranks.
    time : diffusion time t: ``h2``, ``sqrt-h``, a multiple such as ``0.5*h2``, or a number; ``auto`` is ``h2``.
    bound : as in `HeatDistance`.

    Returns
    -------
    LocalResult with ``heat``, ``divergence`` and ``distance``, as `HeatDistance.from_sources` has them.
    """
    operators = assemble(mesh)
    numbers = mesh.find(sources)
    at = mesh.local(numbers)
    paths = edge_path_distance(mesh, operators, at)
    t = operators.mean_edge_length**2
    A = backward_euler(operators.areas, operators.stiffness, t)
    u0 = np.zeros(mesh.n_own)
    u0[at[at < mesh.n_own]] = 1.0
    sweeps = HeatSweeps(mesh, A, paths / np.sqrt(t))  # I. (M + tS) u = u0
    u = sweeps(u0)
    div = _divergence(mesh, u, at)  # II. Div X, X = -∇u/|∇u|
    reached = np.isfinite(paths)
    held = ~reached
    held[at[at < mesh.n_own]] = True
    phi, solved = solve_laplace(mesh, operators.stiffness, -div, held, np.zeros(mesh.n_own), None)  # III. Sφ = -Div X
    phi[~reached] = np.inf
    return LocalResult(
        mesh,
        {"heat": u.plain, "divergence": div, "distance": phi, "paths": paths},
        {"poisson": solved, "heat": {"sweeps": sweeps.sweeps, "per_vertex": sweeps.per_vertex}},
    )


def _divergence(mesh: LocalMesh, heat: LogValues, sources: Ints) -> Floats:
    """Div X, (k,), integrated."""
    log, sign = mesh.with_ghosts(heat.log), mesh.with_ghosts(heat.sign)
    is_source = np.zeros(len(mesh.vertices), dtype=bool)
    is_source[sources] = True
    div = np.zeros(mesh.n_own)
    for used, block in mesh.blocks():
        X = unit_field(block, LogValues(log[used], sign[used]), np.flatnonzero(is_source[used]))[1]
        here = used < mesh.n_own
        div[used[here]] += divergence_of(block, X)[here]
    return div
