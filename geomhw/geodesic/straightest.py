"""Straightest geodesics: straight across edges, and with equal angles on both sides through vertices.

Polthier, Schmies: Straightest Geodesics on Polyhedral Surfaces. Mathematical Visualization, 1998.
"""

from collections.abc import Sequence
from math import acos, atan2, cos, inf, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.straight_lines import apex_side, cross_face
from geomhw.geodesic.surface_path import SurfacePath
from geomhw.geodesic.unfolded_faces import Surface, angle, ends, next_corner, triangle
from geomhw.geodesic.vertex_fans import VertexFan, vertex_fan
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: A line passes through a vertex if it is nearer, as a share of the edge.
AT_VERTEX = 1e-10
#: Results of a walk: more room is needed, or the line ends by its length, at the boundary, or where it may branch.
FULL, LENGTH, BOUNDARY, BRANCH = range(4)
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
        self._surface = ExactDistance(mesh).surface

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
        for corner in fan.corners:
            f, k = divmod(corner, 3)
            a, b = (
                self.mesh.vertices[self.mesh.faces[f, (k + i) % 3]] - self.mesh.vertices[fan.vertex] for i in (1, 2)
            )
            share = np.linalg.lstsq(np.stack([a, b, normal], axis=1), given, rcond=None)[0][:2]
            if (share >= -1e-12 * np.abs(share).max()).all() and share.max() > 0:
                inside = np.maximum(share, 0) @ [a, b]
                return self._line(f, np.eye(3)[k], inside / np.linalg.norm(inside), length)
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
        found = fan.direction(self._surface, degrees)
        if found is None:
            raise ArgumentError(f"the direction at {degrees:g} degrees from {source.name(0)} points off the surface")
        face, vector = found
        return self._line(face, (self.mesh.faces[face] == fan.vertex).astype(float), vector, length)

    def fan(self, source: SurfacePoints, degrees: Sequence[float], length: float) -> list[SurfacePath]:
        """Return the lines at several angles, as `trace_angle` does, without those that point off the surface."""
        if source.faces[0] < 0:
            fan = self._fan(source)
            degrees = [d for d in degrees if fan.direction(self._surface, d)]
        return [self.trace_angle(source, d, length) for d in degrees]

    def _start(self, source: SurfacePoints, length: float) -> tuple[int, Floats]:
        """Check the arguments of a line, and return its first face and barycentric coordinates."""
        if len(source) != 1:
            raise ArgumentError(f"a line starts from one point, not {len(source)}")
        if not 0 <= length < inf:
            raise ArgumentError(f"the length of a line is finite and at least 0, not {length}")
        if (face := int(source.faces[0])) in self.mesh.degenerate_faces:
            raise FieldError(f"face {face} has zero area, so no direction; start at one of its corners")
        return face, source.weights[0]

    def _fan(self, source: SurfacePoints) -> VertexFan:
        """Return the fan of a vertex."""
        fan = vertex_fan(self._surface, int(source.vertices[0]))
        if not fan.complete:
            raise ArgumentError(f"vertex {fan.vertex} is not manifold, so directions there have no angles")
        return fan

    def _line(self, face: int, weights: Floats, vector: Floats, length: float) -> SurfacePath:
        """Return the line from a point of a face along a unit vector in the plane of the face."""
        surface, room = self._surface, 256
        begin = _first_exit(self.mesh, face, weights, vector)
        if begin is None:  # the point is on an edge, and the line goes to its other side
            across = self._other_side(face, weights, vector)
            if across is None:
                return SurfacePath(self.mesh, np.array([face]), weights[None], "boundary")
            return self._line(*across, length)
        side, place, along, distance = begin
        while True:
            faces, points = np.empty(room, dtype=np.int64), np.zeros((room, 3))
            points[0] = weights
            count, reason = walk(surface, side, place, along, distance, length, faces, points)
            if reason != FULL:
                return SurfacePath(self.mesh, faces[:count], points[:count], REASONS[reason])
            if room > MOST_CROSSINGS:
                raise FieldError(f"the line crosses more than {MOST_CROSSINGS} edges; give a shorter length")
            room *= 4

    def _other_side(self, face: int, weights: Floats, vector: Floats) -> tuple[int, Floats, Floats] | None:
        """Return a point on an edge and a direction from there in the face across; None on the boundary."""
        surface, side = self._surface, 3 * face + int(np.argmin(weights))
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


