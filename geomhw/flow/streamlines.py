"""Exact streamlines of a vector field that is constant on each face."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled
from geomhw.errors import ArgumentError, ConvergenceError
from geomhw.flow.tangent_fields import tangential
from geomhw.mesh.sampling import points_on, spread_samples
from geomhw.mesh.topology import inner_pairs
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import hat_gradients

#: Most edges that a point may cross in a call.
MOST_CROSSINGS = 200_000
#: A barycentric coordinate below this is zero: the point is on the edge, or at the vertex.
ON_EDGE = 1e-14
#: A point that returns to an edge this near, relative to the distance from its ends, is on a closed streamline.
CLOSED = 1e-9
#: A point on a spiral about a vertex, with a barycentric coordinate this near 1, stays there until the next call.
CORE = 1e-3


@dataclass(frozen=True)
class FacePoints:
    """Points in faces, (k,), by barycentric coordinates, (k, 3), that are not negative and sum to 1."""

    faces: Ints
    weights: Floats


class StreamlineTracer:
    """Move points along the streamlines of face fields on one mesh.

    In a face a streamline is a straight segment along V. It crosses edges as if both faces were laid flat, so the only
    error is rounding: along n x ∇ψ, the ψ of a point is constant. Where the fields on both sides of an edge point into
    it, a point slides along the edge by the mean of the two that crosses neither way; at the boundary, by the part of
    V along it. From a vertex it leaves by the fastest face or edge that leads away; where there is none it stays. No
    point leaves the surface.

    Parameters
    ----------
    mesh : edge-manifold, oriented or not, with or without boundary.

    Raises
    ------
    MeshError
        If an edge has more than two faces, or a face has zero area.

    References
    ----------
    Filippov: Differential Equations with Discontinuous Righthand Sides, sec. 4, 1988.

    Examples
    --------
    >>> import numpy as np
    >>> from geomhw.mesh import grid
    >>> mesh = grid(8, 8)
    >>> tracer, V = StreamlineTracer(mesh), np.tile([0.1, 0.0, 0.0], (mesh.n_faces, 1))
    >>> seeds = tracer.seeds(5)
    >>> moved = tracer.positions(tracer.advance(seeds, V, 0.5)) - tracer.positions(seeds)
    >>> moved.round(12)[0] + 0.0
    array([0.05, 0.  , 0.  ])
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        mesh.require_manifold("tracers need a manifold")
        self.mesh = mesh
        self._hats = hat_gradients(mesh)
        one, other, _ = inner_pairs(mesh.edge_table)
        across = np.full(3 * mesh.n_faces, -1)
        across[one], across[other] = other, one
        around = np.argsort(mesh.faces.ravel(), kind="stable")
        starts = np.searchsorted(mesh.faces.ravel()[around], np.arange(mesh.n_vertices + 1))
        edges = np.array(mesh.opposite_edges, order="C")
        corners = np.array(mesh.faces, dtype=np.int64, order="C")
        self._adjacency = (corners, edges, np.array(mesh.face_areas), across, around, starts)

    def seeds(self, count: int) -> FacePoints:
        """Return points that represent equal areas, the same ones every time; ArgumentError for a count below 1."""
        if count < 1:
            raise ArgumentError(f"there must be at least one tracer, not {count}")
        return FacePoints(*spread_samples(self.mesh, count))

    def positions(self, points: FacePoints) -> Floats:
        """Return the positions in space, (k, 3)."""
        return points_on(self.mesh, points.faces, points.weights)

    def flow(self, velocity: Floats) -> "FaceFlow":
        """Return a velocity, (m, 3), as the compiled loops take it; FieldError if it is not a finite face field."""
        V = tangential(self.mesh, velocity)
        rates = np.einsum("fkx,fx->fk", self._hats, V)
        return FaceFlow(*self._adjacency, np.array(V, order="C"), np.array(rates, order="C"))

    def advance(self, points: FacePoints, velocity: Floats, dt: float) -> FacePoints:
        """Return the points after a time dt of any length along a velocity.

        Parameters
        ----------
        velocity : (m, 3) array; its normal part is ignored.

        Raises
        ------
        ArgumentError
            If the velocity is not a finite face field, or dt is negative or not finite.
        ConvergenceError
            If a point crosses too many edges.
        """
        if not (dt >= 0 and math.isfinite(dt)):
            raise ArgumentError(f"tracers move for a finite time of zero or more, not for {dt}")
        flow = self.flow(velocity)
        faces, weights = points.faces.astype(np.int64), np.array(points.weights, order="C")
        if not _advance(flow, faces, weights, float(dt), MOST_CROSSINGS):
            raise ConvergenceError(
                f"tracers cross more than {MOST_CROSSINGS} edges in a step; take a shorter time step"
            )
        return FacePoints(faces, weights)


class FaceFlow(NamedTuple):
    """A face field on a mesh. Edges of faces are numbered 3f + k, opposite corner k, from corner k + 1 to k + 2.

    corners: (m, 3), vertices. edges: (m, 3, 3), vectors. areas: (m,). across: (3m,), the number of each edge in the
    other face, -1 at the boundary. around, starts: the corners 3f + k at each vertex, ascending, and where they start.
    V: (m, 3). rates: (m, 3), db_k/dt = V·∇φ_k of the barycentric coordinates b.
    """

    corners: Ints
    edges: Floats
    areas: Floats
    across: Ints
    around: Ints
    starts: Ints
    V: Floats
    rates: Floats


