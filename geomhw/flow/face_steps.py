"""A field that is constant on each face, as a particle in it sees it: where it heads, and what edges and vertices do.

In barycentric coordinates b of its face a particle moves by db_k/dt = V·∇φ_k, and an edge is crossed by handing over
the two coordinates of its ends. Where fields on both sides of an edge push into it, a particle slides along it by that
mean of the two which crosses neither way [Filippov 1988, Differential Equations with Discontinuous Righthand Sides,
sec. 4]; at the boundary it slides by the part of V along it. Fluxes of n x ∇ψ agree across edges, so there it never
slides but where ψ is the same at both ends. From a vertex a particle leaves by the fastest of the faces and edges that
lead away; where there are none it stays: it is the center of a turn, or a sink.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.mesh.topology import inner_pairs
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import hat_gradients

Mask = NDArray[np.bool_]


class Crossings:
    """What lies across each edge of each face of an edge-manifold mesh, oriented or not.

    Edges of faces are numbered 3f + k, the one opposite corner k. across: (3m,), the same edge as the other face has
    it, -1 at the boundary. opposed: (3m,), whether the other face runs along it the other way, as in oriented meshes.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self.hats = hat_gradients(mesh)
        one, other, _ = inner_pairs(mesh.edge_table)
        self.across = np.full(3 * mesh.n_faces, -1)
        self.across[one], self.across[other] = other, one
        ahead = np.roll(mesh.faces, -1, axis=1).ravel()
        self.opposed = ahead != ahead[self.across]

    def cross(self, edges: Ints, weights: Floats) -> tuple[Ints, Floats]:
        """The edges as the other faces number them, and the barycentric coordinates of points on them there, (k, 3)."""
        row, beyond, k = np.arange(len(edges)), self.across[edges], edges % 3
        first, second = weights[row, (k + 1) % 3], weights[row, (k + 2) % 3]
        swap = self.opposed[edges]
        there = np.zeros_like(weights)
        there[row, (beyond + 1) % 3] = np.where(swap, second, first)
        there[row, (beyond + 2) % 3] = np.where(swap, first, second)
        return beyond, there


