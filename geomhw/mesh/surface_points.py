"""Points on a surface in barycentric coordinates: vertices, points in faces, closest points, with input checks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Largest deviation from 1 of the sum of three barycentric coordinates: they may be rounded to two digits.
ROUNDED_SUM = 0.015
#: A barycentric coordinate below this is set to zero: the point lies on an edge or is a vertex.
SNAP = 1e-9


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """k points on a mesh, in the order in which they were given.

    `vertex_points`, `vertex_range`, `face_point`, `nearest_point` and `boundary_points` make them and check their
    arguments; `concatenate` joins them.

    Attributes
    ----------
    faces : (k,) integer array
        The face that contains each point; -1 for a vertex.
    corners : (k, 3) integer array
        The vertices of that face; three times the same vertex for a vertex.
    weights : (k, 3) array
        Barycentric coordinates with respect to ``corners``: nonnegative, sum 1; (1, 0, 0) for a vertex.
    filled : (k,) bool array
        Whether each point is a vertex of a filled region, which contains all edges and faces between its vertices. By
        default none is.
    segments : (s, 3) integer array
        Segments between points that belong to them: two indices of points and a face that contains both. By default
        there are none.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> points = concatenate([vertex_points(grid(2, 2), [4]), face_point(grid(2, 2), 0)])
    >>> len(points), points.faces.tolist()
    (2, [-1, 0])
    """

    faces: Ints
    corners: Ints
    weights: Floats
    filled: Any = None
    segments: Any = None

    def __post_init__(self) -> None:
        if self.segments is None:
            object.__setattr__(self, "segments", np.empty((0, 3), dtype=np.int64))
        if self.filled is None:
            object.__setattr__(self, "filled", np.zeros(len(self.faces), dtype=bool))

    def __len__(self) -> int:
        return len(self.faces)

    def __getitem__(self, which: Ints) -> "SurfacePoints":
        """Select points by an index array or a mask, with the segments between them."""
        segments = self.segments
        if len(segments):
            place = np.full(len(self), -1)
            chosen = np.arange(len(self))[which]
            place[chosen] = np.arange(len(chosen))
            ends = place[segments[:, :2]]
            segments = np.column_stack([ends, segments[:, 2]])[(ends >= 0).all(axis=1)]
        return SurfacePoints(self.faces[which], self.corners[which], self.weights[which], self.filled[which], segments)

    def unique(self) -> "SurfacePoints":
        """Return each of equal points once, with all segments of positive length."""
        first, group = self.distinct()
        found, segments = self[first], self.segments
        if len(segments):
            ends = group[segments[:, :2]]
            segments = np.column_stack([ends, segments[:, 2]])[ends[:, 0] != ends[:, 1]]
        return replace(found, segments=segments)

    def split(self) -> list["SurfacePoints"]:
        """Return each point on its own."""
        return [self[np.array([k])] for k in range(len(self))]

    @property
    def vertices(self) -> Ints:
        """Vertex indices of the points that are vertices."""
        return np.asarray(self.corners[self.faces < 0, 0])

    @property
    def filled_vertices(self) -> Ints:
        """Vertex indices of the points that belong to filled regions."""
        return self[self.filled].vertices

    @property
    def within_faces(self) -> "SurfacePoints":
        """The points that are not vertices."""
        return self[self.faces >= 0]

    def positions(self, mesh: TriangleMesh) -> Floats:
        """Return the coordinates of the points, (k, 3)."""
        return np.asarray(np.einsum("kc,kcx->kx", self.weights, mesh.vertices[self.corners]))

    def corner_weights(self) -> list[dict[int, float]]:
        """Return the barycentric coordinates of each point that are not zero, by vertex."""
        rows = zip(self.corners.tolist(), self.weights.tolist(), strict=True)
        return [{v: w for v, w in zip(corners, weights, strict=True) if w > 0} for corners, weights in rows]

    def groups(self) -> Ints:
        """Return the number of the curve or point that each point belongs to, (k,); segments join points to curves."""
        from geomhw.mesh.topology import linked_components

        return linked_components(self.segments[:, 0], self.segments[:, 1], len(self))

    def impulse(self, n: int, values: Floats | float = 1.0) -> Floats:
        """Distribute values, (k,), to the corners of their faces: the load vector, (n,), of a sum of Dirac impulses.

        The product with a vector of vertex values is the sum of the interpolated values at the points, times
        ``values``.
        """
        shares = self.weights * np.broadcast_to(values, len(self))[:, None]
        return np.asarray(np.bincount(self.corners.ravel(), shares.ravel(), n), dtype=float)

    def distinct(self) -> tuple[Ints, Ints]:
        """Find equal points; a point on an edge is the same in all faces at that edge.

        Returns
        -------
        first : (d,) integer array
            Index of one point of each group of equal points: vertices first, ascending.
        group : (k,) integer array
            Group of each point, an index into ``first``.
        """
        if (self.faces < 0).all() and self.filled.all() == self.filled.any():  # in less memory
            _, alone, ranks = np.unique(self.corners[:, 0], return_index=True, return_inverse=True)
            return alone, ranks.ravel()
        used = self.weights > 0
        names = np.where(used, self.corners, -1)
        order = np.argsort(names, axis=1, kind="stable")
        sorted_weights = np.take_along_axis(self.weights, order, axis=1)
        keys = np.concatenate([np.take_along_axis(names, order, axis=1), np.round(sorted_weights, 12)], axis=1)
        ranked = np.lexsort((~self.filled, self.faces, *keys.T[::-1]))
        first = np.any(np.diff(keys[ranked], axis=0, prepend=np.nan) != 0, axis=1)
        group = np.empty(len(self), dtype=np.int64)
        group[ranked] = np.cumsum(first) - 1
        return ranked[first], group

    def report(self) -> list[Any]:
        """Return the points as plain JSON values: a vertex index, or a face with barycentric coordinates.

        Points that segments join are one entry, a curve with its number of points.
        """
        if len(self.segments):
            first, sizes = np.unique(self.groups(), return_index=True, return_counts=True)[1:]
            alone = self[first].report()
            return [name if size == 1 else {"curve": int(size)} for name, size in zip(alone, sizes, strict=True)]
        return [
            int(corners[0]) if face < 0 else {"face": int(face), "barycentric": weights.tolist()}
            for face, corners, weights in zip(self.faces, self.corners, self.weights, strict=True)
        ]

    def name(self, k: int) -> str:
        """Return the k-th point as text, for messages."""
        return point_name(self[np.array([k])].report()[0])


def point_name(reported: Any) -> str:
    """Return an entry of `SurfacePoints.report` as text."""
    if isinstance(reported, int):
        return str(reported)
    if "curve" in reported:
        return f"curve of {reported['curve']} points"
    return f"face {reported['face']} ({', '.join(f'{b:.6g}' for b in reported['barycentric'])})"


def concatenate(parts: Sequence[SurfacePoints]) -> SurfacePoints:
    """Join several sets of points into one, in order.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> concatenate([vertex_points(grid(2, 2), [4]), vertex_points(grid(2, 2), [0, 1])]).vertices.tolist()
    [4, 0, 1]
    """
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0, *map(len, parts)])
    segments = [part.segments + np.array([start, start, 0]) for part, start in zip(parts, starts, strict=False)]
    names = ("faces", "corners", "weights", "filled")
    faces, corners, weights, filled = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
    return SurfacePoints(faces, corners, weights, filled, np.concatenate(segments))


def vertex_points(mesh: TriangleMesh, vertices: Sequence[int] | Ints) -> SurfacePoints:
    """Select vertices of a mesh as surface points.

    Parameters
    ----------
    mesh : TriangleMesh
    vertices : sequence of k vertex indices, at least one.

    Raises
    ------
    ArgumentError
        If there is no index, or one is not an integer, out of range or an unreferenced vertex.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> vertex_points(grid(2, 2), [3, 1]).report()
    [3, 1]
    """
    wanted = np.atleast_1d(np.asarray(vertices))
    if wanted.size == 0:
        raise ArgumentError("there is no source; name at least one vertex")
    if not np.issubdtype(wanted.dtype, np.integer):
        raise ArgumentError(f"a source is a vertex index, a whole number, not {wanted.flat[0]}")
    if (outside := (wanted < 0) | (wanted >= mesh.n_vertices)).any():
        bad = wanted[outside][0]
        raise ArgumentError(
            f"source {bad} is not a vertex: the mesh has {mesh.n_vertices} (0 to {mesh.n_vertices - 1})"
        )
    if (loose := np.isin(wanted, mesh.unreferenced_vertices)).any():
        raise ArgumentError(f"source {wanted[loose][0]} belongs to no face; choose a vertex on the surface")
    k = len(wanted)
    return SurfacePoints(np.full(k, -1), np.repeat(wanted[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (k, 1)))


def region_points(mesh: TriangleMesh, vertices: Sequence[int] | Ints) -> SurfacePoints:
    """Select a filled region: vertices, with all edges and faces between them; raises as `vertex_points` does.

    Exact distances are from the edges and faces, too; distances by the heat method from the vertices.

    Examples
    --------
    >>> from geomhw.geodesic import ExactDistance
    >>> from geomhw.mesh import TriangleMesh
    >>> mesh = TriangleMesh([[0, 0, 0], [2, 0, 0], [1, 3, 0]], [[0, 1, 2]])
    >>> ExactDistance(mesh).from_sources(region_points(mesh, [0, 1]))["distance"].tolist()
    [0.0, 0.0, 3.0]
    """
    return replace(vertex_points(mesh, vertices), filled=np.ones(len(np.atleast_1d(vertices)), dtype=bool))


def vertex_range(mesh: TriangleMesh, first: int, last: int) -> SurfacePoints:
    """Select the vertices ``first`` to ``last``, both included; raises as `vertex_points` does.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> vertex_range(grid(2, 2), 2, 4).vertices.tolist()
    [2, 3, 4]
    """
    vertex_points(mesh, [first, last])  # checks the ends before a range of any size is allocated
    return vertex_points(mesh, np.arange(first, last + 1))


def face_point(mesh: TriangleMesh, face: int, weights: ArrayLike | None = None) -> SurfacePoints:
    """Select a point in a face by barycentric coordinates.

    Parameters
    ----------
    mesh : TriangleMesh
    face : int
        Index of the face.
    weights : (3,) array, optional
        Barycentric coordinates in the order of the corners, nonnegative. They are divided by their sum, which must be
        within 0.015 of 1. By default the barycenter. Coordinates below 1e-9 become 0; (1, 0, 0) gives a vertex.

    Raises
    ------
    ArgumentError
        If the face does not exist or the coordinates are not valid.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> face_point(grid(1, 1), 0, [0.5, 0.25, 0.25]).positions(grid(1, 1))
    array([[0.5 , 0.25, 0.  ]])
    """
    return face_points(mesh, [face], np.asarray([np.full(3, 1 / 3) if weights is None else weights]))


def face_points(mesh: TriangleMesh, faces: Sequence[int] | Ints, weights: ArrayLike) -> SurfacePoints:
    """Select points in faces, (k,), by barycentric coordinates, (k, 3); check each as `face_point` does."""
    face, b = np.asarray(faces), np.asarray(weights, dtype=float)
    m = mesh.n_faces
    for outside in face[(face < 0) | (face >= m)][:1]:
        raise ArgumentError(f"face {outside} does not exist: the mesh has {m} faces (0 to {m - 1})")
    if b.shape != (len(face), 3):
        raise ArgumentError(
            f"a point in face {face[0]} has three barycentric coordinates, not {', '.join(f'{x:g}' for x in b.ravel())}"
        )
    sums = b.sum(axis=1)
    faults = {
        "a point in face {face} has three barycentric coordinates, not {given}": ~np.isfinite(sums),
        "barycentric coordinates {given} lie outside of face {face}; none may be negative": (b < 0).any(axis=1),
        "barycentric coordinates {given} in face {face} sum to {sum:g}; they must sum to 1": abs(sums - 1)
        > ROUNDED_SUM,
    }
    for sentence, wrong in faults.items():
        for k in np.flatnonzero(wrong)[:1]:
            raise ArgumentError(sentence.format(face=face[k], given=", ".join(f"{x:g}" for x in b[k]), sum=sums[k]))
    b = np.where(b < SNAP, 0.0, b)
    b /= b.sum(axis=1, keepdims=True)
    corners = mesh.faces[face].astype(np.int64)
    at_corner = np.count_nonzero(b, axis=1) == 1
    corners[at_corner] = corners[at_corner, b[at_corner].argmax(axis=1), None]
    b[at_corner] = 1.0, 0.0, 0.0
    return SurfacePoints(np.where(at_corner, -1, face), corners, b)


def boundary_points(mesh: TriangleMesh) -> SurfacePoints:
    """Select all boundary vertices, ascending.

    Raises
    ------
    ArgumentError
        If the mesh has no boundary.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> boundary_points(grid(2, 2)).vertices.tolist()
    [0, 1, 2, 3, 5, 6, 7, 8]
    """
    if mesh.is_closed:
        raise ArgumentError("the mesh has no boundary; name vertices or faces as sources")
    return vertex_points(mesh, mesh.boundary_vertices)


def extreme_vertex(mesh: TriangleMesh, axis: int, sign: int) -> int:
    """Return the referenced vertex of largest (sign 1) or smallest (-1) coordinate; the lowest index on a tie."""
    height = sign * mesh.vertices[:, axis]
    height[mesh.unreferenced_vertices] = -np.inf
    return int(height.argmax())


def default_source(mesh: TriangleMesh) -> int:
    """Return the vertex of largest y, the default source of all methods."""
    return extreme_vertex(mesh, 1, 1)
