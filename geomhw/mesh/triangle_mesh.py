"""The mesh that everything else takes: vertices and faces, frozen; what derives from them, computed once on demand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints, frozen
from geomhw.errors import MeshError
from geomhw.mesh import geometry, orientation_signs, tangent_frames, topology
from geomhw.mesh.polyhedral import PolyhedralSurface

#: Coordinates go up to this, and the mesh is no smaller than one over it.
LARGEST = 1e30
#: A sum of normals that is this much shorter than they are together is rounding.
CANCELED = 1e-12


@dataclass(frozen=True, eq=False)
class TriangleMesh(PolyhedralSurface):
    """A triangle mesh of n vertices and m faces, in the order in which they were given.

    vertices: (n, 3) coordinates, finite.
    faces: (m, 3) vertex indices from 0, counterclockwise seen from outside; three different ones a face.

    Raises MeshError where that does not hold, and, once it is measured, for a mesh too large or too small to compute
    with. Vertices that belong to no face are kept, and counted in ``unreferenced_vertices``. All arrays are read-only.

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
        object.__setattr__(self, "faces", frozen(corners.astype(np.int32, copy=False)))

    # -- sizes ---------------------------------------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """Number of vertices n."""
        return len(self.vertices)

    # -- faces ---------------------------------------------------------------------------------------------------

    @cached_property
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f."""
        _check_size(self.vertices)
        return frozen(geometry.opposite_edges(self.vertices, self.faces))

    @cached_property
    def face_centers(self) -> Floats:
        """Barycenters, (m, 3)."""
        return frozen(geometry.face_centers(self.vertices, self.faces))

    # -- vertices ------------------------------------------------------------------------------------------------

    @cached_property
    def corner_signs(self) -> Ints:
        """Sign of a face's normal at its corners, (m, 3), by `corner_signs`; 0 for a duplicate face."""
        copies = self.duplicate_faces[:, 0]
        if self.is_oriented and not len(copies):
            return frozen(np.ones(self.faces.shape, dtype=np.int64))
        first = np.delete(np.arange(self.n_faces), copies)
        edges = topology.unique_edges(self.faces[first]) if len(copies) else self.edge_table
        signs = np.zeros(self.faces.shape, dtype=np.int64)
        signs[first] = orientation_signs.corner_signs(self.faces[first], edges)
        return frozen(signs)

    @cached_property
    def vertex_normals(self) -> Floats:
        """Area-weighted unit normals, (n, 3); zero where the faces cancel or there are none.

        Faces count as if turned to agree with their neighbors, and once if they are there twice. On a one-sided surface
        they agree round each vertex, and those of two neighbors may be of two minds: see ``edge_signs``.
        """
        sums = geometry.vector_sum(self.area_vectors, self.faces, self.n_vertices, self.corner_signs)
        total = geometry.corner_sum(2 * self.face_areas, self.faces, self.n_vertices)
        sums[np.linalg.norm(sums, axis=1) <= CANCELED * total] = 0.0
        return frozen(geometry.unit(sums))

    @cached_property
    def tangent_frames(self) -> Floats:
        """Right-handed orthonormal frame (e1, e2) of each vertex's tangent plane, (n, 2, 3).

        e1 points along the edge that starts the vertex's lowest-numbered face, projected to the plane.
        """
        return frozen(tangent_frames.vertex_frames(self.vertices, self.faces, self.vertex_normals))

    # -- edges and topology --------------------------------------------------------------------------------------

    @cached_property
    def edge_table(self) -> topology.Edges:
        """Edges with their incidence to faces, in lexicographic order."""
        return topology.unique_edges(self.faces)

    @cached_property
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""
        _check_size(self.vertices)
        return frozen(geometry.distances(self.vertices, self.edges))

    @cached_property
    def edge_signs(self) -> Ints:
        """-1 for edges whose vertex normals lie on opposite sides of the surface, else 1, (e,); all 1 if it has two."""
        return frozen(orientation_signs.edge_signs(self.corner_signs, self.edge_table))

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
        return frozen(geometry.degenerate_faces(self.vertices, self.faces, self.opposite_edges, 2 * self.face_areas))

    @cached_property
    def duplicate_faces(self) -> Ints:
        """Faces with the vertices of an earlier one, in whatever order, and the first such, (k, 2), ascending."""
        return frozen(topology.duplicate_faces(self.edge_table))

    def require_oriented(self, purpose: str) -> None:
        """MeshError unless faces agree on what is up; the purpose starts the sentence, which says where they do not."""
        needs = f"{purpose} needs an oriented manifold"
        self.require_manifold(needs)
        if not self.is_orientable:
            raise MeshError(
                f"{needs}, but this surface is one-sided: no turning of faces makes them agree on what is up"
            )
        if not self.is_oriented:
            bad = np.flatnonzero((self.edge_table.face_counts == 2) & (self.edge_table.orientation_sums != 0))
            raise MeshError(f"{needs}, but the two faces at {self._edge_names(bad)} disagree on what is up; turn faces")

    def require_manifold(self, needs: str) -> None:
        """MeshError where an edge has more than two faces; the need starts the sentence."""
        if self.is_edge_manifold:
            return
        counts = self.edge_table.face_counts
        bad = np.flatnonzero(counts > 2)
        copies = self.duplicate_faces
        also = f"; face {copies[0, 0]} is a copy of face {copies[0, 1]}" if len(copies) else ""
        raise MeshError(f"{needs}, but {counts[bad[0]]} faces meet at {self._edge_names(bad)}{also}")

    def _edge_names(self, which: Ints) -> str:
        """The first of those edges by its vertices, and how many there are."""
        first = "-".join(map(str, self.edges[which[0]]))
        return f"edge {first}" + (f" ({len(which)} such edges)" if len(which) > 1 else "")


