"""The signed heat method: distance to curves, with the sign of a side, from their diffused normals.

Feng, Crane: A Heat Method for Generalized Signed Distance. ACM Trans. Graph. 43(4), 2024.
"""

from dataclasses import replace
from functools import reduce

import numpy as np

from geomhw.arrays import Complexes, Floats
from geomhw.errors import ConvergenceError
from geomhw.geodesic.auto_time import time_step
from geomhw.geodesic.diffusion_time import TimeStep
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.mesh.geometry import unit
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence_of
from geomhw.operators.edge_vectors import (
    edge_areas,
    edge_connection_stiffness,
    edge_directions,
    edge_vectors_at_faces,
)
from geomhw.operators.laplacian import backward_euler, stiffness
from geomhw.options import SolverName
from geomhw.solvers.auto import LaplaceSolver
from geomhw.solvers.direct import DirectSolver
from geomhw.solvers.nullspace import free_unknowns, without_mean

#: From this number of vertices on, multigrid is faster than a factorization for one solution.
LARGE = 4000
#: Of sweeps; φ changes by less than 1e-6 h, where its error is 1e-2 h.
TOLERANCE = 1e-7
#: Diffusion time in h² on meshes of this number of faces or fewer; on finer ones it grows with the fourth root.
SHORT, FEW_FACES = 0.45, 20_480


class SignedHeat:
    """The signed heat method on one mesh: assembles once, then answers any curves.

    Parameters
    ----------
    mesh : an oriented manifold mesh.
    time : diffusion time as in `time_step`, except that ``auto`` is 0.45 h² up to 20,480 faces m, and
        0.45 (m/20480)^¼ h² above.

    Raises
    ------
    MeshError
        If the mesh is no oriented manifold, or a face has zero area.

    References
    ----------
    Feng, Crane: A Heat Method for Generalized Signed Distance. ACM Trans. Graph. 43(4), 2024.
    """

    def __init__(self, mesh: TriangleMesh, time: str | float = "auto") -> None:
        mesh.require_oriented("signed distance")
        mesh.require_area()
        self.mesh: TriangleMesh = mesh
        self.time: TimeStep = _auto_time(mesh) if str(time).strip() == "auto" else time_step(time, mesh)
        self._stiffness, self._free = stiffness(mesh), free_unknowns(mesh.components, mesh.unreferenced_vertices)
        solver: SolverName = "multigrid" if mesh.n_vertices >= LARGE else "direct"
        self._poisson = LaplaceSolver(self._stiffness, self._free, solver, 1)
        self._directions = edge_directions(mesh)
        tL = edge_connection_stiffness(mesh, self._directions, _face_times(mesh, self.time.t))
        #: M + tL, (e, e).
        self._matrix = backward_euler(edge_areas(mesh), tL, 1.0)

    def __call__(self, curves: SurfacePoints) -> Floats:
        """Return the signed distance of vertices from the segments of curves, (n,); inf on other components.

        It is positive on the left of a segment, seen from outside, and zero in the mean over the segments.
        """
        self._poisson.begin()
        mesh, middles = self.mesh, _segment_middles(self.mesh, curves)
        X = self._diffused(_normals(mesh, curves, middles, self._directions), curves)  # I. (M + tL) X = X0
        Y = unit(edge_vectors_at_faces(mesh, X, self._directions))  # II. Y = X / |X|
        div = divergence_of(mesh, Y)
        phi = self._integrated(div)  # III. Sφ = -Div Y
        return _shifted(mesh, phi, curves, middles)

    def _integrated(self, div: Floats) -> Floats:
        """Return φ with Sφ = -Div Y, (n,), up to a constant on each component."""
        rhs = without_mean(-div, self.mesh.components)
        try:
            return self._poisson(rhs)
        except ConvergenceError:
            return DirectSolver(self._stiffness, self._free)(rhs)

    def _diffused(self, rhs: Complexes, curves: SurfacePoints) -> Complexes:
        """Return X at the edges of faces, (m, 3), times a factor per face, so that nothing underflows."""
        mesh = self.mesh
        start = np.full(mesh.n_vertices, np.inf)
        start[mesh.faces[curves.segments[:, 2]]] = 0.0
        arrival = edge_path_distance(mesh, np.flatnonzero(start == 0), start) / np.sqrt(self.time.t)
        low, high = mesh.edges.T
        potential = (arrival[low] + arrival[high]) / 2
        reached = np.flatnonzero(np.isfinite(potential))
        A = self._matrix if len(reached) == mesh.n_edges else self._matrix[reached][:, reached]
        scaled = np.zeros(mesh.n_edges, dtype=complex)
        try:
            from geomhw.solvers.heat_sweeps import solve_scaled_by_sweeps

            scaled[reached] = solve_scaled_by_sweeps(A, rhs[reached], potential[reached], TOLERANCE)
        except ConvergenceError:
            with np.errstate(under="ignore"):
                scaled[reached] = DirectSolver(A, np.ones(len(reached), dtype=bool))(rhs[reached])
            potential = np.where(np.isfinite(potential), 0.0, np.inf)
        of = mesh.edge_table.of_faces
        p = np.where(np.isfinite(potential), potential, 0.0)[of]
        # By columns, which takes a tenth of the time of reductions along rows of three.
        X = scaled[of] * np.exp(reduce(np.minimum, p.T)[:, None] - p)
        size = reduce(np.maximum, (np.abs(X.real) + np.abs(X.imag)).T)[:, None]
        return np.divide(X, size, out=np.zeros_like(X), where=size > 0)


