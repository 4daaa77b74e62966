"""A surface known by the lengths of its edges alone, and the least lengthening that gives every face an area."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomhw.arrays import Floats, Ints, frozen
from geomhw.errors import MeshError
from geomhw.mesh import geometry
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.topology import Edges

#: Least excess of two sides of a face over the third, in mean edge lengths [Sharp, Crane 2020, sec. 4.5].
LEAST_EXCESS = 1e-5


@dataclass(frozen=True, eq=False)
class IntrinsicMesh(PolyhedralSurface):
    """Flat triangles glued along edges of given length, a Δ-complex: two edges may join the same vertices, or one
    vertex to itself, and a face may be glued to itself.

    vertex_count: n. faces: (m, 3) vertex indices. gluing: which edges the faces share; its order is free. lengths:
    (e,), positive. sheets: 2 where the faces are both sides of a mesh. Each face is laid out in a plane of its own,
    z = 0, with the edge opposite its first corner along x.
    """

    vertex_count: int
    faces: Ints
    gluing: Edges
    lengths: Floats
    sheets: int = 1

    @classmethod
    def of(cls, surface: PolyhedralSurface) -> "IntrinsicMesh":
        """The same surface without its place in space."""
        return cls(surface.n_vertices, surface.faces, surface.edge_table, surface.edge_lengths, surface.sheets)

    @property
    def n_vertices(self) -> int:
        """Number of vertices n."""
        return self.vertex_count

    @property
    def edge_table(self) -> Edges:
        """Edges with their incidence to faces."""
        return self.gluing

    @property
    def edge_lengths(self) -> Floats:
        """Lengths of ``edges``, (e,)."""
        return self.lengths

    @cached_property
    def opposite_edges(self) -> Floats:
        """Edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f, as laid out; z is zero."""
        base, right, left = self.lengths[self.gluing.of_faces].T
        x, y = geometry.apex(base, left, right)
        corners = np.zeros((self.n_faces, 3, 3))
        corners[:, 0, 0], corners[:, 0, 1], corners[:, 2, 0] = x, y, base
        return frozen(geometry.between_corners(corners))

    @cached_property
    def degenerate_faces(self) -> Ints:
        """Faces whose sides do not close to a triangle with an area, as far as rounding can tell, ascending."""
        lost = geometry.ROUNDING_UNITS * np.finfo(float).eps * self.lengths[self.gluing.of_faces].max(axis=1) ** 2
        return frozen(np.flatnonzero(2 * self.face_areas <= lost))


def mollified(surface: IntrinsicMesh) -> tuple[IntrinsicMesh, float]:
    """The surface with ε added to every length, and ε: the least for which two sides of a face exceed the third by
    1e-5 h [Sharp, Crane 2020, sec. 4.5]. Where they do already, ε is 0 and nothing changes. MeshError if h is zero.

    Each component has an ε and an h of its own, for a small one knows nothing of a large one; that returned is the
    largest.

    Sharp, Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020.
    """
    if surface.mean_edge_length == 0:
        raise MeshError("all vertices of faces lie in one point: there is no surface to measure")
    sides = surface.lengths[surface.gluing.of_faces]
    of_edges, of_faces = surface.components[surface.edges[:, 0]], surface.components[surface.faces[:, 0]]
    counts = np.bincount(of_edges)
    h = np.bincount(of_edges, surface.lengths) / np.maximum(counts, 1)
    h[h == 0] = surface.mean_edge_length  # a component in one point has no scale of its own
    excess = np.full(len(counts), np.inf)
    np.minimum.at(excess, of_faces, sides.sum(axis=1) - 2 * sides.max(axis=1))
    growth = np.maximum(0.0, LEAST_EXCESS * h - excess)
    if not growth.any():
        return surface, 0.0
    return replace(surface, lengths=frozen(surface.lengths + growth[of_edges])), float(growth.max())
