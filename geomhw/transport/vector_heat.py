"""Vector diffusion and parallel transport by the connection Laplacian [TVHM, algorithm 1].

Sharp, Soliman, Crane: The Vector Heat Method, ACM Trans. Graph. 38(3), 2019. Tangent vectors are complex numbers in a
frame at each vertex, so that one n x n Hermitian system stands for the 3n x 3n one.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.geodesic.auto_time import time_step
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.geodesic.heat_step import HeatStep
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.laplacian import backward_euler
from geomhw.operators.parallel_transport import to_complex
from geomhw.options import Connection, SolverName
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.log_scaled import LogValues, in_reach
from geomhw.transport.source_vectors import checked_vectors, seeded_angle, source_frames, tangent_vectors, unit_vectors
from geomhw.transport.tangent_domain import TangentDomain


class VectorHeat:
    """The vector heat method on one mesh for one time and connection: factors on first use, then answers any sources.

    Faces need not be consistently oriented: the method works on the orientation cover.

    Parameters
    ----------
    mesh : the mesh, or a `TangentDomain` of it to share between several times (connection and robust are then its own).
    time : diffusion time as in `time_step`.
    connection : ``normals`` or ``intrinsic``, as in `edge_transport`.
    robust : whether to compute on the mesh's `RobustTriangulation`, with the normals of its vertices.
    solver : as in `HeatDistance`; ``multigrid`` means sweeps that follow the heat here.

    Raises
    ------
    MeshError
        If a face has zero area, unless ``robust``; for ``intrinsic``, if the mesh is not manifold.
    FieldError
        For ``intrinsic`` together with ``robust``, or an unknown time, connection or solver.

    References
    ----------
    [TVHM, algorithm 1]

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> result = VectorHeat(icosphere(3)).from_vertices([7], [[1.0, 0.0, 0.0]])
    >>> result["transported"].shape
    (642, 3)
    """

    def __init__(
        self,
        mesh: TriangleMesh | TangentDomain,
        time: str | float = "auto",
        connection: Connection = "normals",
        robust: bool = False,
        solver: SolverName = "auto",
    ) -> None:
        self._domain = mesh if isinstance(mesh, TangentDomain) else TangentDomain(mesh, connection, robust)
        self.mesh = self._domain.mesh
        self._heat = HeatStep(self._domain.surface, time_step(time, self._domain.surface), solver=solver)
        #: M + tK, (n, n), complex Hermitian.
        self._matrix = backward_euler(self._domain.surface.vertex_areas, self._domain.K, self.time.t)

    @property
    def time(self) -> TimeStep:
        """The diffusion time, and why it was chosen."""
        return self._heat.time

    @property
    def robust(self) -> RobustTriangulation | None:
        """The robust triangulation, if one is used."""
        return self._domain.robust

    def from_vertices(self, sources: Sequence[int] | Ints, vectors: ArrayLike) -> Result:
        """Diffuse and transport one vector per source vertex; all else as in `from_sources`."""
        return self.from_sources(vertex_points(self.mesh, sources), vectors)

    def from_sources(self, sources: SurfacePoints, vectors: ArrayLike) -> Result:
        """Diffuse and transport one vector per source.

        Parameters
        ----------
        vectors : (k, 3) array, of which the tangential parts count; within a face, the part in its plane; at a vertex
            with several fans of faces, the part in the plane of each.

        Returns
        -------
        Result with these fields per vertex, tangent and zero on components without a source: ``diffused`` Y, with
        (M + tK) Y = Y0, where a vector within a face gives its shares to the corners; ``transported``, the vectors
        carried along shortest paths, with their lengths. Vectors do not pass edges of more than two faces, and vertices
        where several fans meet; these have the vector of the fan where the diffused one is longest. With the connection
        of normals they do not pass vertices round which faces cancel, and are zero there.

        Raises
        ------
        FieldError
            For a vector that is zero, not finite or normal to the surface, or a source given twice with different
            vectors.
        """
        domain = self._domain
        sources, given = checked_vectors(sources, vectors)
        fans, parts, tangent = tangent_vectors(sources, given, domain.base, *domain.split(sources))
        y0 = domain.source_field(fans, parts)
        impulse = domain.impulse(fans)
        indicator = self._heat.from_impulse(impulse)  # φ with (M + tS) φ = Σ δ
        diffused, logs = self._diffused(y0, indicator)  # Y with (M + tK) Y = Y0, also in logarithms
        length = self._extended_lengths(fans, parts, indicator)  # u/φ with (M + tS) u = Σ |X| δ
        transported = np.asarray(logs.sign * length, dtype=complex)
        self._restore_sources(transported, fans, parts)
        where = domain.answering(logs.log, transported)
        fields = [
            Field("diffused", "vertex", domain.vectors(diffused, where)),
            Field("transported", "vertex", domain.vectors(transported, where)),
        ]
        unreached = domain.unreached(impulse)[where]
        return Result(self.mesh, fields, self._report(sources, tangent, unreached), sources, tangent)

    def diffuse(self, vectors: Floats) -> Floats:
        """Return Y with (M + tC) Y = Y0, (n, 3), for tangent vectors Y0 at any vertices, (n, 3), zero elsewhere.

        Equal to the 3n x 3n solution; it fades with distance, and below 1e-308 to zero.
        """
        domain = self._domain
        y = self._solver(to_complex(domain.cover, domain.lifted(vectors)))
        return domain.vectors(y, domain.answering(LogValues.of(y).log, y))

    def extend(self, sources: Sequence[int] | Ints, values: ArrayLike) -> Floats:
        """Return values at source vertices, (k,), carried to all vertices along shortest paths, (n,).

        Where sources meet, values blend within their range. NaN on components without a source.

        References
        ----------
        [TVHM, sec. 4.1]
        """
        named = vertex_points(self.mesh, sources)
        chosen = named.distinct()[0]
        fans, source = self._domain.split(named[chosen])
        given = np.asarray(values, dtype=float)[chosen][source]
        indicator = self._heat.from_impulse(self._domain.impulse(fans))
        extended = self._ratio(self._domain.impulse(fans, given), indicator)
        known = np.where(np.isfinite(indicator.log), np.clip(extended, given.min(), given.max()), np.nan)
        return known[self._domain.answering(indicator.log)]

    @cached_property
    def _solver(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._heat.surface)

    def _diffused(self, y0: Complexes, indicator: LogValues) -> tuple[Complexes, LogValues]:
        """Y, (n,), and its direction and size, right even where Y itself underflows."""
        there = np.flatnonzero(np.isfinite(indicator.log))
        if not self._heat.iterates and in_reach(indicator.plain[there]):
            with np.errstate(under="ignore"):
                y = self._solver(y0)
            return y, LogValues.of(y)
        # Vectors decay as the scalar heat does: scaled by it, they are of order one.
        z = np.zeros_like(y0)
        z[there] = self._scaled(self._matrix, y0, indicator, there)
        with np.errstate(under="ignore"):
            return z * np.abs(indicator.plain), LogValues.of(z, -indicator.log)

    def _extended_lengths(self, sources: SurfacePoints, tangent: Floats, indicator: LogValues) -> Floats:
        """Lengths of the source vectors carried to all vertices, (n,); zero where no source is."""
        size = np.linalg.norm(tangent, axis=1)
        if np.ptp(size) <= 1e-15 * size.max():
            return np.where(np.isfinite(indicator.log), size[0], 0.0)
        return np.clip(self._ratio(self._domain.impulse(sources, size), indicator), size.min(), size.max())

    def _restore_sources(self, transported: Complexes, sources: SurfacePoints, tangent: Floats) -> None:
        """Set the vectors at source vertices to those given, in place: the limit t -> 0, exactly."""
        at = sources.faces < 0
        known = self._domain.impulse(sources[at]) > 0
        transported[known] = self._domain.source_field(sources[at], tangent[at])[known]

    def _ratio(self, values: Floats, indicator: LogValues) -> Floats:
        """The heat of the values over that of the indicator, (n,); zero where there is none."""
        there = np.flatnonzero(np.isfinite(indicator.log))
        ratio = np.zeros(len(values))
        if not self._heat.iterates and in_reach(indicator.plain[there]):
            ratio[there] = self._heat.from_impulse(values).plain[there] / indicator.plain[there]
        else:
            ratio[there] = self._scaled(self._heat.matrix, values, indicator, there) * indicator.sign[there]
        return ratio

    def _scaled(self, matrix: sp.csr_array, rhs: NDArray[Any], indicator: LogValues, there: Ints) -> NDArray[Any]:
        """The solution of a system over the size of the indicator, where that is not zero."""
        A = matrix if len(there) == len(rhs) else matrix[there][:, there]
        return self._heat.solution.scaled(A, rhs[there], -indicator.log[there])

    def _report(self, sources: SurfacePoints, tangent: Floats, unreached: NDArray[np.bool_]) -> dict[str, Any]:
        return {
            "sources": sources.report(),
            "vectors": tangent.tolist(),
            "connection": self._domain.connection,
            "time": self.time.report(self._domain.surface.mean_edge_length),
            "unreachable_vertices": int(np.count_nonzero(unreached)),
            "solver": "multigrid" if self._heat.iterates else "direct",
            **({"robust": self.robust.report()} if self.robust else {}),
            **self._domain.crossings,
        }


def random_tangent(mesh: TriangleMesh, vertex: int, seed: int) -> Floats:
    """Return a unit tangent vector at a vertex, (3,), at an angle drawn from the seed."""
    return tangent_at(mesh, vertex, seeded_angle(seed))


def tangent_at(mesh: TriangleMesh, vertex: int, degrees: float) -> Floats:
    """Return the unit tangent vector at a vertex, (3,), at an angle in degrees.

    The angle is counterclockwise from the first vector of `source_frames`.
    """
    return unit_vectors(source_frames(mesh, vertex_points(mesh, [vertex]))[0], degrees)


def transport_over_times(
    mesh: TriangleMesh,
    sources: SurfacePoints | Sequence[int] | Ints,
    vectors: ArrayLike,
    times: Sequence[str | float],
    connection: Connection = "normals",
    robust: bool = False,
    solver: SolverName = "auto",
) -> Result:
    """Diffuse and transport the same vectors for several times.

    Parameters
    ----------
    sources : surface points, or source vertices counted from 0.
    vectors, connection, robust, solver : as in `VectorHeat`.
    times : diffusion times as in `time_step`.

    Returns
    -------
    Result with the fields of `VectorHeat.from_sources`, with several times with the suffix ``_0``, ``_1``, ... in the
    order of the times, and ``dt``, the times. The report lists them under ``times``.
    """
    where = sources if isinstance(sources, SurfacePoints) else vertex_points(mesh, sources)
    domain = TangentDomain(mesh, connection, robust)
    runs = [VectorHeat(domain, time, solver=solver).from_sources(where, vectors) for time in times]
    fields = [
        Field(f"{field.name}_{k}" if len(runs) > 1 else field.name, field.location, field.values)
        for k, run in enumerate(runs)
        for field in run.fields
    ]
    steps = [run.report["time"] for run in runs]
    fields.append(Field("dt", "mesh", np.array([step["t"] for step in steps])))
    shared = {key: value for key, value in runs[0].report.items() if key != "time"}
    return Result(mesh, fields, shared | {"times": steps}, runs[0].sources, runs[0].source_vectors)
