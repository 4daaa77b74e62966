"""Straightest geodesics: straight across edges, and with equal angles on both sides through vertices.

Polthier, Schmies: Straightest Geodesics on Polyhedral Surfaces. Mathematical Visualization, 1998.
"""

from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.straightest_walk import BOUNDARY, BRANCH, FULL, LENGTH, walk
from geomhw.geodesic.surface_path import SurfacePath
from geomhw.geodesic.unfolded_faces import ends
from geomhw.geodesic.vertex_fans import VertexFan, vertex_fan
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Why a line ends before its length.
REASONS = {LENGTH: "", BOUNDARY: "boundary", BRANCH: "non-manifold edge"}
#: Most edges that a line crosses.
MOST_CROSSINGS = 1 << 22


class StraightestGeodesics:
    """Straightest geodesics on one mesh: the exponential map of a polyhedral surface.

    Parameters
    ----------
    mesh : any triangle mesh. Lines end at the boundary and at edges of more than two faces.

    Examples
    --------
    >>> from geomhw.mesh import grid, vertex_points
    >>> flat = grid(4, 4)
    >>> path = StraightestGeodesics(flat).trace(vertex_points(flat, [12]), [1, 0.5, 0], 0.25)
    >>> path.positions[-1].round(6).tolist()
    [0.723607, 0.611803, 0.0]
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self.surface = ExactDistance(mesh).surface

    def trace(self, source: SurfacePoints, vector: ArrayLike, length: float) -> SurfacePath:
        """Return the line of a length from a point in the direction of a vector, (3,).

        The tangential part of the vector gives the direction. At a vertex, it is the direction in a face that the
        projection along the vertex normal maps to that of the vector, so that lines along edges and in faces keep
        their direction.

        Raises
        ------
        ArgumentError
            If there is not one point, the length is negative or infinite, the vector is normal to the surface or points
            off its boundary, or the vertex has edges of more than two faces.
        FieldError
            If the face of the point has zero area.
        """
        face, weights = self._start(source, length)
        given = np.asarray(vector, dtype=float)
        if given.shape != (3,) or not np.isfinite(given).all() or not given.any():
            raise ArgumentError("a direction is a vector of three finite components, not all zero")
        given = given / np.abs(given).max()  # its square may overflow or underflow
        given = given / np.linalg.norm(given)
        if source.faces[0] >= 0:
            normal = self.mesh.face_normals[face]
            tangent = given - (given @ normal) * normal
            if np.linalg.norm(tangent) < 1e-6:
                raise ArgumentError(f"the vector at {source.name(0)} is normal to the surface")
            return self._line(face, weights, tangent / np.linalg.norm(tangent), length)
        fan = self._fan(source)
        normal = self.mesh.vertex_normals[fan.vertex]
        if np.linalg.norm(np.cross(normal, given)) < 1e-6:
            raise ArgumentError(f"the vector at {source.name(0)} is normal to the surface")
        # Where faces lie over each other, several have the direction: the nearest, then that farthest from its edges.
        found = []
        for corner in fan.corners:
            f, k = divmod(corner, 3)
            edges = [
                self.mesh.vertices[self.mesh.faces[f, (k + i) % 3]] - self.mesh.vertices[fan.vertex] for i in (1, 2)
            ]
            a, b = (edge / max(np.linalg.norm(edge), np.finfo(float).tiny) for edge in edges)  # of any scale
            share = np.linalg.lstsq(np.stack([a, b, normal], axis=1), given, rcond=None)[0][:2]
            if (share >= -1e-12 * np.abs(share).max()).all() and share.max() > 0:
                inside = np.maximum(share, 0) @ [a, b]
                inside = inside / np.linalg.norm(inside)
                found.append(((round(float(inside @ given), 9), share.min() / share.max()), f, k, inside))
        if found:
            _, f, k, inside = max(found, key=lambda each: each[0])
            return self._line(f, np.eye(3)[k], inside, length)
        raise ArgumentError(f"the vector at {source.name(0)} points off the surface")

    def trace_angle(self, source: SurfacePoints, degrees: float, length: float) -> SurfacePath:
        """Return the line of a length from a point at an angle, counterclockwise.

        The angle is measured from the first edge of the vertex's first face, or of the face that contains the point.
        Angles around an inner vertex are scaled to sum to 360 degrees. Raises as `trace` does.
        """
        face, weights = self._start(source, length)
        if not np.isfinite(degrees):
            raise ArgumentError(f"an angle is a finite number of degrees, not {degrees}")
        if source.faces[0] >= 0:
            a, b, _ = self.mesh.vertices[self.mesh.faces[face]]
            along = (b - a) / np.linalg.norm(b - a)
            across = np.cross(self.mesh.face_normals[face], along)
            turned = np.radians(degrees)
            return self._line(face, weights, np.cos(turned) * along + np.sin(turned) * across, length)
        fan = self._fan(source)
        found = fan.direction(self.surface, degrees)
        if found is None:
            raise ArgumentError(f"the direction at {degrees:g} degrees from {source.name(0)} points off the surface")
        face, vector = found
        return self._line(face, (self.mesh.faces[face] == fan.vertex).astype(float), vector, length)

    def from_corner(self, corner: int, vector: Floats, length: float) -> SurfacePath:
        """Return the line from a corner 3f + k of a face, in the direction of a vector within the face.

        Raises ArgumentError if the vector has no direction.
        """
        size = np.linalg.norm(vector)
        if not size > 0:
            raise ArgumentError("a direction is a vector of three finite components, not all zero")
        return self._line(corner // 3, np.eye(3)[corner % 3], vector / size, length)

    def fan(self, source: SurfacePoints, degrees: Sequence[float], length: float) -> list[SurfacePath]:
        """Return the lines at several angles, as `trace_angle` does, without those that point off the surface."""
        if source.faces[0] < 0:
            fan = self._fan(source)
            degrees = [d for d in degrees if fan.direction(self.surface, d)]
        return [self.trace_angle(source, d, length) for d in degrees]

    def _start(self, source: SurfacePoints, length: float) -> tuple[int, Floats]:
        """Check the arguments of a line, and return its first face and barycentric coordinates."""
        if len(source) != 1:
            raise ArgumentError(f"a line starts from one point, not {len(source)}")
        if not 0 <= length < inf:
            raise ArgumentError(f"the length of a line is finite and at least 0, not {length}")
        return self._with_area(int(source.faces[0])), source.weights[0]

    def _with_area(self, face: int) -> int:
        """Return a face, unless it has zero area; -1 for a vertex."""
        if face in self.mesh.degenerate_faces:
            raise FieldError(f"face {face}, into which the line starts, has zero area, so no directions")
        return face

    def _fan(self, source: SurfacePoints) -> VertexFan:
        """Return the fan of a vertex."""
        fan = vertex_fan(self.surface, int(source.vertices[0]))
        fan.require_angles()
        return fan

    def _line(self, face: int, weights: Floats, vector: Floats, length: float) -> SurfacePath:
        """Return the line from a point of a face along a unit vector in the plane of the face."""
        surface, room = self.surface, 256
        begin = _first_exit(self.mesh, self._with_area(face), weights, vector)
        if begin is None:  # the point is on an edge, and the line goes to its other side
            across = self._other_side(face, weights, vector)
            if across is None:
                return SurfacePath(self.mesh, np.array([face]), weights[None], stop="boundary")
            return self._line(*across, length)
        side, place, along, distance = begin
        while True:
            faces, points = np.empty(room, dtype=np.int64), np.zeros((room, 3))
            points[0] = weights
            count, reason = walk(surface, side, place, along, distance, length, faces, points)
            if reason != FULL:
                return SurfacePath(self.mesh, faces[:count], points[:count], stop=REASONS[reason])
            if room > MOST_CROSSINGS:
                raise ArgumentError(f"the line crosses more than {MOST_CROSSINGS} edges; give a shorter length")
            room *= 4

    def _other_side(self, face: int, weights: Floats, vector: Floats) -> tuple[int, Floats, Floats] | None:
        """Return a point on an edge and a direction from there in the face across; None on the boundary."""
        surface, side = self.surface, 3 * face + int(np.argmin(weights))
        other = int(surface.across[side])
        if surface.sides[side] != 2:
            return None
        low, high = ends(surface, side)
        g, k = divmod(other, 3)
        edge = surface.points[high] - surface.points[low]
        edge = edge / np.linalg.norm(edge)
        up = surface.points[surface.faces[g, k]] - surface.points[low]
        up = up - (up @ edge) * edge
        along = float(vector @ edge)
        turned = along * edge + np.sqrt(max(1 - along * along, 0.0)) * up / np.linalg.norm(up)
        moved = np.array([weights[surface.faces[face] == v].sum() for v in surface.faces[g]])
        return g, moved, turned


def _first_exit(
    mesh: TriangleMesh, face: int, weights: Floats, vector: Floats
) -> tuple[int, float, float, float] | None:
    """Return where a line from a point in a face leaves it: halfedge, place, direction along it, and distance.

    None if the line does not enter the face.
    """
    heights = np.cross(mesh.face_normals[face], mesh.opposite_edges[face]) / (2 * mesh.face_areas[face])
    rates = heights @ vector
    rates[np.abs(rates) * np.sqrt(mesh.face_areas[face]) < 1e-14] = 0.0
    if (rates[weights == 0] < 0).any():
        return None
    times = np.divide(-weights, rates, out=np.full(3, inf), where=rates < 0)
    k = int(times.argmin())
    at = weights + times[k] * rates
    i, j = sorted(((k + 1) % 3, (k + 2) % 3), key=lambda c: int(mesh.faces[face, c]))
    edge = mesh.vertices[mesh.faces[face, j]] - mesh.vertices[mesh.faces[face, i]]
    base = float(np.linalg.norm(edge))
    return 3 * face + k, float(np.clip(at[j], 0, 1)) * base, float(vector @ edge) / base, float(times[k])
