"""A mesh made fit for cotan weights, whatever its faces are like."""

from dataclasses import dataclass

from geomhw.intrinsic.delaunay import DelaunayFlips
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh, mollified
from geomhw.intrinsic.tufted_cover import tufted_cover
from geomhw.mesh.polyhedral import PolyhedralSurface


@dataclass(frozen=True, eq=False)
class RobustTriangulation:
    """An intrinsic Delaunay triangulation with the vertices of a mesh, and what it took.

    surface: closed, oriented, without negative cotan weights; both sides of the mesh if it is not closed and oriented
    itself. mollification: the length added to every edge. flips, rounds: edges flipped, and in how many sets of
    independent ones.
    """

    surface: IntrinsicMesh
    mollification: float
    flips: int
    rounds: int

    @classmethod
    def of(cls, mesh: PolyhedralSurface) -> "RobustTriangulation":
        """Lengths mollified, both sides taken where the mesh has a boundary, no orientation or more than two faces at
        an edge, and edges flipped. ConvergenceError if the flips do not come to an end."""
        surface, growth = mollified(IntrinsicMesh.of(mesh))
        suited = mesh.is_closed and mesh.is_edge_manifold and mesh.is_oriented
        flipped = DelaunayFlips(surface if suited else tufted_cover(surface))
        return cls(flipped.surface, growth, flipped.flips, flipped.rounds)

    def report(self) -> dict[str, float | int]:
        """Plain values for a report; lengths in the units of the file."""
        return {
            "edge_flips": self.flips,
            "flip_rounds": self.rounds,
            "sheets": self.surface.sheets,
            "mollification": self.mollification,
            "mean_edge_length": self.surface.mean_edge_length,
        }
