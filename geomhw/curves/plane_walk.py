"""Short curves on a surface: from face to face along the section of the surface by a plane."""

from collections.abc import Set as AbstractSet
from math import dist

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.named_points import SNAP
from geomhw.mesh.topology import counting_order
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Faces that a walk passes at most, and its largest length in chords.
MOST_FACES, LONGEST = 32, 1.05
#: Least sine of the angle between the chord and the normal.
UPRIGHT = 0.1

#: A point: barycentric coordinates by vertex, without zeros. A step: the face that the curve enters at a point.
Place = dict[int, float]
Step = tuple[int, Place]


class PlaneWalk:
    """Joins points of a surface that are a few faces apart.

    The plane contains both points and the mean of the normals there. In flat parts the section is the shortest path.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh, self._edges = mesh, mesh.edge_table.of_faces
        self._at_vertex = counting_order(mesh.faces.ravel()) // 3
        self._vertex_starts = np.append(0, np.cumsum(np.bincount(mesh.faces.ravel(), minlength=mesh.n_vertices)))
        self._at_edge = counting_order(self._edges.ravel()) // 3
        self._edge_starts = np.append(0, np.cumsum(mesh.edge_table.face_counts))

    def shared_face(self, one: Place, other: Place) -> int:
        """Return the lowest face that contains two points, or -1."""
        support = one.keys() | other.keys()
        return next(iter(self._faces_with(support)), -1) if len(support) <= 3 else -1

    def between(self, one: Place, other: Place) -> list[Step]:
        """Return the steps from one point to another, without the last point; none if no short walk arrives."""
        p, q = self._position(one), self._position(other)
        starts, goals = self._faces_with(one.keys()), self._faces_with(other.keys())
        normal = self.mesh.face_normals[starts + goals].sum(axis=0)
        side = np.cross(q - p, normal)
        size, chord = np.linalg.norm(side), dist(p, q)
        if not size > UPRIGHT * chord * np.linalg.norm(normal):
            return []
        walks = (self._from(face, one, p, q, side / size, set(goals), LONGEST * chord) for face in starts)
        return next(filter(None, walks), [])

    def _faces_with(self, vertices: AbstractSet[int]) -> list[int]:
        """The faces with all of some vertices, ascending."""
        v = next(iter(vertices))
        around = np.sort(self._at_vertex[self._vertex_starts[v] : self._vertex_starts[v + 1]])
        return [f for f in around.tolist() if vertices <= set(self.mesh.faces[f].tolist())]

    def _from(
        self, face: int, one: Place, p: Floats, q: Floats, side: Floats, goals: set[int], longest: float
    ) -> list[Step]:
        """Walk from a point through a face to the first of the goals; no steps if that fails."""
        steps, entry, at, length = [(face, one)], -1, p, 0.0
        passed = 0
        while face not in goals:
            passed += 1
            crossed = self._next_edge(face, entry, one if entry < 0 else {}, at, q - p, side)
            if crossed is None or passed == MOST_FACES:
                return []
            entry, place, x = crossed
            length += dist(at, x)
            beyond = self._at_edge[self._edge_starts[entry] : self._edge_starts[entry + 1]].tolist()
            if len(beyond) != 2 or length > longest:
                return []
            face, at = sum(beyond) - face, x
            if place == steps[-1][1]:  # round a vertex
                steps.pop()
            steps.append((face, place))
        return steps if length + dist(at, q) <= longest else []

    def _next_edge(
        self, face: int, entry: int, start: Place, at: Floats, ahead: Floats, side: Floats
    ) -> tuple[int, Place, Floats] | None:
        """The edge by which the plane leaves a face, and the point there. start: where the walk starts, if here."""
        corners = self.mesh.faces[face].tolist()
        X = self.mesh.vertices[corners]
        heights, best = ((X - at) @ side).tolist(), None
        for k in range(3):
            i, j, edge = (k + 1) % 3, (k + 2) % 3, int(self._edges[face, k])
            on_start = bool(start) and start.keys() <= {corners[i], corners[j]}
            if edge == entry or on_start or (heights[i] >= 0) == (heights[j] >= 0):
                continue
            share = heights[i] / (heights[i] - heights[j])
            share = 0.0 if share < SNAP else 1.0 if share > 1 - SNAP else share
            x = (1 - share) * X[i] + share * X[j]
            gain = float((x - at) @ ahead)
            if not start or gain > (best[0] if best else 0):
                place = {corners[i]: 1 - share, corners[j]: share}
                best = gain, edge, {v: w for v, w in place.items() if w}, x
        return best[1:] if best else None

    def _position(self, place: Place) -> Floats:
        return np.asarray(np.array(list(place.values())) @ self.mesh.vertices[list(place)])
