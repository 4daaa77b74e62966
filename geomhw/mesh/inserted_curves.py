"""Curves on a surface as edges of its mesh: faces divided along their segments, the same surface."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError
from geomhw.mesh.inserted_points import ON_EDGE, Division, InsertedPoints, Weights
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Sine of an angle, in barycentric coordinates, up to which a vertex of a part lies on a segment.
ON_SEGMENT = 1e-11


def chain_edges(mesh: TriangleMesh, chains: Sequence[Ints]) -> Ints:
    """Return the edges between consecutive vertices of chains, as indices into ``mesh.edges``."""
    pairs = [np.stack([chain[:-1], chain[1:]], axis=1) for chain in chains]
    return mesh.edge_table.between(np.concatenate([np.empty((0, 2), dtype=np.int64), *pairs]))


@dataclass(frozen=True, eq=False)
class InsertedCurves:
    """A mesh with curves as chains of edges.

    Attributes
    ----------
    inserted : InsertedPoints
        The divided mesh; ``vertices`` are those of the points of all curves, in order.
    chains : list of integer arrays
        The vertices of each curve in order; between its given points, also those at which it crosses other curves.
    """

    inserted: InsertedPoints
    chains: list[Ints]

    @property
    def mesh(self) -> TriangleMesh:
        """The divided mesh."""
        return self.inserted.mesh

    @property
    def edges(self) -> Ints:
        """The different edges of all curves, (e,), ascending, as indices into the edges of the divided mesh."""
        return np.unique(chain_edges(self.mesh, self.chains))


def insert_curves(mesh: TriangleMesh, curves: Sequence[tuple[Ints, Floats]]) -> InsertedCurves:
    """Divide faces along polylines.

    Parameters
    ----------
    mesh : TriangleMesh
    curves : sequence of (faces, weights), (k,) and (k, 3)
        Points in barycentric coordinates. Each segment lies in the face of its first point. Where segments cross, the
        mesh gets a vertex.

    Raises
    ------
    FieldError
        If a point lies inside a face of zero area, or a segment ends in no corner of its face, but in the place of one
        that no edge of zero length joins to it.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> found = insert_curves(grid(1, 1), [(np.array([0, 0]), np.array([[0.5, 0.5, 0], [0, 0.5, 0.5]]))])
    >>> found.mesh, found.chains[0].tolist()
    (TriangleMesh(6 vertices, 4 faces), [4, 5])
    """
    division = _CurveDivision(mesh)
    vertices = [
        [division.insert(face, share) for face, share in zip(faces.tolist(), weights, strict=True)]
        for faces, weights in curves
    ]
    chains: list[Ints] = []
    for recorded in (False, True):  # later curves divide earlier ones
        for (faces, _), corners in zip(curves, vertices, strict=True):
            chain = [corners[0]]
            for face, start, end in zip(faces.tolist(), corners[:-1], corners[1:], strict=False):
                chain += division.connect(face, start, end)
            if recorded:
                chains.append(np.array(chain))
    return InsertedCurves(division.result([v for corners in vertices for v in corners]), chains)


@dataclass(frozen=True, eq=False)
class InsertedSources:
    """A mesh divided at points and along the segments between them.

    Attributes
    ----------
    mesh : TriangleMesh
    sources : SurfacePoints
        The points as vertices of it, ascending; new vertices within a filled region belong to it.
    vertices : (k,) integer array
        The vertex of each point.
    chains : list of integer arrays
        The vertices of each segment.
    """

    mesh: TriangleMesh
    sources: SurfacePoints
    vertices: Ints
    chains: list[Ints]

    def sides(self, segments: Ints) -> Ints:
        """Return the halfedges 3f + k, ascending, of the sides of faces that some segments consist of."""
        chosen = np.zeros(self.mesh.n_edges, dtype=bool)
        chosen[chain_edges(self.mesh, [self.chains[s] for s in segments.tolist()])] = True
        return np.flatnonzero(chosen[self.mesh.edge_table.of_faces.ravel()])


def insert_sources(mesh: TriangleMesh, points: SurfacePoints) -> InsertedSources:
    """Divide a mesh at points and along the segments between them; raises as `insert_curves`."""
    weights_of, curves = points.corner_weights(), []
    for i, j, face in points.segments.tolist():
        weights = [[weights_of[k].get(v, 0.0) for v in mesh.faces[face].tolist()] for k in (i, j)]
        curves.append((np.array([face, face]), np.array(weights)))
    inside = np.flatnonzero(points.faces >= 0)
    alone = [(points.faces[k : k + 1], points.weights[k : k + 1]) for k in inside]
    found = insert_curves(mesh, [*curves, *alone])
    vertices = points.corners[:, 0].copy()
    vertices[inside] = found.inserted.vertices[2 * len(curves) :]
    chains = found.chains[: len(curves)]
    filled = _filled_vertices(mesh, points, found)
    sources = np.unique(np.concatenate([vertices, filled, *chains]))
    named = replace(vertex_points(found.mesh, sources), filled=np.isin(sources, filled))
    return InsertedSources(found.mesh, named, vertices, chains)


def _filled_vertices(mesh: TriangleMesh, points: SurfacePoints, found: InsertedCurves) -> Ints:
    """Return the vertices of filled regions in a divided mesh: those given, and new ones on their edges and faces."""
    filled = np.zeros(mesh.n_vertices, dtype=bool)
    filled[points.filled_vertices] = True
    names, first = np.unique(found.mesh.faces, return_index=True)
    new = names >= mesh.n_vertices
    face, corner = np.divmod(first[new], 3)
    within = filled[mesh.faces[found.inserted.parents[face]]] | (found.inserted.corners[face, corner] == 0)
    return np.concatenate([np.flatnonzero(filled), names[new][within.all(axis=1)]])


class _CurveDivision(Division):
    """Faces that have been divided at points and along segments."""

    def _shares(self, face: int, part: tuple[int, ...], weights: Floats) -> Weights:
        """Return the barycentric coordinates in a part of a point in the face; those near an edge are 0."""
        if len(self._parts[face]) == 1:
            return super()._shares(face, part, weights)
        w = complex(*weights[1:].tolist())
        a, b, c = (self._place(face, v) - w for v in part)
        areas = _cross(b, c), _cross(c, a), _cross(a, b)
        total = sum(areas)
        # The distance from an edge, in barycentric coordinates of the face, is the area over the length of the edge.
        near = tuple(ON_EDGE * max(abs(edge), total) for edge in (b - c, c - a, a - b))
        if not total > 0:
            return -1.0, -1.0, -1.0
        x, y, z = (area / total if abs(area) > limit else 0.0 for area, limit in zip(areas, near, strict=True))
        return x, y, z

    def connect(self, face: int, start: int, end: int) -> list[int]:
        """Make the segment between two vertices in a face a chain of edges; return its vertices after the first."""
        self._parts_of(face)
        before, after = self._way_into(face, start), self._way_into(face, end)
        first, last = (way[-1][2] if way else v for way, v in ((before, start), (after, end)))
        chain = []
        for f, a, b in [*before, (face, first, last), *((f, b, a) for f, a, b in after[::-1])]:
            while a != b:
                a = self._advance(f, a, b)
                chain.append(a)
        return chain

    def _way_into(self, face: int, start: int) -> list[tuple[int, int, int]]:
        """Return the steps, (face, start, end), along edges of length zero from a vertex to a corner of a face."""
        if (face, start) in self._weights:
            return []
        mesh, ways = self._mesh, {start: list[tuple[int, int, int]]()}
        edges = np.flatnonzero(mesh.edge_lengths == 0)
        for v in (queue := [start]):
            if v in mesh.faces[face]:
                return ways[v]
            for e in edges[(mesh.edges[edges] == v).any(axis=1)].tolist():
                end, f = int(mesh.edges[e].sum()) - v, int(self._at_edges[self._starts[e]])
                if end not in ways:
                    ways[end] = [*ways[v], (f, v, end)]
                    queue.append(end)
        raise FieldError(f"vertex {start} and a corner of face {face} lie in one place; join such vertices first")

    def _advance(self, face: int, start: int, end: int) -> int:
        """Make the beginning of a segment an edge of parts, and return the end of this edge."""
        parts, at, d = self._parts_of(face), self._place(face, start), self._step(face, start, end)
        fans = [(part, part[k - 2], part[k - 1]) for part in parts if start in part for k in (part.index(start),)]
        around = {v for _, *two in fans for v in two}
        ahead = [v for v in around if v == end or self._lies_on(d, self._step(face, start, v))]
        if ahead:
            nearest = min(ahead, key=lambda v: abs(self._place(face, v) - at))
            self.fixed.add(frozenset((start, nearest)))
            return nearest
        part, right, left = next(
            (part, a, b)
            for part, a, b in fans
            if _cross(self._step(face, start, a), d) > 0 and _cross(d, self._step(face, start, b)) > 0
        )
        crossed, sides = [part], ([left], [right])
        while True:
            if frozenset((left, right)) in self.fixed:
                new = self.insert(face, self._crossing(face, start, d, left, right))
                return self._advance(face, start, new)
            part = next(p for p in parts if p not in crossed and left in p and right in p)
            crossed.append(part)
            (far,) = set(part) - {left, right}
            if far == end or self._lies_on(d, self._step(face, start, far)):
                break
            if _cross(d, self._step(face, start, far)) > 0:
                left = far
                sides[0].append(far)
            else:
                right = far
                sides[1].append(far)
        for part in crossed:
            parts.remove(part)
        self._fill(face, start, far, sides[0])
        self._fill(face, far, start, sides[1][::-1])
        self.fixed.add(frozenset((start, far)))
        return far

    def _step(self, face: int, start: int, end: int) -> complex:
        return self._place(face, end) - self._place(face, start)

    @staticmethod
    def _lies_on(d: complex, e: complex) -> bool:
        """Whether a step stays on a longer one."""
        return abs(_cross(d, e)) <= ON_SEGMENT * abs(d) * abs(e) and 0 < (d.conjugate() * e).real < abs(d) ** 2

    def _crossing(self, face: int, start: int, d: complex, one: int, other: int) -> Floats:
        """Return the barycentric coordinates at which a segment crosses the edge between two vertices."""
        a, b = (_cross(d, self._step(face, start, v)) for v in (one, other))
        share = a / (a - b)
        p, q = np.array([self._weights[face, one], self._weights[face, other]])
        return np.asarray((1 - share) * p + share * q)

    def _fill(self, face: int, a: int, b: int, chain: list[int]) -> None:
        """Add the Delaunay triangles between an edge and a chain on its left, in order from its first end."""
        if not chain:
            return
        p, q = self._place(face, a), self._place(face, b)
        best = 0
        for k in range(1, len(chain)):
            if _in_circle(p, q, self._place(face, chain[best]), self._place(face, chain[k])):
                best = k
        self._parts_of(face).append((a, b, chain[best]))
        self._fill(face, a, chain[best], chain[:best])
        self._fill(face, chain[best], b, chain[best + 1 :])


def _cross(a: complex, b: complex) -> float:
    """Return the signed area of the parallelogram of two plane vectors."""
    return a.real * b.imag - a.imag * b.real


def _in_circle(a: complex, b: complex, c: complex, d: complex) -> bool:
    """Whether d lies within the circle through a, b and c, which are counterclockwise."""
    rows = [[(p - d).real, (p - d).imag, abs(p - d) ** 2] for p in (a, b, c)]
    (x, y, z), (u, v, w), (r, s, t) = rows
    return x * (v * t - w * s) - y * (u * t - w * r) + z * (u * s - v * r) > 0