class FaceFlow:
    """Motion of particles under V, (m, 3), on faces, edges and vertices."""

    def __init__(self, crossings: Crossings, V: Floats) -> None:
        self._crossings, self._V = crossings, V
        self._mesh = crossings.mesh
        self._rates = np.einsum("fkx,fx->fk", crossings.hats, V)

    def headed(self, faces: Ints, weights: Floats) -> tuple[Ints, Floats, Floats, Ints]:
        """Faces and coordinates of particles on the side of an edge or vertex to which they go on; their rates; edges.

        The rates, (k, 3), are those of the coordinates; edges, (k,), those that were crossed to get there, or -1.
        """
        rates = self._rates[faces]
        crossed = np.full(len(faces), -1)
        on_edge = weights == 0
        at_vertex = on_edge.sum(axis=1) == 2
        if (stuck := np.flatnonzero((on_edge & (rates < 0)).any(axis=1) & ~at_vertex)).size:
            faces, weights = faces.copy(), weights.copy()
            edges = 3 * faces[stuck] + on_edge[stuck].argmax(axis=1)
            blocked = self._blocked(edges)
            rates[stuck[blocked]] = self._sliding(edges[blocked])
            go = stuck[~blocked]
            crossed[go], weights[go] = self._crossings.cross(edges[~blocked], weights[go])
            faces[go] = crossed[go] // 3
            rates[go] = self._rates[faces[go]]
        if (rest := np.flatnonzero(at_vertex)).size:
            faces, weights = faces.copy(), weights.copy()
            corners = self._mesh.faces[faces[rest], weights[rest].argmax(axis=1)]
            faces[rest], weights[rest], rates[rest] = self._leaving(corners)
        return faces, weights, rates, crossed

    def _blocked(self, edges: Ints) -> Mask:
        """Whether what leaves a face over that edge is pushed back, or met by the boundary."""
        beyond = self._crossings.across[edges]
        return (beyond < 0) | (self._rates.ravel()[beyond] < 0)

    def _sliding(self, edges: Ints) -> Floats:
        """Rates of particles held on such edges, (k, 3)."""
        face, k, row = edges // 3, edges % 3, np.arange(len(edges))
        along = self._mesh.opposite_edges[face, k]
        other = self._crossings.across[edges]
        # Speeds towards the edge, but for the factor 2/|e|.
        near = -self._rates.ravel()[edges] * self._mesh.face_areas[face]
        far = np.where(other < 0, 0.0, -self._rates.ravel()[other] * self._mesh.face_areas[other // 3])
        share = np.where(other < 0, 1.0, np.divide(far, near + far, out=np.full(len(edges), 0.5), where=near + far > 0))
        V = share[:, None] * self._V[face] + (1 - share)[:, None] * self._V[other // 3]
        rates = np.zeros((len(edges), 3))
        rates[row, (k + 2) % 3] = np.einsum("ex,ex->e", V, along) / np.einsum("ex,ex->e", along, along)
        rates[row, (k + 1) % 3] = -rates[row, (k + 2) % 3]
        return rates

    def _leaving(self, vertices: Ints) -> tuple[Ints, Floats, Floats]:
        """Faces, coordinates and rates, of particles at vertices; rates of zero where no way leads off."""
        way = self._ways_off[vertices]
        corner = np.where(way < 0, self._any_corner[vertices], way % (3 * self._mesh.n_faces))
        faces, k = corner // 3, corner % 3
        weights = np.where(np.arange(3) == k[:, None], 1.0, 0.0)
        rates = np.where((way >= 0)[:, None], self._rates[faces], 0.0)
        for number, step in ((1, 1), (2, 2)):  # along the edge to the next corner, or to the one after that
            slides = np.flatnonzero(way // (3 * self._mesh.n_faces) == number)
            opposite = 3 * faces[slides] + (k[slides] + 3 - step) % 3
            rates[slides] = self._sliding(opposite)
        return faces, weights, rates

    @cached_property
    def _any_corner(self) -> Ints:
        first = np.zeros(self._mesh.n_vertices, dtype=np.int64)
        first[self._mesh.faces.ravel()] = np.arange(3 * self._mesh.n_faces)
        return first

    @cached_property
    def _ways_off(self) -> Ints:
        """The fastest way from each vertex, (n,); of equal ones the lowest; -1 for none.

        Corner 3f + k of a face to enter; plus 3m or 6m, to slide along its edge to the next corner, or the one after.
        """
        m, n = self._mesh.n_faces, self._mesh.n_vertices
        code, speed = (np.concatenate(both) for both in zip(self._faces_off(), self._edges_off(), strict=True))
        vertex = self._mesh.faces.ravel()[code % (3 * m)]
        order = np.lexsort((-code, speed, vertex))
        best = np.full(n, -1)
        best[vertex[order]] = code[order]  # the last one stays
        return best

    def _faces_off(self) -> tuple[Ints, Floats]:
        """Ways from vertices into faces, and their speeds."""
        R = self._rates
        free = np.flatnonzero((R < 0) & (np.roll(R, -1, axis=1) >= 0) & (np.roll(R, -2, axis=1) >= 0))
        return free, np.linalg.norm(self._V[free // 3], axis=1)

    def _edges_off(self) -> tuple[Ints, Floats]:
        """Ways from vertices along edges, and their speeds."""
        size = 3 * self._mesh.n_faces
        held = np.flatnonzero(self._rates.ravel() < 0)
        held = held[self._blocked(held)]
        face, k = held // 3, held % 3
        pace = self._sliding(held)[np.arange(len(held)), (k + 2) % 3]
        upward = pace > 0  # from corner k + 1 to corner k + 2
        code = 3 * face + np.where(upward, size + (k + 1) % 3, 2 * size + (k + 2) % 3)
        speed = np.abs(pace) * np.linalg.norm(self._mesh.opposite_edges[face, k], axis=1)
        return code[pace != 0], speed[pace != 0]
