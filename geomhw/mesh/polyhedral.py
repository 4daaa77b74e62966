"""Polyhedral surfaces: areas, angles, cotan weights and topology of triangles glued along edges."""

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from geomhw.arrays import Floats, Ints, frozen, pieces
from geomhw.errors import MeshError, Remedy
from geomhw.mesh import geometry, orientation_signs, topology


class PolyhedralSurface(ABC):
    """A surface of m flat triangles glued along e edges at n vertices: the input of scalar operators.

    A `TriangleMesh` has coordinates. An `IntrinsicMesh` has edge lengths only, and its faces may meet a vertex, an edge
    or themselves more than once. Both define the abstract members; all other properties derive from these. Arrays are
    computed once and read-only. Lengths have the units of the mesh.

    Attributes
    ----------
    faces : (m, 3) array of vertex indices.
    sheets : int
        Number of faces over each point of the surface: 2 for a tufted cover, else 1. Integrals over faces are divided
        by it.
    """

    faces: Ints
    sheets: int = 1

    @property
    @abstractmethod
    def n_vertices(self) -> int:
        """Number of vertices n, unreferenced ones included."""

    @property
    @abstractmethod
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f, in axes fixed per face."""

    @property
    @abstractmethod
    def edge_table(self) -> topology.Edges:
        """Edges and their incidence to faces."""

    @property
    @abstractmethod
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""

    @property
    @abstractmethod
    def degenerate_faces(self) -> Ints:
        """Faces of zero area up to rounding, (k,), ascending."""

    # -- faces ---------------------------------------------------------------------------------------------------------

    @property
    def n_faces(self) -> int:
        """Number of faces m."""
        return len(self.faces)

    @cached_property
    def area_vectors(self) -> Floats:
        """Face normals times twice the face areas, (m, 3), right-handed, units length²."""
        return frozen(geometry.cross(self.opposite_edges[:, 0], self.opposite_edges[:, 1]))

    @cached_property
    def face_areas(self) -> Floats:
        """Face areas, (m,), units length²."""
        return frozen(geometry.lengths(self.area_vectors) / 2)

    @cached_property
    def face_normals(self) -> Floats:
        """Unit face normals, (m, 3), right-handed; zero on a face whose area is exactly 0."""
        return frozen(geometry.unit(self.area_vectors))

    @cached_property
    def angles(self) -> Floats:
        """Interior angle at each corner, (m, 3), radians, 0 to π."""
        dots = geometry.corner_dots(self.opposite_edges)
        return frozen(np.arctan2(2 * self.face_areas[:, None], dots))

    @property
    def cotangents(self) -> Floats:
        """Cotangent of the angle at each corner, (m, 3), computed at each call; MeshError if a face has zero area."""
        self.require_area()
        cotangents = np.empty((self.n_faces, 3))
        for faces in pieces(self.n_faces):
            dots = geometry.corner_dots(self.opposite_edges[faces])
            np.divide(dots, 2 * self.face_areas[faces, None], out=cotangents[faces])
        return cotangents

    # -- vertices ------------------------------------------------------------------------------------------------------

    @cached_property
    def vertex_areas(self) -> Floats:
        """Barycentric vertex areas, (n,), units length²: a third of the adjacent face areas. They sum to the area."""
        return frozen(geometry.corner_sum(self.face_areas / (3 * self.sheets), self.faces, self.n_vertices))

    @cached_property
    def unreferenced_vertices(self) -> Ints:
        """Vertices that belong to no face, (k,), ascending."""
        return frozen(np.flatnonzero(np.bincount(self.faces.ravel(), minlength=self.n_vertices) == 0))

    # -- edges and topology --------------------------------------------------------------------------------------------

    @property
    def edges(self) -> Ints:
        """Vertex indices of the edges, (e, 2), the lower one first."""
        return self.edge_table.vertices

    @property
    def n_edges(self) -> int:
        """Number of edges e."""
        return len(self.edges)

    @cached_property
    def edge_cotan_weights(self) -> Floats:
        """Cotan weights ½(cot α + cot β) over ``sheets``, (e,); negative where the edge is not Delaunay."""
        halves = self.cotangents
        halves /= 2 * self.sheets
        return frozen(geometry.corner_sum(halves, self.edge_table.of_faces, self.n_edges))

    @cached_property
    def mean_edge_length(self) -> float:
        """Mean edge length h."""
        return float(self.edge_lengths.mean())

    @cached_property
    def components(self) -> Ints:
        """Connected component of each vertex, (n,), from 0; an unreferenced vertex is its own component."""
        return frozen(topology.vertex_components(self.edges, self.n_vertices))

    @property
    def n_components(self) -> int:
        """Number of connected components, unreferenced vertices not counted."""
        return int(self.components.max(initial=-1)) + 1 - len(self.unreferenced_vertices)

    @cached_property
    def boundary_vertices(self) -> Ints:
        """Vertices of edges with exactly one face, (k,), ascending."""
        return frozen(np.unique(self.edges[self.edge_table.face_counts == 1]))

    @property
    def is_closed(self) -> bool:
        """Whether no edge has exactly one face."""
        return not np.any(self.edge_table.face_counts == 1)

    @cached_property
    def is_edge_manifold(self) -> bool:
        """Whether no edge has more than two faces."""
        return not np.any(self.edge_table.face_counts > 2)

    @cached_property
    def is_oriented(self) -> bool:
        """Whether the orientation is consistent: the two faces of each inner edge run along it in opposite senses."""
        return not np.any(self.edge_table.orientation_sums[self.edge_table.face_counts == 2])

    @property
    def euler_characteristic(self) -> int:
        """Euler characteristic V - E + F, unreferenced vertices not counted."""
        return self.n_vertices - len(self.unreferenced_vertices) - self.n_edges + self.n_faces

    @cached_property
    def boundary_loops(self) -> list[Ints]:
        """Boundary loops as arrays of vertices, each in the direction of its faces."""
        return topology.boundary_loops(self.faces, self.edge_table)

    @cached_property
    def is_orientable(self) -> bool:
        """Whether reversing faces can orient the mesh consistently; False for a Möbius band."""
        return self.is_oriented or not len(orientation_signs.one_sided_faces(self.edge_table))

    @property
    def genus(self) -> int | None:
        """Sum of the genera of the components, (2c - b - χ)/2; None if an edge is non-manifold or the mesh one-sided.

        At pinched vertices it is the genus of the surface that is cut open there: components are connected by edges.
        """
        if not (self.is_edge_manifold and self.is_orientable):
            return None
        one, other, _ = topology.inner_pairs(self.edge_table)
        components = int(topology.linked_components(one // 3, other // 3, self.n_faces).max()) + 1
        fans = int(topology.fan_labels(self.faces, self.edge_table).max()) + 1
        return (2 * components - len(self.boundary_loops) - (fans - self.n_edges + self.n_faces)) // 2

    @cached_property
    def duplicate_faces(self) -> Ints:
        """Faces with the vertices of an earlier face in any order, and the first such face, (k, 2), ascending."""
        return frozen(topology.duplicate_faces(self.edge_table))

    # -- checks --------------------------------------------------------------------------------------------------------

    def require_area(self, remedy: Remedy = "") -> None:
        """Raise MeshError if a face has zero area; ``remedy``: the argument that avoids the error, for the message."""
        if len(bad := self.degenerate_faces):
            more = f" ({len(bad)} such faces)" if len(bad) > 1 else ""
            corners = ", ".join(map(str, self.faces[bad[0]]))
            advice = f"collapse it, remove it, or compute with {remedy}" if remedy else "collapse it or remove it"
            raise MeshError(f"face {bad[0]} (vertices {corners}) has zero area{more}; {advice}", remedy)

    def require_oriented(self, purpose: str) -> None:
        """Raise MeshError unless the mesh is an oriented manifold; ``purpose`` starts the message."""
        needs = f"{purpose} needs an oriented manifold"
        self.require_manifold(needs)
        if not self.is_orientable:
            raise MeshError(f"{needs}, but this surface is one-sided, such as a Moebius band")
        if not self.is_oriented:
            bad = np.flatnonzero((self.edge_table.face_counts == 2) & (self.edge_table.orientation_sums != 0))
            raise MeshError(
                f"{needs}, but the two faces at {self._edge_names(bad)} disagree in orientation; reverse one of them"
            )

    def require_manifold(self, needs: str) -> None:
        """Raise MeshError if an edge has more than two faces; ``needs`` starts the message."""
        if self.is_edge_manifold:
            return
        counts = self.edge_table.face_counts
        bad = np.flatnonzero(counts > 2)
        copies = self.duplicate_faces
        also = "; remove a face there, or cut the mesh along it"
        if len(copies):
            also = f"; face {copies[0, 0]} is a copy of face {copies[0, 1]}"
        raise MeshError(f"{needs}, but {counts[bad[0]]} faces meet at {self._edge_names(bad)}{also}")

    def _edge_names(self, which: Ints) -> str:
        """Name the first of the edges by its vertices, with their number."""
        first = "-".join(map(str, self.edges[which[0]]))
        return f"edge {first}" + (f" ({len(which)} such edges)" if len(which) > 1 else "")
