"""Geodesic distance by the heat method [GIH, algorithm 1] on a mesh that is distributed over MPI ranks."""

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, Ints
from geomhw.distributed.assembly import LocalOperators, assemble
from geomhw.distributed.edge_paths import edge_path_distance
from geomhw.distributed.heat_step import heat_step
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.poisson import DirichletProblem
from geomhw.distributed.ranks import release_memory
from geomhw.distributed.source_conditions import local_sources, source_heat
from geomhw.distributed.source_points import vertex_sources
from geomhw.geodesic.auto_time import without_comparison
from geomhw.geodesic.diffusion_time import TimeStep, given_time
from geomhw.geodesic.heat_method import bounded
from geomhw.geodesic.source_conditions import chord_to_points
from geomhw.geodesic.unit_field import unit_field
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.operators.divergence import divergence_of
from geomhw.operators.laplacian import backward_euler
from geomhw.solvers.log_scaled import LogValues
from geomhw.stages import Stages


@dataclass(frozen=True)
class LocalResult:
    """Arrays at the vertices of a rank, each (k,) or (k, 3), and a report, the same on all ranks."""

    mesh: LocalMesh
    fields: dict[str, Floats]
    report: dict[str, Any] = field(default_factory=dict)


def distributed_distance(
    mesh: LocalMesh,
    sources: SurfacePoints | Ints,
    time: str | float = "auto",
    bound: bool = True,
    stages: Stages | None = None,
) -> LocalResult:
    """Return the distance from the nearest of some sources, at the vertices of each rank.

    Parameters
    ----------
    mesh : the part of each rank.
    sources : vertices and points in faces with the numbers of the file, or (s,) vertices, the same on all ranks.
    time : diffusion time t: ``h2``, ``sqrt-h``, a multiple such as ``0.5*h2``, or a number; ``auto`` is
        ``h2``, also where one process compares it with √h on the mesh; then the report says so.
    bound : as in `HeatDistance`.
    stages : measures the time of each stage.

    Returns
    -------
    LocalResult with ``heat``, ``divergence`` and ``distance``, as `HeatDistance.from_sources` has them.

    Raises
    ------
    ArgumentError
        If a source is no vertex with faces, or for an unknown time.
    MeshError
        If a face has zero area.
    ConvergenceError
        If heat does not reach the far side, or the Poisson equation is not solved.
    """
    stage = stages or Stages()
    with stage("assembly"):
        operators = assemble(mesh)
        h = operators.mean_edge_length
        step = time_step(time, operators)
        points = sources if isinstance(sources, SurfacePoints) else vertex_sources(mesh, sources)
        conditions = local_sources(mesh, operators, points)
    release_memory()
    with stage("paths along edges"):
        paths = edge_path_distance(mesh, operators, conditions.near, conditions.known)
    release_memory()
    with stage("heat"):  # I. (M + tS) u = u0
        assemble_heat = partial(backward_euler, operators.areas, operators.stiffness, step.t)
        u0 = source_heat(mesh, operators, assemble_heat, conditions)
        S, on_surface = operators.stiffness, operators.areas > 0
        del operators  # S is half of it
        u, heat_report = heat_step(mesh, assemble_heat, u0, paths / np.sqrt(step.t), step.t / h**2)
        del assemble_heat
    release_memory()
    with stage("directions and divergence"):  # II. X = -∇u/|∇u|
        div = _divergence(mesh, u, conditions.vertices)
    release_memory()
    with stage("distance"):  # III. Sφ = -Div X
        own = conditions.near < mesh.n_own
        near, known, held = conditions.near[own], conditions.known[own], ~np.isfinite(paths)
        held[near] = True
        left = _less_known(mesh, S, -div, near, known)
        problem = DirichletProblem(mesh, S, held)
        del S
        release_memory()
        phi, poisson_report = problem.solve(left)
        del left
        phi[near], phi[~np.isfinite(paths)] = known, np.inf
        positive = np.ones(len(phi), dtype=bool)
        positive[near] = known > 0
        phi, findings = bounded(
            phi, paths, positive, lambda low: chord_to_points(mesh.vertices[low], conditions.positions), bound
        )
    report = {
        "sources": points.report(),
        **_extremes(mesh, phi),
        "unreachable_vertices": int(mesh.ranks.sum(int((np.isinf(phi) & on_surface).sum()))),
        "time": step.report(h),
        "bounded": bound,
        "mean_edge_length": h,
        "heat": heat_report,
        "poisson": poisson_report,
        **_combined(mesh, findings),
    }
    return LocalResult(mesh, {"heat": u.plain, "divergence": div, "distance": phi}, report)


def _less_known(mesh: LocalMesh, S: sp.csr_array, rhs: Floats, near: Ints, known: Floats) -> Floats:
    """The right-hand side less S times the known distances."""
    if not mesh.ranks.sum(int(known.any())):
        return rhs
    values = np.zeros(mesh.n_own)
    values[near] = known
    return rhs - S @ mesh.with_ghosts(values)


def extreme_vertex(mesh: LocalMesh, axis: int, sign: int) -> int:
    """Return the vertex of the file with faces and the largest (sign 1) or smallest (-1) coordinate; as on one mesh."""
    height = np.full(mesh.n_own, -np.inf)
    used = np.unique(mesh.faces[mesh.faces < mesh.n_own])
    height[used] = sign * mesh.vertices[used, axis]
    return _first_largest(mesh, height)[0]


def _first_largest(mesh: LocalMesh, values: Floats) -> tuple[int, float]:
    """The vertex of the file with the largest value, the lowest one on a tie, and the value."""
    largest = mesh.ranks.max(float(values.max(initial=-np.inf)))
    vertices = mesh.part.in_file[values == largest]
    return int(mesh.ranks.min(int(vertices.min(initial=mesh.n_vertices)))), largest


def time_step(asked: str | float, operators: LocalOperators) -> TimeStep:
    """Return the diffusion time; ``auto`` is h² also where one process compares it with √h."""
    h = operators.mean_edge_length
    if str(asked).strip() != "auto":
        return given_time(asked, h)
    clear = without_comparison(h, *operators.weights)
    return clear or TimeStep(h**2, "auto", "h²; only one process compares it with √h")


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


def _extremes(mesh: LocalMesh, distance: Floats) -> dict[str, Any]:
    """The farthest vertex, and the mean distance."""
    finite = np.isfinite(distance)
    vertex, largest = _first_largest(mesh, np.where(finite, distance, -np.inf))
    total, count = mesh.ranks.sum(np.array([distance[finite].sum(), finite.sum()]))
    return {"farthest": {"vertex": vertex, "distance": largest}, "mean_distance": float(total / count)}


def _combined(mesh: LocalMesh, findings: dict[str, Any]) -> dict[str, Any]:
    """What was clamped on all ranks."""
    combined: dict[str, Any] = {}
    for part in mesh.ranks.comm.allgather(findings):
        for name, values in part.items():
            whole = combined.setdefault(name, {**values, "vertices": 0})
            whole["vertices"] += values["vertices"]
            for key, choose in (("most", max), ("lowest", min)):
                if key in values:
                    whole[key] = choose(whole[key], values[key])
    return combined
