"""Points on a surface in barycentric coordinates: vertices and points in faces."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


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
    >>> from geomhw.mesh import face_point, grid, vertex_points
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
    >>> from geomhw.mesh import grid, vertex_points
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
