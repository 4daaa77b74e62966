"""Where tangent vectors diffuse: an orientable cover of a mesh, a triangulation of it, and the connection Laplacian."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Floats
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.orientation import orientation_cover, without_duplicate_faces
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import pinched_vertices
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.parallel_transport import from_complex, to_complex
from geomhw.options import Connection
from geomhw.transport.source_vectors import spread_to_corners


class TangentDomain:
    """What vector diffusion needs of a mesh, for any time: built once.

    cover: the mesh, consistently oriented; where it is one-sided, its orientation cover, on which both vertices of one
    place carry the same vector. surface: the cover, or its robust triangulation. K: connection stiffness, (n, n),
    complex Hermitian, in the frames of the cover.
    """

    def __init__(self, mesh: TriangleMesh, connection: Connection = "normals", robust: bool = False) -> None:
        self.mesh, self.connection = mesh, connection
        self.cover = orientation_cover(mesh)
        self.robust = RobustTriangulation.of(self.cover) if robust else None
        self.surface: PolyhedralSurface = self.robust.surface if self.robust else self.cover
        self.surface.require_area("robust=True")
        self.K: sp.csr_array = complex_connection_stiffness(
            self.cover, connection, self.robust.surface if self.robust else None
        )

    @cached_property
    def crossings(self) -> dict[str, int]:
        """Number of edges and of vertices without a tangent plane, for a report; without zeros."""
        single = without_duplicate_faces(self.mesh)
        edges = int(np.count_nonzero(single.edge_table.face_counts > 2))
        vertices = len(pinched_vertices(single.faces, single.edge_table))
        counts = {"non_manifold_edges": edges, "non_manifold_vertices": vertices}
        return {name: count for name, count in counts.items() if count}

    def source_field(self, sources: SurfacePoints, tangent: Floats) -> Complexes:
        """Y0 on the cover, from tangent vectors at sources, (k, 3)."""
        y0 = spread_to_corners(self.mesh, sources, tangent)
        if self.cover is self.mesh:
            return y0
        return to_complex(self.cover, self.lifted(from_complex(self.mesh, y0)))

    def impulse(self, sources: SurfacePoints, values: Floats | float = 1.0) -> Floats:
        """`SurfacePoints.impulse` on the cover."""
        return self.lifted(sources.impulse(self.mesh.n_vertices, values))

    def lifted(self, values: Floats) -> Floats:
        """Values per vertex of the mesh as values per vertex of the cover."""
        times = self.cover.n_vertices // self.mesh.n_vertices
        return np.concatenate([values] * times) if times > 1 else values

    def vectors(self, z: Complexes) -> Floats:
        """Tangent vectors, (n, 3), at the vertices of the mesh, from complex numbers on the cover."""
        return from_complex(self.cover, z)[: self.mesh.n_vertices]
