"""The mesh that everything else takes: vertices and faces, frozen; what derives from them, computed once on demand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geomhw.errors import MeshError
from geomhw.mesh import geometry, tangent, topology
from geomhw.mesh.arrays import Floats, Ints, frozen
from geomhw.mesh.polyhedral import PolyhedralSurface


@dataclass(frozen=True, eq=False)
class TriangleMesh(PolyhedralSurface):
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

    # -- faces ---------------------------------------------------------------------------------------------------

    @cached_property
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f."""
        return frozen(geometry.opposite_edges(self.vertices, self.faces))

    @cached_property
    def face_centers(self) -> Floats:
        """Barycenters, (m, 3)."""
        return frozen(geometry.face_centers(self.vertices, self.faces))

    # -- vertices ------------------------------------------------------------------------------------------------

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

    # -- edges and topology --------------------------------------------------------------------------------------

    @cached_property
    def edge_table(self) -> topology.Edges:
        """Edges with their incidence to faces, in lexicographic order."""
        return topology.unique_edges(self.faces)

    @cached_property
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""
        return frozen(topology.edge_lengths(self.vertices, self.edges))

    @cached_property
    def boundary_loops(self) -> list[Ints]:
        """Boundary loops as arrays of vertices, in the direction of their faces."""
        return topology.boundary_loops(self.faces, self.edge_table)

    @cached_property
    def is_orientable(self) -> bool:
        """Whether faces could be turned so that the mesh is oriented (a Möbius band is not)."""
        return self.is_oriented or topology.is_orientable(self.edge_table)

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