def _auto_time(mesh: TriangleMesh) -> TimeStep:
    """Return the diffusion time c h² that balances two errors of φ on a surface of size L.

    Directions are wrong by the shape of faces, which adds up over distances: an error of h²/t L. Where fronts meet,
    directions are averaged over √t. The sum is least near c = (L/h)^½, up to a factor.
    """
    factor = SHORT * max(1.0, mesh.n_faces / FEW_FACES) ** 0.25
    return replace(time_step(f"{factor}*h2", mesh), asked="auto", reason=f"{factor:.3g} h²")


def _face_times(mesh: TriangleMesh, t: float) -> Floats:
    """Return diffusion times of faces, (m,), with which heat decays as exp(-d/√t) on faces of any size and shape.

    On a lattice of congruent faces, elements decay like that, in the mean over directions, with the time t - ε. Here ε
    is the leading term in h²/t: h²/48 on equilateral faces of side h, h²/29 on halves of squares of side h.
    """
    c, squares, A = mesh.cotangents, np.square(mesh.edge_lengths[mesh.edge_table.of_faces]), mesh.face_areas[:, None]
    terms = c * ((1 + c**2) * squares**2 / 128 + (c * squares / 8 - A / 6) ** 2) / (2 * A)
    return np.asarray(t - np.clip(sum(terms.T), 0, t / 2))


def _normals(mesh: TriangleMesh, curves: SurfacePoints, middles: Floats, directions: Complexes) -> Complexes:
    """Return X0, (e,): the left normals of segments, integrated along them with the basis functions of edges."""
    i, j, face = curves.segments.T
    positions = curves.positions(mesh)
    along = positions[j] - positions[i]
    left = np.cross(mesh.face_normals[face], along)
    x = unit(mesh.opposite_edges[face, 0])
    y = np.cross(mesh.face_normals[face], x)
    in_face = np.einsum("sx,sx->s", left, x) + 1j * np.einsum("sx,sx->s", left, y)
    values = in_face[:, None] * (1 - 2 * middles) * directions[face].conj()
    rhs = np.zeros(mesh.n_edges, dtype=complex)
    np.add.at(rhs, mesh.edge_table.of_faces[face], values)
    return rhs


def _segment_middles(mesh: TriangleMesh, curves: SurfacePoints) -> Floats:
    """Return the barycentric coordinates, (s, 3), of the middles of segments in their faces."""
    ends, face = curves.segments[:, :2], curves.segments[:, 2]
    is_corner = curves.corners[ends][..., None] == mesh.faces[face][:, None, None, :]
    return np.asarray(np.einsum("sec,seck->sk", curves.weights[ends], is_corner) / 2)


def _shifted(mesh: TriangleMesh, phi: Floats, curves: SurfacePoints, middles: Floats) -> Floats:
    """Return φ with mean zero over the segments in each component; inf on components without one."""
    i, j, face = curves.segments.T
    positions = curves.positions(mesh)
    length = np.linalg.norm(positions[j] - positions[i], axis=1)
    component = mesh.components[mesh.faces[face, 0]]
    at_curve = np.einsum("sk,sk->s", middles, phi[mesh.faces[face]])
    size = int(mesh.components.max()) + 1
    total = np.bincount(component, length, size)
    with np.errstate(invalid="ignore"):
        means = np.bincount(component, length * at_curve, size) / total
    shifted = phi - means[mesh.components]
    return np.where(np.isnan(shifted), np.inf, shifted)
