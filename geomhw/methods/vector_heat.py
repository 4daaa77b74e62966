"""Vector diffusion and parallel transport by the connection Laplacian [TVHM, algorithm 1].

Sharp, Soliman, Crane: The Vector Heat Method, ACM Trans. Graph. 38(3), 2019. Tangent vectors are complex numbers in a
frame at each vertex, so that one n x n Hermitian system stands for the 3n x 3n one.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geomhw.errors import FieldError
from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.robust import RobustTriangulation
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.methods.heat_flow import HeatFlow
from geomhw.methods.sources import checked_sources
from geomhw.methods.time_step import TimeStep
from geomhw.operators.connection import (
    Complexes,
    Connection,
    complex_connection_stiffness,
    from_complex,
    to_complex,
)
from geomhw.operators.laplacian import lumped_mass
from geomhw.results import Field, Result
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.wavefront import LogValues, in_reach, solve_scaled

#: A vector whose tangential part is a smaller share of it than this is normal to the surface.
LEAST_TANGENT_SHARE = 1e-6


class VectorHeat:
    """Vector heat method for one mesh, time and connection: factors on first use, then answers any sources.

    time: as in `time_step`. connection: ``normals`` or ``intrinsic``, see `edge_transport`. robust: compute on the
    mesh's `RobustTriangulation`, with the normals of its vertices. MeshError if a face has no area and that is not
    asked for or, for ``intrinsic``, the mesh is no oriented manifold; FieldError for ``intrinsic`` and robust at once.

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
    ) -> None:
        self.mesh = mesh
        self.connection = connection
        self.robust = RobustTriangulation.of(mesh) if robust else None
        surface = self.robust.surface if self.robust else None
        self._flow = HeatFlow(surface or mesh, time)
        K = complex_connection_stiffness(mesh, connection, surface)
        self._matrix = (lumped_mass(surface or mesh) + self.time.t * K).tocsr()

    @property
    def time(self) -> TimeStep:
        """The diffusion time, and why."""
        return self._flow.time

    @cached_property
    def _solver(self) -> DirectSolver:
        return DirectSolver(self._matrix, self._flow.surface)

    def diffuse(self, vectors: Floats) -> Floats:
        """Y with (M + tC) Y = Y0, (n, 3), for tangent vectors Y0 at any vertices, (n, 3), zero elsewhere.

        Equal to the 3n x 3n solution; it fades with distance, and below 1e-308 to zero.
        """
        return from_complex(self.mesh, self._solver(to_complex(self.mesh, vectors)))

    def extend(self, sources: Sequence[int] | Ints, values: ArrayLike) -> Floats:
        """Values at source vertices carried to all others along shortest paths, (n,) [TVHM, sec. 4.1].

        Where sources meet, values blend; none leaves their range. NaN where no source can be reached.
        """
        wanted, order = _distinct(self.mesh, sources)
        given = np.asarray(values, dtype=float)[order]
        impulse = self._impulse(wanted, np.ones(len(wanted)))
        weight = self._flow.from_impulse(impulse)
        extended = self._ratio(self._impulse(wanted, given), weight)
        return np.where(np.isfinite(weight.log), np.clip(extended, given.min(), given.max()), np.nan)

    def from_vertices(self, sources: Sequence[int] | Ints, vectors: ArrayLike) -> Result:
        """Diffuse and transport one vector a source; ``vectors``: (k, 3), of which the tangential part counts.

        Fields, per vertex: ``diffused`` Y, with (M + tC) Y = Y0; ``transported``, the vectors carried along shortest
        paths, with their lengths; both tangent, and zero on components without a source. FieldError for a vector that
        is zero, not finite or normal to the surface, and for a vertex given twice with different vectors.
        """
        mesh = self.mesh
        wanted, tangent = self._checked(sources, vectors)
        y0 = to_complex(mesh, self._impulse(wanted, tangent))
        size = np.linalg.norm(tangent, axis=1)
        impulse = self._impulse(wanted, np.ones(len(wanted)))
        weight = self._flow.from_impulse(impulse)
        diffused, direction = self._spread(y0, weight)
        if np.ptp(size) <= 1e-15 * size.max():
            length = np.where(np.isfinite(weight.log), size[0], 0.0)
        else:
            length = np.clip(self._ratio(self._impulse(wanted, size), weight), size.min(), size.max())
        transported = direction * length
        transported[wanted] = y0[wanted]  # TVHM's limit t -> 0, exactly
        unreached = int(np.count_nonzero(~np.isfinite(weight.log) & self._flow.surface))
        report = {
            "sources": wanted.tolist(),
            "vectors": tangent.tolist(),
            "connection": self.connection,
            "time": self.time.report(self._flow.mesh.mean_edge_length),
            "unreachable_vertices": unreached,
        } | ({"robust": self.robust.report()} if self.robust else {})
        fields = [
            Field("diffused", "vertex", from_complex(mesh, diffused)),
            Field("transported", "vertex", from_complex(mesh, transported)),
        ]
        return Result(mesh, fields, report)

    def _checked(self, sources: Sequence[int] | Ints, vectors: ArrayLike) -> tuple[Ints, Floats]:
        """Distinct sources and the tangential part of the vector at each."""
        given = np.atleast_2d(np.asarray(vectors, dtype=float))
        if given.shape != (np.size(sources), 3):
            raise FieldError(f"{np.size(sources)} sources need as many vectors of three components, not {given.shape}")
        for source, vector in zip(np.atleast_1d(sources), given, strict=True):
            if not np.isfinite(vector).all():
                raise FieldError(f"the vector at source {source} is not finite: {vector.tolist()}")
            if not vector.any():
                raise FieldError(f"the vector at source {source} is zero; it has no direction to transport")
        wanted, order = _distinct(self.mesh, sources)
        for source, vector in zip(np.atleast_1d(sources), given, strict=True):
            if not np.array_equal(vector, given[order][np.searchsorted(wanted, source)]):
                raise FieldError(f"source {source} is given twice, with different vectors; give it once")
        given = given[order]
        frames = self.mesh.tangent_frames[wanted]
        tangent = np.einsum("sk,skx->sx", np.einsum("skx,sx->sk", frames, given), frames)
        normal = np.linalg.norm(tangent, axis=1) <= LEAST_TANGENT_SHARE * np.linalg.norm(given, axis=1)
        if normal.any():
            bad = wanted[normal][0]
            raise FieldError(f"the vector at source {bad} is normal to the surface; give one with a tangential part")
        return wanted, tangent

    def _impulse(self, sources: Ints, values: Floats) -> Floats:
        """The values at their sources, zero elsewhere."""
        impulse = np.zeros((self.mesh.n_vertices, *values.shape[1:]))
        impulse[sources] = values
        return impulse

    def _spread(self, y0: Complexes, weight: LogValues) -> tuple[Complexes, Complexes]:
        """Y and Y/|Y|, the latter right even where Y itself has faded to nothing."""
        there = np.flatnonzero(np.isfinite(weight.log))
        if in_reach(weight.plain[there]):
            with np.errstate(under="ignore"):
                y = self._solver(y0)
            return y, _unit(y)
        # The decay of the scalar heat is that of the vectors too: scaled by it, they are of order one.
        z = np.zeros_like(y0)
        z[there] = solve_scaled(self._matrix[there][:, there], y0[there], -weight.log[there])
        with np.errstate(under="ignore"):
            return z * np.abs(weight.plain), _unit(z)

    def _ratio(self, values: Floats, weight: LogValues) -> Floats:
        """The heat of the values over that of the sources, ``weight``, (n,); zero where there is none."""
        there = np.flatnonzero(np.isfinite(weight.log))
        ratio = np.zeros(self.mesh.n_vertices)
        if in_reach(weight.plain[there]):
            ratio[there] = self._flow.from_impulse(values).plain[there] / weight.plain[there]
        else:
            ratio[there] = solve_scaled(self._flow.matrix[there][:, there], values[there], -weight.log[there])
            ratio[there] *= weight.sign[there]
        return ratio


