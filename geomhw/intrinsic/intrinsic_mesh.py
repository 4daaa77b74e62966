"""Intrinsic meshes, given by edge lengths, and intrinsic mollification of degenerate faces."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomhw.arrays import Floats, Ints, frozen
from geomhw.errors import MeshError
from geomhw.mesh import geometry
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import Edges

#: Smallest excess of two sides of a face over the third, in mean edge lengths [Sharp, Crane 2020, sec. 4.5].
LEAST_EXCESS = 1e-5


@dataclass(frozen=True, eq=False)
class IntrinsicMesh(PolyhedralSurface):
    """A Δ-complex of flat triangles with given edge lengths and without coordinates.

    Two edges may join the same vertices, an edge may join a vertex to itself, and a face may be glued to itself.
    Vectors on a face refer to its layout in the plane z = 0, with the edge opposite corner 0 along x.

    Attributes
    ----------
    vertex_count : int
        Number of vertices n.
    faces : (m, 3) integer array
        Vertex indices.
    gluing : Edges
        Edges and their incidence to faces, in any order.
    lengths : (e,) array
        Positive edge lengths.
    sheets : int
        2 for a tufted cover, else 1.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> ball = icosphere(2)
    >>> bool(np.allclose(IntrinsicMesh.of(ball).face_areas, ball.face_areas))
    True
    """

    vertex_count: int
    faces: Ints
    gluing: Edges
    lengths: Floats
    sheets: int = 1

    @classmethod
    def of(cls, surface: PolyhedralSurface) -> "IntrinsicMesh":
        """Take the connectivity and edge lengths of a surface."""
        return cls(surface.n_vertices, surface.faces, surface.edge_table, surface.edge_lengths, surface.sheets)

    @property
    def n_vertices(self) -> int:
        """Number of vertices n, unreferenced ones included."""
        return self.vertex_count

    @property
    def edge_table(self) -> Edges:
        """Edges and their incidence to faces: ``gluing``."""
        return self.gluing

    @property
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""
        return self.lengths

    @cached_property
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3), in the layout of each face: ``[f, k]`` runs from corner k+1 to corner k+2; z = 0."""
        base, right, left = self.lengths[self.gluing.of_faces].T
        x, y = geometry.apex(base, left, right)
        edges = np.zeros((3, 3, self.n_faces))
        edges[0, 0], edges[1, 0], edges[1, 1], edges[2, 0], edges[2, 1] = base, x - base, y, -x, -y
        return frozen(edges.transpose(2, 0, 1))

    @cached_property
    def degenerate_faces(self) -> Ints:
        """Faces of zero area up to rounding, or whose sides violate the triangle inequality, (k,), ascending."""
        lost = geometry.ROUNDING_UNITS * np.finfo(float).eps * self.lengths[self.gluing.of_faces].max(axis=1) ** 2
        return frozen(np.flatnonzero(2 * self.face_areas <= lost))


def mollified(surface: IntrinsicMesh) -> tuple[IntrinsicMesh, float]:
    """Add the smallest ε to all edge lengths for which two sides of each face exceed the third by 1e-5 h.

    Each connected component has its own ε and mean edge length h.

    Returns
    -------
    surface : IntrinsicMesh
        The surface with the new lengths; the same object if ε is 0 everywhere.
    growth : float
        The largest ε, in the units of the lengths.

    Raises
    ------
    MeshError
        If all edges have length zero.

    References
    ----------
    Sharp, Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020, sec. 4.5.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> mollified(IntrinsicMesh.of(icosphere(2)))[1]
    0.0
    """
    if surface.mean_edge_length == 0:
        raise MeshError("all vertices lie in one point: the surface has no area")
    sides = surface.lengths[surface.gluing.of_faces]
    of_edges, of_faces = surface.components[surface.edges[:, 0]], surface.components[surface.faces[:, 0]]
    counts = np.bincount(of_edges)
    h = np.bincount(of_edges, surface.lengths) / np.maximum(counts, 1)
    h[h == 0] = surface.mean_edge_length  # a component at one point has no scale of its own
    excess = np.full(len(counts), np.inf)
    np.minimum.at(excess, of_faces, sides.sum(axis=1) - 2 * sides.max(axis=1))
    growth = np.maximum(0.0, LEAST_EXCESS * h - excess)
    if not growth.any():
        return surface, 0.0
    return replace(surface, lengths=frozen(surface.lengths + growth[of_edges])), float(growth.max())