def _check(vertices: Floats, faces: Ints) -> None:
    """MeshError unless the arrays describe triangles over finite points."""
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise MeshError(f"vertices must be an (n, 3) array, not {vertices.shape}")
    if faces.size == 0:
        raise MeshError("the mesh has no faces; a surface needs at least one triangle")
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
        raise MeshError(f"faces must be an (m, 3) array of integers, not {faces.shape} of {faces.dtype}")
    if not (finite := np.isfinite(vertices)).all():
        bad = int(np.argmin(finite.all(axis=1)))
        raise MeshError(f"vertex {bad} has a coordinate that is not a finite number: {vertices[bad].tolist()}")
    if faces.min() < 0 or faces.max() >= len(vertices):
        bad = int(np.argmax(((faces < 0) | (faces >= len(vertices))).any(axis=1)))
        last = len(vertices) - 1
        raise MeshError(f"face {bad} names vertices {faces[bad].tolist()}, but they go from 0 to {last}")
    a, b, c = faces.T
    if (repeated := (a == b) | (b == c) | (c == a)).any():
        bad = int(np.argmax(repeated))
        raise MeshError(f"face {bad} names a vertex twice: {faces[bad].tolist()}; a triangle needs three")


def _check_size(vertices: Floats) -> None:
    """MeshError for a mesh whose squared areas, or places in single precision, would leave the range of numbers."""
    low, high = (np.array([end(column) for column in vertices.T]) for end in (np.min, np.max))
    largest = max(-low.min(), high.max())
    if largest > LARGEST:
        bad = int(np.abs(vertices).max(axis=1).argmax())
        raise MeshError(f"vertex {bad} is at {largest:.3g}, beyond {LARGEST:g}: choose a larger unit of length")
    extent = (high - low).max()
    if 0 < extent < 1 / LARGEST:
        raise MeshError(
            f"the mesh is only {extent:.3g} across, less than {1 / LARGEST:g}: choose a smaller unit of length"
        )