def _distinct(mesh: TriangleMesh, sources: Sequence[int] | Ints) -> tuple[Ints, Ints]:
    """Checked sources in ascending order, and where each first stands among those given."""
    wanted = checked_sources(mesh, sources)
    return wanted, np.unique(np.atleast_1d(np.asarray(sources)), return_index=True)[1]


def _unit(z: Complexes) -> Complexes:
    """z/|z|; zero stays zero. Scaled first, so that no square underflows."""
    size = np.maximum(np.abs(z.real), np.abs(z.imag))
    scaled_z = np.divide(z, size, out=np.zeros_like(z), where=size > 0)
    return np.asarray(np.divide(scaled_z, np.abs(scaled_z), out=scaled_z, where=size > 0))


def random_tangent(mesh: TriangleMesh, vertex: int, seed: int) -> Floats:
    """A unit tangent vector at a vertex at an angle drawn from the seed, (3,)."""
    return tangent_at(mesh, vertex, 360 * np.random.default_rng(seed).random())


def tangent_at(mesh: TriangleMesh, vertex: int, degrees: float) -> Floats:
    """The unit tangent vector at a vertex at that angle, counterclockwise from the first of its ``tangent_frames``."""
    angle = np.radians(degrees)
    e1, e2 = mesh.tangent_frames[vertex]
    return np.asarray(np.cos(angle) * e1 + np.sin(angle) * e2)


def transport_over_times(
    mesh: TriangleMesh,
    sources: Sequence[int] | Ints,
    vectors: ArrayLike,
    times: Sequence[str | float],
    connection: Connection = "normals",
    robust: bool = False,
) -> Result:
    """Diffuse and transport the same vectors for several times, one factorization each.

    Fields as in `VectorHeat.from_vertices`, for more than one time with the suffix ``_0``, ``_1``, ... in the order of
    the times; ``dt`` holds them. The report lists them under ``times``.
    """
    runs = [VectorHeat(mesh, time, connection, robust).from_vertices(sources, vectors) for time in times]
    fields = [
        Field(f"{field.name}_{k}" if len(runs) > 1 else field.name, field.location, field.values)
        for k, run in enumerate(runs)
        for field in run.fields
    ]
    steps = [run.report["time"] for run in runs]
    fields.append(Field("dt", "mesh", np.array([step["t"] for step in steps])))
    shared = {key: value for key, value in runs[0].report.items() if key != "time"}
    return Result(mesh, fields, shared | {"times": steps})
