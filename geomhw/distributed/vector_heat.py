"""The vector heat method [TVHM, algorithm 1] on a mesh that is distributed over MPI ranks."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.distributed.assembly import LocalOperators, assemble
from geomhw.distributed.components import component_labels
from geomhw.distributed.connection import (
    connection_stiffness,
    intrinsic_stiffness,
    require_normals,
    tangent_frames,
    without_normal,
)
from geomhw.distributed.edge_paths import edge_path_distance
from geomhw.distributed.heat_method import LocalResult, time_step
from geomhw.distributed.heat_step import heat_step
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.orientation_cover import orientation_cover
from geomhw.distributed.ranks import release_memory
from geomhw.distributed.source_stars import SourceStars
from geomhw.distributed.tangent_system import TangentSystem
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.mesh.cut import cut_into_sheets
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.laplacian import backward_euler
from geomhw.operators.parallel_transport import from_complex, from_frames, in_frames
from geomhw.options import Connection
from geomhw.solvers.log_scaled import LogValues
from geomhw.stages import Stages
from geomhw.transport.source_vectors import checked_vectors, spread_to_corners, tangent_vectors
from geomhw.transport.tangent_domain import answering_copies, sources_on_sheets


def distributed_transport(
    mesh: LocalMesh,
    stars: SourceStars,
    sources: SurfacePoints,
    vectors: ArrayLike,
    times: Sequence[str | float] = ("auto",),
    connection: Connection = "normals",
    stages: Stages | None = None,
) -> LocalResult:
    """Diffuse and transport one vector per source, at the vertices of each rank.

    Parameters
    ----------
    mesh : the part of each rank.
    stars : the faces round the sources.
    sources : points of the mesh, with the numbers of the file, the same on all ranks.
    vectors : (s, 3) array, of which the tangential parts count.
    times : diffusion times as in `distributed_distance`.
    connection : as in `VectorHeat`.
    stages : measures the time of each stage.

    Returns
    -------
    LocalResult with ``diffused`` and ``transported``, as `VectorHeat.from_sources` has them; with several times with
    the suffix ``_0``, ``_1``, ...

    Raises
    ------
    ArgumentError
        If a vector is zero, not finite or normal to the surface, or for an unknown time.
    MeshError
        If a face has zero area, or a source is a vertex without a normal; for ``intrinsic``, if any vertex has none, or
        if the cover is not manifold.
    ConvergenceError
        If heat does not reach the far side.
    """
    stage = stages or Stages()
    points, given = checked_vectors(sources, vectors)
    base, copy_of = cut_into_sheets(stars.mesh)
    places, source = sources_on_sheets(stars.points(points), base, copy_of)
    places, parts, tangent = tangent_vectors(points, given, base, places, source)
    with stage("assembly"):
        cover = orientation_cover(mesh)
        operators = assemble(cover.mesh)
        frames = tangent_frames(cover.mesh)
        if connection == "intrinsic":
            require_normals(cover.mesh, operators.areas, frames)
    release_memory()
    rows = stars.fan_rows(cover.mesh, base)
    heat = _VectorHeat(cover.mesh, operators, frames, connection, rows, base, places, parts)
    steps = [time_step(time, operators) for time in times]
    with stage("heat"):
        answers = [heat(step) for step in steps]
    where = [answering_copies(cover.original, found.pop("log"), found["transported"]) for found, _ in answers]
    fields = {
        f"{name}_{k}" if len(steps) > 1 else name: values[where[k]]
        for k, (found, _) in enumerate(answers)
        for name, values in found.items()
    }
    h: float = operators.mean_edge_length
    bare = without_normal(frames)
    count = int(mesh.ranks.sum(int((bare[: cover.mesh.n_own] & (operators.areas > 0)).sum()))) // cover.sides
    unreached = heat.unreached(bare if count else None)[where[0]]
    report = {
        "sources": points.report(),
        "vectors": tangent.tolist(),
        "connection": connection,
        "times": [step.report(h) for step in steps],
        "unreachable_vertices": int(mesh.ranks.sum(int(unreached.sum()))),
        **cover.crossings,
        **({"vertices_without_normal": count} if count else {}),
        "mean_edge_length": cover.mean_edge_length or h,
        "heat": [report for _, report in answers],
    }
    return LocalResult(mesh, fields, report)


class _VectorHeat:
    """The vector heat method for tangent vectors at points of the stars, cut into sheets, for any time.

    rows : as `SourceStars.fan_rows`.
    """

    def __init__(
        self,
        mesh: LocalMesh,
        operators: LocalOperators,
        frames: Floats,
        connection: Connection,
        rows: tuple[Ints, Ints],
        base: TriangleMesh,
        points: SurfacePoints,
        tangent: Floats,
    ) -> None:
        self._mesh, self._operators, self._frames = mesh, operators, frames
        self._at, self._here = rows
        self._stiffness = intrinsic_stiffness if connection == "intrinsic" else connection_stiffness
        self._size = np.linalg.norm(tangent, axis=1)
        self._impulse = self._own(points.impulse(base.n_vertices))
        self._weighted = self._own(points.impulse(base.n_vertices, self._size))
        self._y0 = self._own_vectors(base, points, tangent)
        vertices = points.faces < 0
        self._exact = self._own(points[vertices].impulse(base.n_vertices)) > 0
        warm = mesh.with_ghosts(self._impulse > 0)
        #: Path lengths along edges from the corners of the sources, (k,).
        self.paths = edge_path_distance(mesh, operators, np.flatnonzero(warm))

    def unreached(self, bare: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
        """Return a mask, (k,), of the vertices with faces that no vector reaches.

        bare : (k + g,) mask of vertices without a normal, if there are any: vectors do not pass them.
        """
        mesh, has_area = self._mesh, self._operators.areas > 0
        if bare is None:
            return np.asarray(np.isinf(self.paths) & has_area)
        labels = component_labels(mesh, self._operators.edges[~bare[self._operators.edges].any(axis=1)])
        with_source = np.concatenate(mesh.ranks.comm.allgather(np.unique(labels[self._impulse > 0])))
        return np.asarray(~np.isin(labels, with_source) & has_area & ~bare[: mesh.n_own])

    def __call__(self, step: TimeStep) -> tuple[dict[str, Floats], dict[str, Any]]:
        """Return the fields, (k, 3), ``log``, that of the size of Y, (k,), and the methods of the heat steps."""
        mesh, operators = self._mesh, self._operators
        arrival, multiple = self.paths / np.sqrt(step.t), step.t / operators.mean_edge_length**2
        scalar = partial(backward_euler, operators.areas, operators.stiffness, step.t)
        lengths, report = self._extended_lengths(scalar, arrival, multiple)  # u/φ
        Y, of_vectors = self._diffused(scalar, step, arrival, multiple)  # (M + tK) Y = Y0
        transported = Y.sign * lengths
        transported[self._exact] = self._y0[self._exact]  # the limit t -> 0
        vectors = {"diffused": Y.plain, "transported": transported}
        frames = self._frames[: mesh.n_own]
        fields = {name: from_frames(frames, z) for name, z in vectors.items()}
        return {**fields, "log": Y.log}, {"vectors": of_vectors, **report}

    def _diffused(
        self, scalar: Any, step: TimeStep, arrival: Floats, multiple: float
    ) -> tuple[LogValues, dict[str, Any]]:
        operators = self._operators

        def assemble_vectors() -> Any:
            K = self._stiffness(self._mesh, operators.stiffness, self._frames)
            return backward_euler(operators.areas, K, step.t)

        system = TangentSystem(scalar, self._frames[: self._mesh.n_own])
        return heat_step(self._mesh, assemble_vectors, self._y0, arrival, multiple, system)

    def _extended_lengths(self, scalar: Any, arrival: Floats, multiple: float) -> tuple[Floats, dict[str, Any]]:
        """The lengths of the source vectors carried to all vertices, (k,); zero where no heat arrives."""
        size, reached = self._size, np.isfinite(arrival)
        if np.ptp(size) <= 1e-15 * size.max():
            return np.where(reached, size[0], 0.0), {}
        (u, of_lengths), (phi, of_indicator) = (
            heat_step(self._mesh, scalar, impulse, arrival, multiple) for impulse in (self._weighted, self._impulse)
        )
        ratio = np.zeros(len(arrival))
        ratio[reached] = (u.sign * phi.sign)[reached] * np.exp(u.log[reached] - phi.log[reached])
        return np.clip(ratio, size.min(), size.max()) * reached, {"lengths": of_lengths, "indicator": of_indicator}

    def _own(self, values: Floats) -> Floats:
        """Values at the vertices of the stars as values at those of this rank, zero elsewhere."""
        found = np.zeros((self._mesh.n_own, *values.shape[1:]))
        found[self._at] = values[self._here]
        return found

    def _own_vectors(self, base: TriangleMesh, points: SurfacePoints, tangent: Floats) -> Complexes:
        """Y0 at the vertices of this rank, (k,)."""
        vectors = self._own(from_complex(base, spread_to_corners(base, points, tangent)))
        return in_frames(self._frames[: self._mesh.n_own], vectors)
