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
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.geodesic.heat_step import HeatStep
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.orientation import orientation_cover, without_duplicate_faces
from geomhw.mesh.surface_points import SurfacePoints, vertex_points
from geomhw.mesh.topology import pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.laplacian import backward_euler
from geomhw.operators.parallel_transport import from_complex, to_complex
from geomhw.options import Connection, SolverName
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.log_scaled import LogValues, in_reach
from geomhw.transport.source_vectors import seeded_angle, spread_to_corners, tangent_vectors, turned


class VectorHeat:
    """Vector heat method for one mesh, time and connection: factors on first use, then answers any sources.

    time: as in `time_step`. connection: ``normals`` or ``intrinsic``, see `edge_transport`. robust: compute on the
    mesh's `RobustTriangulation`, with the normals of its vertices. solver: as in `HeatDistance`, where ``multigrid``
    means sweeps that follow the heat here. MeshError if a face has no area and robust is not asked for or, for
    ``intrinsic``, the mesh is no manifold; FieldError for ``intrinsic`` and robust at once.

    Faces need not agree on what is up: all is done on the `orientation_cover`, with the same vector at both vertices of
    one place where the surface is one-sided.

    >>> from geomhw.mesh.primitives import icosphere
    >>> result = VectorHeat(icosphere(3)).from_vertices([7], [[1.0, 0.0, 0.0]])
    >>> result["transported"].shape
    (642, 3)
    """

    def __init__(
        self,
        mesh: TriangleMesh,
        time: str | float = "auto",
        connection: Connection = "normals",
        robust: bool = False,
        solver: SolverName = "auto",
    ) -> None:
        self.mesh = mesh
        self.connection = connection
        self._cover = cover = orientation_cover(mesh)
        self.robust = RobustTriangulation.of(cover) if robust else None
        surface = self.robust.surface if self.robust else None
        self._flow = HeatStep(surface or cover, time, solver=solver)
        K = complex_connection_stiffness(cover, connection, surface)
        self._matrix = backward_euler((surface or cover).vertex_areas, K, self.time.t)

    @property
    def time(self) -> TimeStep:
        """The diffusion time, and why."""
        return self._flow.time

    @cached_property
    def _crossings(self) -> dict[str, int]:
        """How many edges and vertices have no tangent plane, by name, of those that there are."""
        single = without_duplicate_faces(self.mesh)
        edges = int(np.count_nonzero(single.edge_table.face_counts > 2))
        vertices = len(pinched_vertices(single.faces, single.edge_table, single.n_vertices))
        counts = {"non_manifold_edges": edges, "non_manifold_vertices": vertices}
        return {name: count for name, count in counts.items() if count}

    @cached_property
    def _solver(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._flow.surface)

    def diffuse(self, vectors: Floats) -> Floats:
        """Y with (M + tC) Y = Y0, (n, 3), for tangent vectors Y0 at any vertices, (n, 3), zero elsewhere.

        Equal to the 3n x 3n solution; it fades with distance, and below 1e-308 to zero.
        """
        return self._vectors(self._solver(to_complex(self._cover, self._lifted(vectors))))

    def extend(self, sources: Sequence[int] | Ints, values: ArrayLike) -> Floats:
        """Values at source vertices carried to all others along shortest paths, (n,) [TVHM, sec. 4.1].

        Where sources meet, values blend; none leaves their range. NaN where no source can be reached.
        """
        named = vertex_points(self.mesh, sources)
        chosen = named.distinct()[0]
        wanted, given = named[chosen], np.asarray(values, dtype=float)[chosen]
        weight = self._flow.from_impulse(self._impulse(wanted))
        extended = self._ratio(self._impulse(wanted, given), weight)
        known = np.where(np.isfinite(weight.log), np.clip(extended, given.min(), given.max()), np.nan)
        return known[: self.mesh.n_vertices]

    def from_vertices(self, sources: Sequence[int] | Ints, vectors: ArrayLike) -> Result:
        """Diffuse and transport one vector a source vertex; all else as in `from_sources`."""
        return self.from_sources(vertex_points(self.mesh, sources), vectors)

    def from_sources(self, sources: SurfacePoints, vectors: ArrayLike) -> Result:
        """Diffuse and transport one vector a source; ``vectors``: (k, 3), of which the tangential part counts, within a
        face that in its plane.

        Fields, per vertex: ``diffused`` Y, with (M + tC) Y = Y0, to which a vector within a face gives its shares at
        the corners; ``transported``, the vectors carried along shortest paths, with their lengths; both tangent, and
        zero on components without a source. FieldError for a vector that is zero, not finite or normal to the surface,
        and for a source given twice with different vectors.
        """
        mesh = self.mesh
        wanted, tangent = tangent_vectors(mesh, sources, vectors)
        y0 = self._start(wanted, tangent)
        size = np.linalg.norm(tangent, axis=1)
        weight = self._flow.from_impulse(self._impulse(wanted))
        diffused, direction = self._spread(y0, weight)
        if np.ptp(size) <= 1e-15 * size.max():
            length = np.where(np.isfinite(weight.log), size[0], 0.0)
        else:
            length = np.clip(self._ratio(self._impulse(wanted, size), weight), size.min(), size.max())
        transported = direction * length
        at = wanted.faces < 0
        given, known = self._start(wanted[at], tangent[at]), self._impulse(wanted[at]) > 0
        transported[known] = given[known]  # TVHM's limit t -> 0, exactly
        unreached = (~np.isfinite(weight.log) & self._flow.surface)[: mesh.n_vertices]
        report = {
            "sources": wanted.report(),
            "vectors": tangent.tolist(),
            "connection": self.connection,
            "time": self.time.report(self._flow.mesh.mean_edge_length),
            "unreachable_vertices": int(np.count_nonzero(unreached)),
            "solver": "multigrid" if self._flow.iterates else "direct",
            **({"robust": self.robust.report()} if self.robust else {}),
            **self._crossings,
        }
        fields = [
            Field("diffused", "vertex", self._vectors(diffused)),
            Field("transported", "vertex", self._vectors(transported)),
        ]
        return Result(mesh, fields, report)

    def _start(self, sources: SurfacePoints, tangent: Floats) -> Complexes:
        """Y0 on the cover, of vectors at sources, (k, 3)."""
        y0 = spread_to_corners(self.mesh, sources, tangent)
        if self._cover is self.mesh:
            return y0
        return to_complex(self._cover, self._lifted(from_complex(self.mesh, y0)))

    def _impulse(self, sources: SurfacePoints, values: Floats | float = 1.0) -> Floats:
        """`SurfacePoints.impulse` on the cover."""
        return self._lifted(sources.impulse(self.mesh.n_vertices, values))

    def _lifted(self, values: Floats) -> Floats:
        """Values per vertex of the mesh as values per vertex of the cover."""
        times = self._cover.n_vertices // self.mesh.n_vertices
        return np.concatenate([values] * times) if times > 1 else values

    def _vectors(self, z: Complexes) -> Floats:
        """Tangent vectors, (n, 3), at the vertices of the mesh, of complex numbers on the cover."""
        return from_complex(self._cover, z)[: self.mesh.n_vertices]

    def _spread(self, y0: Complexes, weight: LogValues) -> tuple[Complexes, Complexes]:
        """Y and Y/|Y|, the latter right even where Y itself has faded to nothing."""
        there = np.flatnonzero(np.isfinite(weight.log))
        if not self._flow.iterates and in_reach(weight.plain[there]):
            with np.errstate(under="ignore"):
                y = self._solver(y0)
            return y, _unit(y)
        # The decay of the scalar heat is that of the vectors too: scaled by it, they are of order one.
        z = np.zeros_like(y0)
        z[there] = self._scaled(self._matrix, y0, weight, there)
        with np.errstate(under="ignore"):
            return z * np.abs(weight.plain), _unit(z)

    def _ratio(self, values: Floats, weight: LogValues) -> Floats:
        """The heat of the values over that of the sources, ``weight``, (n,); zero where there is none."""
        there = np.flatnonzero(np.isfinite(weight.log))
        ratio = np.zeros(len(values))
        if not self._flow.iterates and in_reach(weight.plain[there]):
            ratio[there] = self._flow.from_impulse(values).plain[there] / weight.plain[there]
        else:
            ratio[there] = self._scaled(self._flow.matrix, values, weight, there) * weight.sign[there]
        return ratio

    def _scaled(self, matrix: sp.csr_array, rhs: NDArray[Any], weight: LogValues, there: Ints) -> NDArray[Any]:
        """The solution over the size of the weight, where that is not zero."""
        A = matrix if len(there) == len(rhs) else matrix[there][:, there]
        return self._flow.scaled(A, rhs[there], -weight.log[there])


