"""Points from which something spreads, vertices or points within faces: checked once, here."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.nearest import nearest_on_surface
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Three barycentric coordinates rounded to two digits sum to one within this.
ROUNDED_SUM = 0.015
#: A barycentric coordinate below this is zero: the point lies on an edge or is a vertex.
SNAP = 1e-9


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """k points of a mesh, in the order in which they were given, by the barycentric weights of three corners.

    faces: (k,), the face that each lies in, -1 for a vertex.
    corners: (k, 3), the vertices of that face; of a vertex, three times itself.
    weights: (k, 3), not negative, sum 1; of a vertex 1, 0, 0.
    """

    faces: Ints
    corners: Ints
    weights: Floats

    def __len__(self) -> int:
        return len(self.faces)

    def __getitem__(self, which: Ints) -> "SurfacePoints":
        """Some of them, by their places or a mask."""
        return SurfacePoints(self.faces[which], self.corners[which], self.weights[which])

    @property
    def vertices(self) -> Ints:
        """Those that are vertices."""
        return np.asarray(self.corners[self.faces < 0, 0])

    @property
    def within_faces(self) -> "SurfacePoints":
        """Those that are none."""
        return self[self.faces >= 0]

    def positions(self, mesh: TriangleMesh) -> Floats:
        """Where they are, (k, 3)."""
        return np.asarray(np.einsum("kc,kcx->kx", self.weights, mesh.vertices[self.corners]))

    def impulse(self, n: int, values: Floats | float = 1.0) -> Floats:
        """Each one's value, (k,), shared by its corners, on n vertices: its integral against piecewise linear functions
        is the function's value at the point."""
        shares = self.weights * np.broadcast_to(values, len(self))[:, None]
        return np.asarray(np.bincount(self.corners.ravel(), shares.ravel(), n), dtype=float)

    def distinct(self) -> tuple[Ints, Ints]:
        """Places of the different ones, vertices first and ascending, and for each of all which of these it is.

        A point on an edge is the same in every face there.
        """
        used = self.weights > 0
        names = np.where(used, self.corners, -1)
        order = np.argsort(names, axis=1, kind="stable")
        sorted_weights = np.take_along_axis(self.weights, order, axis=1)
        keys = np.concatenate([np.take_along_axis(names, order, axis=1), np.round(sorted_weights, 12)], axis=1)
        ranked = np.lexsort((self.faces, *keys.T[::-1]))
        first = np.any(np.diff(keys[ranked], axis=0, prepend=np.nan) != 0, axis=1)
        group = np.empty(len(self), dtype=np.int64)
        group[ranked] = np.cumsum(first) - 1
        return ranked[first], group

    def report(self) -> list[Any]:
        """Plain values: the index of a vertex; of other points the face and the barycentric coordinates."""
        return [
            int(corners[0]) if face < 0 else {"face": int(face), "barycentric": weights.tolist()}
            for face, corners, weights in zip(self.faces, self.corners, self.weights, strict=True)
        ]

    def name(self, k: int) -> str:
        """The k-th in words."""
        return point_name(self[np.array([k])].report()[0])


def point_name(reported: Any) -> str:
    """A source as `SurfacePoints.report` has it, in words."""
    if isinstance(reported, int):
        return str(reported)
    return f"face {reported['face']} ({', '.join(f'{b:.6g}' for b in reported['barycentric'])})"


def concatenate(parts: Sequence[SurfacePoints]) -> SurfacePoints:
    """All of them, one after the other."""
    return SurfacePoints(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in ("faces", "corners", "weights"))
    )


def vertex_points(mesh: TriangleMesh, vertices: Sequence[int] | Ints) -> SurfacePoints:
    """Sources at vertices; FieldError if there is none or one is no vertex of the surface."""
    wanted = np.atleast_1d(np.asarray(vertices))
    if wanted.size == 0:
        raise FieldError("there is no source; name at least one vertex")
    if not np.issubdtype(wanted.dtype, np.integer):
        raise FieldError(f"a source is a vertex index, a whole number, not {wanted.flat[0]}")
    if (outside := (wanted < 0) | (wanted >= mesh.n_vertices)).any():
        bad = wanted[outside][0]
        raise FieldError(f"source {bad} is not a vertex: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})")
    if (loose := np.isin(wanted, mesh.unreferenced_vertices)).any():
        raise FieldError(f"source {wanted[loose][0]} belongs to no face; choose a vertex on the surface")
    k = len(wanted)
    return SurfacePoints(np.full(k, -1), np.repeat(wanted[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (k, 1)))


def vertex_range(mesh: TriangleMesh, first: int, last: int) -> SurfacePoints:
    """Sources at the vertices from one to another, both included."""
    vertex_points(mesh, [first, last])  # before a range of any length is laid out
    return vertex_points(mesh, np.arange(first, last + 1))


def face_point(mesh: TriangleMesh, face: int, weights: ArrayLike | None = None) -> SurfacePoints:
    """A source within a face, by default at its barycenter.

    weights: barycentric coordinates, (3,), in the order of the face's corners. They are divided by their sum, which
    rounding to two digits may take off one; FieldError if it is farther off or one is negative.
    """
    if not 0 <= face < mesh.n_faces:
        raise FieldError(f"face {face} does not exist: the mesh has {mesh.n_faces} faces (0 to {mesh.n_faces - 1})")
    b = np.full(3, 1 / 3) if weights is None else np.asarray(weights, dtype=float)
    given = ", ".join(f"{x:g}" for x in b.ravel())
    if b.shape != (3,) or not np.isfinite(b).all():
        raise FieldError(f"a point in face {face} has three barycentric coordinates, not {given}")
    if (b < 0).any():
        raise FieldError(f"barycentric coordinates {given} lie outside of face {face}; none may be negative")
    if abs(b.sum() - 1) > ROUNDED_SUM:
        raise FieldError(f"barycentric coordinates {given} in face {face} sum to {b.sum():g}; they must sum to 1")
    b = np.where(b < SNAP, 0.0, b)
    corners = mesh.faces[face].astype(np.int64)
    if np.count_nonzero(b) == 1:
        return vertex_points(mesh, corners[b > 0])
    return SurfacePoints(np.array([face]), corners[None], b[None] / b.sum())


def boundary_points(mesh: TriangleMesh) -> SurfacePoints:
    """Sources at all vertices of the boundary; FieldError if there is none."""
    if mesh.is_closed:
        raise FieldError("the mesh has no boundary; name vertices or faces as sources")
    return vertex_points(mesh, mesh.boundary_vertices)


def nearest_point(mesh: TriangleMesh, point: ArrayLike) -> SurfacePoints:
    """A source at the point of the surface nearest to a point in space, (3,): a vertex only if it is that point."""
    place = np.asarray(point, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise FieldError(f"a point in space has three finite coordinates, not {place.tolist()}")
    return face_point(mesh, *nearest_on_surface(mesh, place))


def extreme_vertex(mesh: TriangleMesh, axis: int, sign: int) -> int:
    """The vertex of largest (sign 1) or smallest (-1) x, y or z that belongs to a face, the lowest index on a tie."""
    height = sign * mesh.vertices[:, axis]
    height[mesh.unreferenced_vertices] = -np.inf
    return int(height.argmax())


def default_source(mesh: TriangleMesh) -> int:
    """The vertex of largest y."""
    return extreme_vertex(mesh, 1, 1)
