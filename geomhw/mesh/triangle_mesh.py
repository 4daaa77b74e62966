"""Triangle meshes in space: vertices and faces, and the geometry and topology derived from them."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats, Ints, frozen
from geomhw.errors import MeshError
from geomhw.mesh import geometry, orientation_signs, tangent_frames, topology
from geomhw.mesh.polyhedral import PolyhedralSurface

#: Largest absolute coordinate; its inverse is the smallest extent of a mesh.
LARGEST = 1e30
#: meshio's names of cells that bound no face, which `TriangleMesh.from_meshio` skips.
_BELOW_TRIANGLES = ("vertex", "line")


@dataclass(frozen=True, eq=False)
class TriangleMesh(PolyhedralSurface):
    """A triangle mesh with n vertices and m faces, both in the given order.

    The arrays are copied and read-only. Derived arrays are computed on first use and kept. Vertices that belong to no
    face stay in place; see ``unreferenced_vertices``.

    Parameters
    ----------
    vertices : (n, 3) array of finite coordinates, any unit of length.
    faces : (m, 3) integer array
        Vertex indices from 0, three different ones per face, counterclockwise seen from outside.

    Raises
    ------
    MeshError
        If an array has another shape or type, an index is out of range, a face repeats a vertex, or a coordinate is
        not finite. On first use of the geometry, if a coordinate exceeds 1e30 or the mesh is smaller than 1e-30.

    Examples
    --------
    >>> mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh
    TriangleMesh(3 vertices, 1 face)
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

    def __repr__(self) -> str:
        return f"TriangleMesh({self.n_vertices} vertices, {self.n_faces} face{'s' * (self.n_faces != 1)})"

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled: vertices and faces, from which the other arrays follow."""
        return {"vertices": self.vertices, "faces": self.faces}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what was pickled; copies are read-only, too."""
        for name, values in state.items():
            object.__setattr__(self, name, frozen(values))

    # -- conversion ----------------------------------------------------------------------------------------------------

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, faces: ArrayLike) -> "TriangleMesh":
        """Build a mesh from vertices, (n, 3), and faces, (m, 3); the same as ``TriangleMesh(vertices, faces)``."""
        return cls(vertices, faces)

    @classmethod
    def from_pyvista(cls, polydata: Any) -> "TriangleMesh":
        """Build a mesh from a pyvista PolyData.

        Parameters
        ----------
        polydata : pyvista.PolyData
            A surface whose cells are all triangles. Its data arrays are not read.

        Returns
        -------
        TriangleMesh
            The points and triangles in the same order. Single-precision points become double precision.

        Raises
        ------
        MeshError
            If the dataset is no PolyData or has cells other than triangles.

        Examples
        --------
        >>> import pyvista
        >>> TriangleMesh.from_pyvista(pyvista.Plane(i_resolution=2, j_resolution=1).triangulate())
        TriangleMesh(6 vertices, 4 faces)
        """
        if not getattr(polydata, "is_all_triangles", False) or polydata.n_strips:
            kind = type(polydata).__name__
            raise MeshError(
                f"the {kind} is no surface of triangles only; call extract_surface() and triangulate() on it"
            )
        return cls(polydata.points, polydata.regular_faces)

    @classmethod
    def from_trimesh(cls, mesh: Any) -> "TriangleMesh":
        """Build a mesh from a trimesh Trimesh, with its vertices and faces in the same order.

        Raises
        ------
        MeshError
            If the object has no faces, such as a Scene or a PointCloud.

        Examples
        --------
        >>> import trimesh
        >>> TriangleMesh.from_trimesh(trimesh.creation.box())
        TriangleMesh(8 vertices, 12 faces)
        """
        if not hasattr(mesh, "faces"):
            raise MeshError(f"the {type(mesh).__name__} is no mesh of triangles; a scene has to_mesh() for one")
        return cls(np.asarray(mesh.vertices), np.asarray(mesh.faces))

    @classmethod
    def from_meshio(cls, mesh: Any) -> "TriangleMesh":
        """Build a mesh from the triangle cells of a meshio Mesh.

        Parameters
        ----------
        mesh : meshio.Mesh
            Blocks of type "triangle" are joined in their order. Blocks of type "vertex" and "line" are skipped. The
            data arrays are not read.

        Returns
        -------
        TriangleMesh
            All points, with z = 0 if they have two coordinates, and the triangles.

        Raises
        ------
        MeshError
            If the mesh has cells of another type, such as quads or tetrahedra, or no triangles.

        Examples
        --------
        >>> import meshio
        >>> points = [[0, 0], [1, 0], [1, 1], [0, 1]]
        >>> TriangleMesh.from_meshio(meshio.Mesh(points, [("line", [[0, 1]]), ("triangle", [[0, 1, 2], [0, 2, 3]])]))
        TriangleMesh(4 vertices, 2 faces)
        """
        blocks = [block for block in mesh.cells if block.type not in _BELOW_TRIANGLES]
        if others := sorted({block.type for block in blocks} - {"triangle"}):
            raise MeshError(f"the mesh has cells of type {', '.join(others)}; convert it to triangles only")
        points = np.asarray(mesh.points)
        if points.ndim == 2 and points.shape[1] == 2:
            points = np.pad(points, ((0, 0), (0, 1)))
        return cls(points, np.concatenate([np.empty((0, 3), dtype=np.int64), *(block.data for block in blocks)]))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the vertices and faces, in hexadecimal: meshes with equal arrays have equal digests."""
        return hashlib.sha256(self.vertices.tobytes() + self.faces.tobytes()).hexdigest()

    # -- faces ---------------------------------------------------------------------------------------------------------

    @cached_property
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3), in world axes: ``[f, k]`` runs from corner k+1 to corner k+2 of face f."""
        _check_size(self.vertices)
        return frozen(geometry.opposite_edges(self.vertices, self.faces))

    @cached_property
    def face_centers(self) -> Floats:
        """Barycenters of the faces, (m, 3)."""
        return frozen(self.vertices[self.faces].mean(axis=1))

    @cached_property
    def degenerate_faces(self) -> Ints:
        """Faces of zero area up to the rounding of the coordinates, (k,), ascending."""
        return frozen(geometry.degenerate_faces(self.vertices, self.faces, self.opposite_edges, 2 * self.face_areas))

    # -- vertices ------------------------------------------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """Number of vertices n, unreferenced ones included."""
        return len(self.vertices)

    @cached_property
    def corner_signs(self) -> Ints:
        """Sign, ±1, of each face's normal at its corners that orients vertex normals, (m, 3); 0 for duplicate faces."""
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
        """Area-weighted unit normals, (n, 3); zero where the face normals cancel and at unreferenced vertices.

        Face normals are oriented consistently and duplicate faces ignored. On a one-sided surface, normals of
        neighboring vertices may disagree in orientation; see ``edge_signs``.
        """
        sums = geometry.vector_sum(self.area_vectors, self.faces, self.n_vertices, self.corner_signs)
        total = geometry.corner_sum(2 * self.face_areas, self.faces, self.n_vertices)
        return frozen(geometry.mean_directions(sums, total))

    @cached_property
    def vertices_without_normal(self) -> Ints:
        """Vertices with faces that cancel, or have no area; ascending."""
        bare = np.asarray(~self.vertex_normals.any(axis=1))
        bare[self.unreferenced_vertices] = False
        return frozen(np.flatnonzero(bare))

    @cached_property
    def tangent_frames(self) -> Floats:
        """Right-handed orthonormal frames (e1, e2) of the tangent planes at vertices, (n, 2, 3), e1 x e2 = normal.

        e1 is the projected edge from the vertex to the next corner of its lowest-numbered face.
        """
        return frozen(tangent_frames.vertex_frames(self.vertices, self.faces, self.vertex_normals))

    # -- edges and topology --------------------------------------------------------------------------------------------

    @cached_property
    def edge_table(self) -> topology.Edges:
        """Edges and their incidence to faces, in lexicographic order."""
        return topology.unique_edges(self.faces)

    @cached_property
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""
        _check_size(self.vertices)
        return frozen(geometry.distances(self.vertices, self.edges))

    @cached_property
    def edge_signs(self) -> Ints:
        """-1 for edges whose endpoint normals disagree in orientation, else 1, (e,); all 1 if orientable."""
        return frozen(orientation_signs.edge_signs(self.corner_signs, self.edge_table))


def _check(vertices: Floats, faces: Ints) -> None:
    """Raise MeshError unless the arrays describe triangles over finite points."""
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
    """Raise MeshError if squared areas or single-precision coordinates would overflow or underflow."""
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
