"""The mesh that everything else takes: vertices and faces, frozen; what derives from them, computed once on demand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geomhw.errors import MeshError
from geomhw.mesh import geometry, tangent, topology
from geomhw.mesh.arrays import Floats, Ints, frozen


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangle mesh of n vertices and m faces, in the order in which they were given.

    vertices: (n, 3) coordinates, finite.
    faces: (m, 3) vertex indices from 0, counterclockwise seen from outside; three different ones a face.

    Raises MeshError where that does not hold. Vertices that belong to no face are kept, and counted in
    ``unreferenced_vertices``. All arrays are read-only.

    >>> mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh.face_areas
    array([0.5])
    """

    vertices: Floats
    faces: Ints

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        points = np.array(vertices, dtype=np.float64)
        corners = np.array(faces)
        _check(points, corners)
        object.__setattr__(self, "vertices", frozen(points))
        object.__setattr__(self, "faces", frozen(corners.astype(np.int32)))

    # -- sizes ---------------------------------------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """Number of vertices n."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """Number of faces m."""
        return len(self.faces)

    @property
    def n_edges(self) -> int:
        """Number of unique edges."""
        return len(self.edges)

    # -- faces ---------------------------------------------------------------------------------------------------

    @cached_property
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f."""
        return frozen(geometry.opposite_edges(self.vertices, self.faces))

    @cached_property
    def _area_vectors(self) -> Floats:
        return frozen(geometry.area_vectors(self.opposite_edges))

    @cached_property
    def face_areas(self) -> Floats:
        """Areas, (m,)."""
        return frozen(np.linalg.norm(self._area_vectors, axis=1) / 2)

    @cached_property
    def face_normals(self) -> Floats:
        """Unit normals, (m, 3), right-handed; zero on a face without area."""
        return frozen(geometry.unit(self._area_vectors))

    @cached_property
    def face_centers(self) -> Floats:
        """Barycenters, (m, 3)."""
        return frozen(geometry.face_centers(self.vertices, self.faces))

    @cached_property
    def angles(self) -> Floats:
        """Interior angle at each corner, (m, 3), radians."""
        dots = geometry.corner_dots(self.opposite_edges)
        return frozen(np.arctan2(2 * self.face_areas[:, None], dots))

    @cached_property
    def cotangents(self) -> Floats:
        """Cotangent of the angle at each corner, (m, 3); MeshError if a face has no area."""
        self.require_area()
        dots = geometry.corner_dots(self.opposite_edges)
        return frozen(dots / (2 * self.face_areas[:, None]))

    # -- vertices ------------------------------------------------------------------------------------------------

    @cached_property
    def vertex_areas(self) -> Floats:
        """Barycentric areas, (n,): a third of the faces round each vertex. They sum to the area of the mesh."""
        return frozen(geometry.corner_sum(self.face_areas / 3, self.faces, self.n_vertices))

    @cached_property
    def vertex_normals(self) -> Floats:
        """Area-weighted unit normals, (n, 3); zero where the faces cancel or there are none."""
        sums = [geometry.corner_sum(x, self.faces, self.n_vertices) for x in self._area_vectors.T]
        return frozen(geometry.unit(np.stack(sums, axis=1)))

    @cached_property
    def tangent_frames(self) -> Floats:
        """Right-handed orthonormal frame (e1, e2) of each vertex's tangent plane, (n, 2, 3).

        e1 points along the edge that starts the vertex's lowest-numbered face, projected to the plane.
        """
        return frozen(tangent.vertex_frames(self.vertices, self.faces, self.vertex_normals))

    @cached_property
    def unreferenced_vertices(self) -> Ints:
        """Vertices that belong to no face, ascending."""
        uses = np.bincount(self.faces.ravel(), minlength=self.n_vertices)
        return frozen(np.flatnonzero(uses == 0))

    # -- edges and topology --------------------------------------------------------------------------------------

    @cached_property
    def edge_table(self) -> topology.Edges:
        """Edges with their incidence to faces."""
        return topology.unique_edges(self.faces)

    @property
    def edges(self) -> Ints:
        """Unique edges, (e, 2), the lower vertex first, in lexicographic order."""
        return self.edge_table.vertices

    @cached_property
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""
        return frozen(topology.edge_lengths(self.vertices, self.edges))

    @cached_property
    def edge_cotan_weights(self) -> Floats:
        """Cotan weight ½(cot α + cot β) of each edge, (e,); negative where the edge is not Delaunay."""
        return frozen(geometry.corner_sum(self.cotangents / 2, self.edge_table.of_faces, self.n_edges))

    @cached_property
    def mean_edge_length(self) -> float:
        """h, the mean length of the unique edges."""
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
    def boundary_loops(self) -> list[Ints]:
        """Boundary loops as arrays of vertices, in the direction of their faces."""
        return topology.boundary_loops(self.faces, self.edge_table)

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

    @cached_property
    def is_orientable(self) -> bool:
        """Whether faces could be turned so that the mesh is oriented (a Möbius band is not)."""
        return self.is_oriented or topology.is_orientable(self.edge_table)

    @property
    def euler_characteristic(self) -> int:
        """V - E + F over the referenced vertices."""
        return self.n_vertices - len(self.unreferenced_vertices) - self.n_edges + self.n_faces

    @property
    def genus(self) -> int | None:
        """Sum of the genera of the components, (2c - b - χ)/2; None where that is no surface (or one-sided)."""
        if not (self.is_edge_manifold and self.is_orientable):
            return None
        doubled = 2 * self.n_components - len(self.boundary_loops) - self.euler_characteristic
        return doubled // 2 if doubled >= 0 and doubled % 2 == 0 else None

    # -- checks --------------------------------------------------------------------------------------------------

    @cached_property
    def degenerate_faces(self) -> Ints:
        """Faces without area, as far as the coordinates' rounding can tell, ascending."""
        return frozen(geometry.degenerate_faces(self.vertices, self.faces, self.opposite_edges))

    def require_oriented(self, purpose: str) -> None:
        """MeshError unless faces agree on what is up; the purpose starts the sentence."""
        if not (self.is_edge_manifold and self.is_oriented):
            raise MeshError(
                f"{purpose} needs an oriented manifold: at most two faces at an edge, which agree on what is up"
            )

    def require_area(self) -> None:
        """MeshError if a face has no area: its gradients and cotangents do not exist."""
        if len(bad := self.degenerate_faces):
            more = f" ({len(bad)} such faces)" if len(bad) > 1 else ""
            corners = ", ".join(map(str, self.faces[bad[0]]))
            raise MeshError(f"face {bad[0]} (vertices {corners}) has zero area{more}; collapse it or remove it")


def _check(vertices: Floats, faces: Ints) -> None:
    """MeshError unless the arrays describe triangles over finite points."""
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise MeshError(f"vertices must be an (n, 3) array, not {vertices.shape}")
    if faces.size == 0:
        raise MeshError("the mesh has no faces; a surface needs at least one triangle")
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
        raise MeshError(f"faces must be an (m, 3) array of integers, not {faces.shape} of {faces.dtype}")
    if not (finite := np.isfinite(vertices).all(axis=1)).all():
        bad = int(np.argmin(finite))
        raise MeshError(f"vertex {bad} has a coordinate that is not a finite number: {vertices[bad].tolist()}")
    if (outside := ((faces < 0) | (faces >= len(vertices))).any(axis=1)).any():
        bad = int(np.argmax(outside))
        last = len(vertices) - 1
        raise MeshError(f"face {bad} names vertices {faces[bad].tolist()}, but they go from 0 to {last}")
    if (repeated := (faces == np.roll(faces, 1, axis=1)).any(axis=1)).any():
        bad = int(np.argmax(repeated))
        raise MeshError(f"face {bad} names a vertex twice: {faces[bad].tolist()}; a triangle needs three")
