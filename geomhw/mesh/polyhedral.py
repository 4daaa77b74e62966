"""What a surface of flat triangles is without coordinates in space: areas, angles, weights, connectedness."""

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from geomhw.arrays import Floats, Ints, frozen, pieces
from geomhw.errors import MeshError
from geomhw.mesh import geometry, topology


class PolyhedralSurface(ABC):
    """m flat triangles glued along edges at n vertices: what scalar operators see of a mesh.

    A `TriangleMesh` lies in space. An `IntrinsicMesh` knows lengths only, and a face of it may meet a vertex, an edge
    or itself more than once. Everything here follows from the members below.

    sheets: how many faces lie over each point of what is meant, 2 where the surface is both sides of a mesh; whatever
    is integrated over faces is divided by it.
    """

    faces: Ints
    sheets: int = 1

    @property
    @abstractmethod
    def n_vertices(self) -> int:
        """Number of vertices n."""

    @property
    @abstractmethod
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f, in axes of the face."""

    @property
    @abstractmethod
    def edge_table(self) -> topology.Edges:
        """Edges with their incidence to faces."""

    @property
    @abstractmethod
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""

    @property
    @abstractmethod
    def degenerate_faces(self) -> Ints:
        """Faces without area, as far as rounding can tell, ascending."""

    # -- faces ---------------------------------------------------------------------------------------------------------

    @property
    def n_faces(self) -> int:
        """Number of faces m."""
        return len(self.faces)

    @cached_property
    def area_vectors(self) -> Floats:
        """Normals times twice the areas, (m, 3), right-handed."""
        return frozen(geometry.area_vectors(self.opposite_edges))

    @cached_property
    def face_areas(self) -> Floats:
        """Areas, (m,)."""
        return frozen(geometry.lengths(self.area_vectors) / 2)

    @cached_property
    def face_normals(self) -> Floats:
        """Unit normals, (m, 3), right-handed; zero on a face without area."""
        return frozen(geometry.unit(self.area_vectors))

    @cached_property
    def angles(self) -> Floats:
        """Interior angle at each corner, (m, 3), radians."""
        dots = geometry.corner_dots(self.opposite_edges)
        return frozen(np.arctan2(2 * self.face_areas[:, None], dots))

    @property
    def cotangents(self) -> Floats:
        """Cotangent of the angle at each corner, (m, 3), not kept; MeshError if a face has no area."""
        self.require_area()
        cotangents = np.empty((self.n_faces, 3))
        for faces in pieces(self.n_faces):
            dots = geometry.corner_dots(self.opposite_edges[faces])
            np.divide(dots, 2 * self.face_areas[faces, None], out=cotangents[faces])
        return cotangents

    # -- vertices ------------------------------------------------------------------------------------------------------

    @cached_property
    def vertex_areas(self) -> Floats:
        """Barycentric areas, (n,): a third of the faces round each vertex. They sum to the area, of one sheet."""
        return frozen(geometry.corner_sum(self.face_areas / (3 * self.sheets), self.faces, self.n_vertices))

    @cached_property
    def unreferenced_vertices(self) -> Ints:
        """Vertices that belong to no face, ascending."""
        return frozen(np.flatnonzero(np.bincount(self.faces.ravel(), minlength=self.n_vertices) == 0))

    # -- edges and topology --------------------------------------------------------------------------------------------

    @property
    def edges(self) -> Ints:
        """Ends of the edges, (e, 2), the lower vertex first."""
        return self.edge_table.vertices

    @property
    def n_edges(self) -> int:
        """Number of edges e."""
        return len(self.edges)

    @cached_property
    def edge_cotan_weights(self) -> Floats:
        """Cotan weight ½(cot α + cot β) of each edge, (e,), over sheets; negative where the edge is not Delaunay."""
        halves = self.cotangents
        halves /= 2 * self.sheets
        return frozen(geometry.corner_sum(halves, self.edge_table.of_faces, self.n_edges))

    @cached_property
    def mean_edge_length(self) -> float:
        """h, the mean length of the edges."""
        return float(self.edge_lengths.mean())

    @cached_property
    def components(self) -> Ints:
        """Label of the connected component of each vertex, (n,); an unreferenced vertex is one of its own."""
        return frozen(topology.vertex_components(self.edges, self.n_vertices))

    @property
    def n_components(self) -> int:
        """Number of connected pieces of surface; unreferenced vertices do not count."""
        return int(self.components.max(initial=-1)) + 1 - len(self.unreferenced_vertices)

    @cached_property
    def boundary_vertices(self) -> Ints:
        """Vertices on an edge that has one face only, ascending."""
        return frozen(np.unique(self.edges[self.edge_table.face_counts == 1]))

    @property
    def is_closed(self) -> bool:
        """Whether every edge has two faces or more."""
        return not np.any(self.edge_table.face_counts == 1)

    @cached_property
    def is_edge_manifold(self) -> bool:
        """Whether every edge has at most two faces."""
        return not np.any(self.edge_table.face_counts > 2)

    @cached_property
    def is_oriented(self) -> bool:
        """Whether the two faces of every inner edge run along it in opposite directions."""
        return not np.any(self.edge_table.orientation_sums[self.edge_table.face_counts == 2])

    @property
    def euler_characteristic(self) -> int:
        """V - E + F over the referenced vertices."""
        return self.n_vertices - len(self.unreferenced_vertices) - self.n_edges + self.n_faces

    # -- checks --------------------------------------------------------------------------------------------------------

    def require_area(self, remedy: str = "collapse it or remove it") -> None:
        """MeshError if a face has no area, for its gradients and cotangents do not exist; the remedy ends the line."""
        if len(bad := self.degenerate_faces):
            more = f" ({len(bad)} such faces)" if len(bad) > 1 else ""
            corners = ", ".join(map(str, self.faces[bad[0]]))
            raise MeshError(f"face {bad[0]} (vertices {corners}) has zero area{more}; {remedy}")
