"""Directions at a vertex: the faces around it side by side in the plane, and angles in them."""

from dataclasses import dataclass
from math import pi

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import ArgumentError, FieldError
from geomhw.geodesic.unfolded_faces import Surface, angle, ends, next_corner


@dataclass(frozen=True)
class VertexFan:
    """The faces around a vertex that share edges there, counterclockwise as seen from the side of its first face.

    vertex: the center. corners: halfedge opposite the vertex in each face. sides: halfedge at which each face begins.
    begins: angle of that edge, 0 at the first edge of the first face. total: angle of all. closed: whether the fan
    has no boundary. complete: whether it has all faces of the vertex and no edge of more than two faces.
    """

    vertex: int
    corners: list[int]
    sides: list[int]
    begins: list[float]
    total: float
    closed: bool
    complete: bool

    @property
    def scale(self) -> float:
        """Degrees of the tangent plane per radian of the faces: closed fans are scaled to a full turn."""
        return 360 / self.total if self.closed else 180 / pi

    def require_angles(self) -> None:
        """Raise FieldError if all faces have zero area, and ArgumentError if the vertex is not manifold."""
        if self.total == 0:
            raise FieldError(f"the faces at vertex {self.vertex} have zero area, so no directions")
        if not self.complete:
            raise ArgumentError(f"vertex {self.vertex} is not manifold, so directions there have no angles")

    def direction(self, surface: Surface, degrees: float) -> tuple[int, Floats] | None:
        """Return the face and the unit vector, (3,), in it at an angle; None if the angle is outside of an open fan."""
        first, end = self.begins[0], self.begins[0] + self.total
        turn = self.total if self.closed else 2 * pi
        a = first + (degrees / self.scale - first) % turn
        if a > end:
            if a - turn < first - 1e-12 and a > end + 1e-12:
                return None
            a = end if a - end < 1e-12 else first
        k = max(int(np.searchsorted(self.begins, a, side="right")) - 1, 0)
        return self.corners[k] // 3, self._vector(surface, k, a - self.begins[k])

    def first_ends(self, surface: Surface) -> list[int]:
        """Return the far end of the edge at which each face begins."""
        return [sum(ends(surface, side)) - self.vertex for side in self.sides]

    def angle_of(self, surface: Surface, face: int, vector: Floats) -> float:
        """Return the angle of a vector, (3,), in the plane of a face, radians of the faces."""
        k = next(k for k, corner in enumerate(self.corners) if corner // 3 == face)
        along = surface.points[self.first_ends(surface)[k]] - surface.points[self.vertex]
        return self.begins[k] + float(np.arctan2(np.linalg.norm(np.cross(along, vector)), along @ vector))

    def _vector(self, surface: Surface, k: int, inner: float) -> Floats:
        """Return the unit vector in face k at an angle from the edge where it begins."""
        names, v = surface.faces[self.corners[k] // 3].tolist(), self.vertex
        one = sum(ends(surface, self.sides[k])) - v
        (other,) = set(names) - {v, one}
        along, across = surface.points[one] - surface.points[v], surface.points[other] - surface.points[v]
        along = along / max(np.linalg.norm(along), np.finfo(float).tiny)
        across = across - (across @ along) * along
        across = across / max(np.linalg.norm(across), np.finfo(float).tiny)
        return np.asarray(np.cos(inner) * along + np.sin(inner) * across)


def vertex_fan(surface: Surface, v: int) -> VertexFan:
    """Return the fan of the first face of a vertex."""
    first = int(surface.corners[surface.starts[v]])
    f, k = divmod(first, 3)
    # The edge to the next corner is opposite the corner after that.
    begin, end = 3 * f + (k + 2) % 3, 3 * f + (k + 1) % 3
    count = int(surface.starts[v + 1] - surface.starts[v])
    corners, sides, begins = [first], [begin], [0.0]
    total, manifold, closed = angle(surface, first), True, False
    side = end
    while len(corners) <= count:
        g = int(surface.across[side])
        if g == side or surface.sides[side] > 2:
            manifold = manifold and g == side
            break
        corner, other = next_corner(surface, v, side)
        if corner == first:
            closed = True
            break
        corners.append(corner)
        sides.append(g)
        begins.append(total)
        total += angle(surface, corner)
        side = other
    side, start = begin, 0.0
    while not closed and len(corners) <= count:
        g = int(surface.across[side])
        if g == side or surface.sides[side] > 2:
            manifold = manifold and g == side
            break
        corner, side = next_corner(surface, v, side)
        start -= angle(surface, corner)
        corners.insert(0, corner)
        sides.insert(0, side)
        begins.insert(0, start)
    return VertexFan(v, corners, sides, begins, total - start, closed, manifold and len(corners) == count)