@compiled
def _advance(flow: FaceFlow, faces: Ints, weights: Floats, dt: float, most: int) -> bool:
    """Move points for a time dt, in place; false if one crosses more than the most edges."""
    for p in range(len(faces)):
        faces[p], finished = _advance_point(flow, faces[p], weights[p], dt, most)
        if not finished:
            return False
    return True


@compiled
def _advance_point(flow: FaceFlow, face: int, b: Floats, dt: float, most: int) -> tuple[int, bool]:
    """Move a point at b, in place, from edge to edge; its face, and whether the time is over.

    The loop keeps one edge that was crossed, the place on it, and the time since then. If the point returns to the
    place, whole turns are subtracted from the time that is left.
    """
    left, rates = dt, np.zeros(3)
    marked, place, since = -1, 0.0, 0.0
    for _ in range(most):
        if left == 0:
            return face, True
        face, crossed = enter_face(flow, face, b, rates)
        if crossed >= 0:
            at = b[(crossed + 1) % 3]
            closed = crossed == marked and abs(at - place) <= CLOSED * min(at, 1 - at)
            if closed:
                left = np.fmod(left, since)
            elif crossed == marked and max(b[0], b[1], b[2]) > 1 - CORE:
                left = 0.0
            if marked < 0 or (crossed == marked and not closed):
                marked, place, since = crossed, at, 0.0
        time, edge = np.inf, -1
        for k in range(3):
            if rates[k] < 0 and b[k] / -rates[k] < time:
                time, edge = b[k] / -rates[k], k
        step, total = min(time, left), 0.0
        for k in range(3):
            b[k] += step * rates[k]
            if b[k] < ON_EDGE or (k == edge and time < left):
                b[k] = 0.0
            total += b[k]
        for k in range(3):
            b[k] /= total
        left, since = left - step, since + step
    return face, False


@compiled
def enter_face(flow: FaceFlow, face: int, b: Floats, rates: Floats) -> tuple[int, int]:
    """Find the face in which a point on an edge or vertex continues, and set its coordinates and rates there.

    Returns the face, and the edge that was crossed, as the new face numbers it; -1 for none.
    """
    rates[0], rates[1], rates[2] = flow.rates[face]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        if b[i] == 0 and b[j] == 0:
            return _leave_vertex(flow, flow.corners[face, k], b, rates), -1
    for k in range(3):
        if b[k] == 0 and rates[k] < 0:
            if _slide(flow, 3 * face + k, rates):
                return face, -1
            i, j, other = (k + 1) % 3, (k + 2) % 3, flow.across[3 * face + k]
            beyond, first, second = other // 3, b[i], b[j]
            if flow.corners[face, i] != flow.corners[beyond, (other + 1) % 3]:
                first, second = second, first
            b[other % 3], b[(other + 1) % 3], b[(other + 2) % 3] = 0.0, first, second
            rates[0], rates[1], rates[2] = flow.rates[beyond]
            return beyond, other
    return face, -1


@compiled
def _slide(flow: FaceFlow, edge: int, rates: Floats) -> bool:
    """Set the rates along an edge that a point cannot cross, at the boundary or if the field beyond points back.

    Returns whether it is such an edge; otherwise the rates are unchanged [Filippov].
    """
    face, k, other = edge // 3, edge % 3, flow.across[edge]
    beyond, share = other // 3, 1.0
    if other >= 0:
        if flow.rates[beyond, other % 3] >= 0:
            return False
        # Speeds towards the edge, up to the factor 2/|e|.
        near = -flow.rates[face, k] * flow.areas[face]
        far = -flow.rates[beyond, other % 3] * flow.areas[beyond]
        share = far / (near + far) if near + far > 0 else 0.5
    along = square = 0.0
    for x in (0, 2, 1):  # the order in which numpy's einsum adds
        e = flow.edges[face, k, x]
        along += (share * flow.V[face, x] + (1 - share) * flow.V[beyond, x]) * e
        square += e * e
    rates[k], rates[(k + 1) % 3], rates[(k + 2) % 3] = 0.0, -along / square, along / square
    return True


@compiled
def _leave_vertex(flow: FaceFlow, vertex: int, b: Floats, rates: Floats) -> int:
    """Set coordinates and rates of a point at a vertex for the fastest way away, rates zero if there is none; its face.

    Ways are through a face, along the edge to its next corner, and along the edge to the corner after.
    """
    corners = flow.around[flow.starts[vertex] : flow.starts[vertex + 1]]
    fastest, start, trial = 0.0, corners[-1], np.zeros(3)
    for k in range(3):
        b[k] = rates[k] = 0.0
    for way in range(3):
        for corner in corners:
            face, k, i, j = corner // 3, corner % 3, (corner + 1) % 3, (corner + 2) % 3
            trial[0], trial[1], trial[2] = flow.rates[face]
            speed = _length(flow.V[face])
            if way:
                edge = 3 * face + (k + 3 - way) % 3
                if trial[edge % 3] >= 0 or not _slide(flow, edge, trial):
                    continue
                speed = -trial[k] * _length(flow.edges[face, edge % 3])
            if trial[k] < 0 and trial[i] >= 0 and trial[j] >= 0 and speed > fastest:
                fastest, start = speed, corner
                rates[0], rates[1], rates[2] = trial
    b[start % 3] = 1.0
    return start // 3


@compiled
def _length(vector: Floats) -> float:
    return math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
