"""Points on a surface as further vertices of its mesh: faces and edges divided at them, the same surface."""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import counting_order
from geomhw.mesh.triangle_mesh import TriangleMesh

Weights = tuple[float, float, float]
_UNITS: tuple[Weights, Weights, Weights] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
#: A point lies on an edge of a part of a face if its barycentric coordinate there is smaller.
ON_EDGE = 1e-12


@dataclass(frozen=True, eq=False)
class InsertedPoints:
    """A mesh with k points as vertices.

    Attributes
    ----------
    mesh : TriangleMesh
        The vertices of the original mesh, then the inserted ones. The first faces have the numbers of the faces that
        they are parts of.
    vertices : (k,) integer array
        The vertex of each point.
    parents : (m',) integer array
        The face of the original mesh that each face is a part of.
    corners : (m', 3, 3) array
        Barycentric coordinates of the corners of each face in its parent.
    """

    mesh: TriangleMesh
    vertices: Ints
    parents: Ints
    corners: Floats


def insert_points(mesh: TriangleMesh, points: SurfacePoints) -> InsertedPoints:
    """Divide faces at points within them, and all faces at an edge at points on it.

    Raises
    ------
    FieldError
        If a point lies inside a face of zero area.

    Examples
    --------
    >>> from geomhw.mesh import face_point, grid
    >>> insert_points(grid(1, 1), face_point(grid(1, 1), 0)).mesh
    TriangleMesh(5 vertices, 4 faces)
    """
    inside = (points.weights > 0).all(axis=1) & np.isin(points.faces, mesh.degenerate_faces)
    if inside.any():
        raise FieldError(f"face {points.faces[inside][0]} has zero area, so no points inside; give one of its corners")
    division = Division(mesh)
    vertices = [
        int(corners[0]) if face < 0 else division.insert(int(face), weights)
        for face, corners, weights in zip(points.faces, points.corners, points.weights, strict=True)
    ]
    return division.result(vertices)


class Division:
    """Faces that have been divided: their parts, and the barycentric coordinates of the corners of these."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh = mesh
        self._edges = mesh.edge_table.of_faces
        self._at_edges = counting_order(self._edges.ravel()) // 3
        self._starts = np.append(0, np.cumsum(mesh.edge_table.face_counts))
        #: Edges of parts that stay edges: of curves.
        self.fixed: set[frozenset[int]] = set()
        self._points: list[Floats] = []
        self._parts: dict[int, list[tuple[int, ...]]] = {}
        self._weights: dict[tuple[int, int], Weights] = {}

    def insert(self, face: int, weights: Floats) -> int:
        """Return the vertex at a point, which is a new one unless there is one."""
        shares = [(self._shares(face, part, weights), part) for part in self._parts_of(face)]
        share, part = max(shares, key=lambda item: min(item[0]))
        total = sum(s for s in share if s >= ON_EDGE)
        at = [(v, s / total) for v, s in zip(part, share, strict=True) if s >= ON_EDGE]
        if len(at) == 1:
            return at[0][0]
        new = self._mesh.n_vertices + len(self._points)
        faces = [face]
        if len(at) == 2:
            (a, _), (b, _) = at
            if (whole := frozenset((a, b))) in self.fixed:
                self.fixed -= {whole}
                self.fixed |= {frozenset((v, new)) for v in whole}
            one, other = self._weights[face, a], self._weights[face, b]
            if edge := [k for k in range(3) if one[k] == 0 and other[k] == 0]:
                e = self._edges[face, edge[0]]
                faces = np.sort(self._at_edges[self._starts[e] : self._starts[e + 1]]).tolist()
        self._points.append(weights @ self._mesh.vertices[self._mesh.faces[face]])
        for f in faces:
            parts = self._parts_of(f)
            for p in [part] if len(at) == 3 else [p for p in parts if at[0][0] in p and at[1][0] in p]:
                parts.remove(p)
                parts += [tuple(new if u == v else u for u in p) for v, _ in at]
            self._weights[f, new] = _combined([s for _, s in at], [self._weights[f, v] for v, _ in at])
        return new

    def _shares(self, face: int, part: tuple[int, ...], weights: Floats) -> Weights:
        """Return the barycentric coordinates in a part of a point in the face."""
        if len(self._parts[face]) > 1:
            weights = np.linalg.solve(self._corners(face, part).T, weights)
        x, y, z = weights.tolist()
        return x, y, z

    def _place(self, face: int, v: int) -> complex:
        """Return two barycentric coordinates of a vertex in a face."""
        _, b, c = self._weights[face, v]
        return complex(b, c)

    def _parts_of(self, face: int) -> list[tuple[int, ...]]:
        """Return the parts of a face, at first the face."""
        if face not in self._parts:
            corners = tuple(self._mesh.faces[face].tolist())
            self._parts[face] = [corners]
            self._weights |= {(face, v): unit for v, unit in zip(corners, _UNITS, strict=True)}
        return self._parts[face]

    def _corners(self, face: int, part: tuple[int, ...]) -> Floats:
        """Return the barycentric coordinates of the corners of a part, (3, 3)."""
        return np.array([self._weights[face, v] for v in part])

    def result(self, vertices: list[int]) -> InsertedPoints:
        """Return the divided mesh."""
        mesh = self._mesh
        faces, parents = mesh.faces.astype(np.int64), np.arange(mesh.n_faces)
        corners = np.tile(np.eye(3), (mesh.n_faces, 1, 1))
        rest: list[tuple[int, tuple[int, ...]]] = []
        for face, (first, *others) in self._parts.items():
            faces[face], corners[face] = first, self._corners(face, first)
            rest += [(face, part) for part in others]
        if rest:
            faces = np.concatenate([faces, [part for _, part in rest]])
            parents = np.concatenate([parents, [face for face, _ in rest]])
            corners = np.concatenate([corners, [self._corners(*item) for item in rest]])
        divided = TriangleMesh(np.concatenate([mesh.vertices, *(p[None] for p in self._points)]), faces)
        return InsertedPoints(divided, np.array(vertices), parents, corners)


def _combined(shares: list[float], corners: list[Weights]) -> Weights:
    """Return the sum of barycentric coordinates times shares."""
    x, y, z = (sum(s * w[k] for s, w in zip(shares, corners, strict=True)) for k in range(3))
    return x, y, z