@compiled_in_place
def walk(
    surface: Surface, h: int, t: float, c: float, distance: float, length: float, faces: Ints, points: Floats
) -> tuple[int, int]:
    """Trace a line that leaves its first face over halfedge h, at the place t and in the direction c along h.

    distance: from the start to there. faces, points: take the points of the line, with the start in ``points[0]``.
    Return their number and why the line ends.
    """
    left, count = length, 1
    faces[0] = h // 3
    s = (1 - c * c) ** 0.5 if abs(c) < 1 else 0.0
    while True:
        # A segment in the face of h, from the last point to the place t on h.
        if count + 2 > len(points):
            return count, FULL
        face = triangle(surface, h)
        f = h // 3
        share = min(t / face.base, 1.0) if face.base > 0 else 0.0
        share = 0.0 if share < AT_VERTEX else 1.0 if share > 1 - AT_VERTEX else share
        part = left / distance if distance > left else 1.0
        for k in range(3):
            v = surface.faces[f, k]
            end = 1 - share if v == face.low else share if v == face.high else 0.0
            points[count, k] = end if part == 1 else (1 - part) * points[count - 1, k] + part * end
        faces[count] = f
        count += 1
        left -= distance
        if left <= 0:
            return count, LENGTH
        if share == 0 or share == 1:
            v = face.low if share == 0 else face.high
            side, inner = _through_vertex(surface, h, v, acos(min(max(-c if share == 0 else c, -1.0), 1.0)))
            if side < 0:
                return count, BOUNDARY if side == -1 else BRANCH
            h, t, c, s, distance = _from_vertex(surface, side, v, inner)
            f = h // 3
        else:
            if surface.sides[h] != 2:
                return count, BOUNDARY if surface.sides[h] == 1 else BRANCH
            g = np.int64(surface.across[h])
            f = g // 3
            ahead = triangle(surface, g)
            h, t, c, s, distance = cross_face(ahead, t, c, s, apex_side(ahead, t, c, s) > 0)
        # The point just passed, in the face that follows.
        for k in range(3):
            points[count - 1, k] = 0.0
        if share == 0 or share == 1:
            for k in range(3):
                points[count - 1, k] = 1.0 if surface.faces[f, k] == v else 0.0
        else:
            for k in range(3):
                u = surface.faces[f, k]
                points[count - 1, k] = 1 - share if u == face.low else share if u == face.high else 0.0
        faces[count - 1] = f


@compiled_in_place
def _through_vertex(surface: Surface, h: int, v: int, back: float) -> tuple[int, float]:
    """Continue a line through a vertex v at the end of halfedge h, with half of the total angle on each side.

    back: angle between h and the line by which it comes, in the face of h. Return the halfedge at which the face of the
    outgoing line begins, and the angle from there; -1 at the boundary, -2 where more than two faces meet.
    """
    count, total = 0, 0.0
    side, end = np.int64(h), np.int64(surface.starts[v + 1] - surface.starts[v])
    while True:
        if surface.sides[side] != 2:
            return (-1 if surface.sides[side] == 1 else -2), 0.0
        corner, other = next_corner(surface, v, side)
        total += angle(surface, corner)
        count += 1
        side = other
        if other // 3 == h // 3 or count > end:
            break
    if count != end:
        return -2, 0.0
    rest = total / 2 - back
    if rest < 0:
        return np.int64(h), -rest
    side = np.int64(h)
    for _ in range(count):
        into = np.int64(surface.across[side])
        corner, other = next_corner(surface, v, side)
        a = angle(surface, corner)
        if rest <= a:
            return into, rest
        rest -= a
        side = other
    return np.int64(h), 0.0


@compiled_in_place
def _from_vertex(surface: Surface, side: int, v: int, inner: float) -> tuple[int, float, float, float, float]:
    """Start a line at a vertex v into the face of a halfedge ``side`` at v, at an angle from it.

    Return the halfedge over which it leaves the face, the place, its direction there, and the distance.
    """
    f = side // 3
    h = 3 * f
    while surface.faces[h // 3, h % 3] != v:
        h += 1
    face = triangle(surface, h)
    low, high = ends(surface, side)
    x, y = face.left * face.cos_low, face.left * face.sin_low
    # The direction to the lower end of h, turned toward the higher end.
    turned = inner if face.low == low + high - v else angle(surface, h) - inner
    lead = pi + atan2(y, x) + turned
    c, s = cos(lead), -sin(lead)
    if s <= 0:
        return (h, 0.0, c, 0.0, face.left) if turned < angle(surface, h) / 2 else (h, face.base, c, 0.0, face.right)
    distance = y / s
    t = min(max(x + c * distance, 0.0), face.base)
    return h, t, c, s, distance
