"""Robust triangulation: mollification, tufted cover and intrinsic Delaunay flips, for meshes of any quality."""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh, mollified
from geomhw.intrinsic.tufted_cover import tufted_cover
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class RobustTriangulation:
    """An intrinsic Delaunay triangulation with the vertices of a mesh: no cotan weight is negative.

    Attributes
    ----------
    surface : IntrinsicMesh
        Closed and consistently oriented; the tufted cover, two sheets, unless the mesh is closed and oriented itself.
    mollification : float
        Largest length added to an edge, in the units of the mesh.
    flips : int
        Number of edge flips.

    References
    ----------
    Sharp, Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> robust = RobustTriangulation.of(grid(4, 4, width=100))
    >>> robust.surface.sheets, bool(robust.surface.edge_cotan_weights.min() > -1e-12)
    (2, True)
    """

    surface: IntrinsicMesh
    mollification: float
    flips: int

    @classmethod
    def of(cls, mesh: PolyhedralSurface) -> "RobustTriangulation":
        """Triangulate a mesh: mollify its lengths, take its tufted cover if needed, and flip edges.

        Raises
        ------
        MeshError
            If all vertices lie at one point.
        ConvergenceError
            If the flips do not terminate.
        """
        from geomhw.intrinsic.delaunay import intrinsic_delaunay

        surface, growth = mollified(IntrinsicMesh.of(mesh))
        suited = mesh.is_closed and mesh.is_edge_manifold and mesh.is_oriented
        flipped, flips = intrinsic_delaunay(surface if suited else tufted_cover(surface), _position_errors(mesh))
        return cls(flipped, growth, flips)

    def report(self) -> dict[str, float | int]:
        """Return plain JSON values; lengths in the units of the mesh."""
        return {
            "edge_flips": self.flips,
            "sheets": self.surface.sheets,
            "mollification": self.mollification,
            "mean_edge_length": self.surface.mean_edge_length,
        }


def _position_errors(mesh: PolyhedralSurface) -> Floats | None:
    """Return the rounding errors of vertex positions, (n,), or None without coordinates."""
    return np.finfo(float).eps * np.abs(mesh.vertices).max(axis=1) if isinstance(mesh, TriangleMesh) else None