def _unit(z: Complexes) -> Complexes:
    """z/|z|; zero stays zero. Scaled first, so that no square underflows."""
    size = np.maximum(np.abs(z.real), np.abs(z.imag))
    scaled_z = np.divide(z, size, out=np.zeros_like(z), where=size > 0)
    return np.asarray(np.divide(scaled_z, np.abs(scaled_z), out=scaled_z, where=size > 0))


def random_tangent(mesh: TriangleMesh, vertex: int, seed: int) -> Floats:
    """A unit tangent vector at a vertex at an angle drawn from the seed, (3,)."""
    return tangent_at(mesh, vertex, seeded_angle(seed))


def tangent_at(mesh: TriangleMesh, vertex: int, degrees: float) -> Floats:
    """The unit tangent vector at a vertex at that angle, counterclockwise from the first of its ``tangent_frames``."""
    return turned(mesh.tangent_frames[vertex], degrees)


def transport_over_times(
    mesh: TriangleMesh,
    sources: SurfacePoints | Sequence[int] | Ints,
    vectors: ArrayLike,
    times: Sequence[str | float],
    connection: Connection = "normals",
    robust: bool = False,
    solver: SolverName = "auto",
) -> Result:
    """Diffuse and transport the same vectors for several times, one factorization each.

    Fields as in `VectorHeat.from_sources`, for more than one time with the suffix ``_0``, ``_1``, ... in the order of
    the times; ``dt`` holds them. The report lists them under ``times``.
    """
    where = sources if isinstance(sources, SurfacePoints) else vertex_points(mesh, sources)
    runs = [VectorHeat(mesh, time, connection, robust, solver).from_sources(where, vectors) for time in times]
    fields = [
        Field(f"{field.name}_{k}" if len(runs) > 1 else field.name, field.location, field.values)
        for k, run in enumerate(runs)
        for field in run.fields
    ]
    steps = [run.report["time"] for run in runs]
    fields.append(Field("dt", "mesh", np.array([step["t"] for step in steps])))
    shared = {key: value for key, value in runs[0].report.items() if key != "time"}
    return Result(mesh, fields, shared | {"times": steps})
