"""Where tangent vectors diffuse: an orientable cover of a mesh, a triangulation of it, and the connection Laplacian."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Complexes, Floats, Ints, ranges
from geomhw.intrinsic.robust import RobustTriangulation
from geomhw.mesh.cut import cut_into_sheets
from geomhw.mesh.orientation import orientation_cover, without_duplicate_faces
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.topology import vertex_components
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.connection_laplacian import complex_connection_stiffness
from geomhw.operators.parallel_transport import from_complex, to_complex
from geomhw.options import Connection
from geomhw.transport.source_vectors import spread_to_corners


class TangentDomain:
    """What vector diffusion needs of a mesh, for any time: built once.

    base: the mesh, cut into sheets, with n' vertices. cover: the base, consistently oriented; where it is
    one-sided, its orientation cover, on which both vertices of one place carry the same vector. surface: the cover, or
    its robust triangulation. K: connection stiffness, complex Hermitian, in the frames of the cover.
    """

    def __init__(self, mesh: TriangleMesh, connection: Connection = "normals", robust: bool = False) -> None:
        self.mesh, self.connection = mesh, connection
        self.base, self._original = cut_into_sheets(mesh)
        self.cover = orientation_cover(self.base)
        self.robust = RobustTriangulation.of(self.cover) if robust else None
        self.surface: PolyhedralSurface = self.robust.surface if self.robust else self.cover
        self.surface.require_area("robust=True")
        self.K: sp.csr_array = complex_connection_stiffness(
            self.cover, connection, self.robust.surface if self.robust else None
        )

    @cached_property
    def crossings(self) -> dict[str, int]:
        """Numbers of what vectors do not pass, for a report; no zeros.

        These are edges of more than two faces, other vertices with several fans, and vertices without a normal, which
        the intrinsic connection passes.
        """
        single = without_duplicate_faces(self.mesh)
        edges = single.edges[single.edge_table.face_counts > 2]
        vertices = np.setdiff1d(self._original[self.mesh.n_vertices :], edges)
        counts = {
            "non_manifold_edges": len(edges),
            "non_manifold_vertices": len(vertices),
            "vertices_without_normal": len(self.cover.vertices_without_normal)
            * self.base.n_vertices
            // self.cover.n_vertices,
        }
        return {name: count for name, count in counts.items() if count}

    @cached_property
    def bare(self) -> Ints:
        """Vertices of the cover that vectors do not pass, since the connection has no tangent plane there."""
        return self.cover.vertices_without_normal if self.connection == "normals" else np.empty(0, dtype=np.int64)

    def unreached(self, impulse: Floats) -> NDArray[np.bool_]:
        """Return a mask of the vertices of the cover which no vector from the support of an impulse reaches.

        Vertices without faces or without a normal are not among them.
        """
        surface, labels = self.surface, self.surface.components
        if len(self.bare):
            passing = ~np.isin(surface.edges, self.bare).any(axis=1)
            labels = vertex_components(surface.edges[passing], surface.n_vertices)
        unreached = ~np.isin(labels, labels[np.flatnonzero(impulse)])
        unreached[surface.unreferenced_vertices] = False
        unreached[self.bare] = False
        return np.asarray(unreached)

    def split(self, sources: SurfacePoints) -> tuple[SurfacePoints, Ints]:
        """The sources on the base, at a vertex with several fans once for each, and the source of each."""
        if self.base is self.mesh:
            return sources, np.arange(len(sources))
        return sources_on_sheets(sources, self.base, self._original)

    def source_field(self, sources: SurfacePoints, tangent: Floats) -> Complexes:
        """Y0 on the cover, from tangent vectors at sources on the base, (k, 3)."""
        y0 = spread_to_corners(self.base, sources, tangent)
        if self.cover is self.base:
            return y0
        return to_complex(self.cover, self._lifted(from_complex(self.base, y0)))

    def impulse(self, sources: SurfacePoints, values: Floats | float = 1.0) -> Floats:
        """`SurfacePoints.impulse` on the cover, from sources on the base."""
        return self._lifted(sources.impulse(self.base.n_vertices, values))

    def lifted(self, values: Floats) -> Floats:
        """Values per vertex of the mesh as values per vertex of the cover."""
        return self._lifted(values[self._original])

    def _lifted(self, values: Floats) -> Floats:
        """Values per vertex of the base as values per vertex of the cover."""
        times = self.cover.n_vertices // self.base.n_vertices
        return np.concatenate([values] * times) if times > 1 else values

    def answering(self, log: Floats, z: Complexes | None = None) -> Ints:
        """Return the vertex of the cover that answers for each vertex of the mesh, (n,), as `answering_copies`."""
        n, count = self.mesh.n_vertices, self.base.n_vertices
        if self.base is self.mesh:
            return np.arange(n)
        vectors = None if z is None else from_complex(self.cover, z)[:count]
        return answering_copies(self._original, log[:count], vectors)

    def vectors(self, z: Complexes, where: Ints) -> Floats:
        """Tangent vectors, (n, 3), at vertices of the cover, from complex numbers on it; zero without a normal."""
        vectors = from_complex(self.cover, z)
        vectors[self.cover.vertices_without_normal] = 0.0
        return vectors[where]


def sources_on_sheets(sources: SurfacePoints, base: TriangleMesh, original: Ints) -> tuple[SurfacePoints, Ints]:
    """Return sources on a mesh cut into sheets, at a vertex with several fans once for each, and the source of each.

    base, original : as `cut_into_sheets` returns them.
    """
    copies, inside = np.bincount(original), sources.faces >= 0
    count = np.where(inside, 1, copies[sources.corners[:, 0]])
    source = np.repeat(np.arange(len(sources)), count)
    number = ranges(np.zeros_like(count), count)
    fans = sources[source]
    corners, inside = fans.corners.copy(), inside[source]
    corners[inside] = base.faces[fans.faces[inside]]
    start = np.cumsum(copies) - copies
    vertices = np.argsort(original, kind="stable")[start[corners[~inside, 0]] + number[~inside]]
    corners[~inside] = vertices[:, None]
    return SurfacePoints(fans.faces, corners, fans.weights), source


def answering_copies(original: Ints, log: Floats, vectors: Floats | None = None) -> Ints:
    """Return the copy that answers for each vertex: that of the largest size, given by its logarithm.

    Of equal ones it is that with the lexicographically largest vector, so that the numbering does not matter.
    """
    if (np.diff(original) > 0).all():  # one of each
        return np.arange(len(original))
    keys = np.round(log, 9)[None]
    if vectors is not None:
        keys = np.concatenate([keys, np.round(vectors.T, 9)])
    order = np.lexsort((*-keys[::-1], original))
    return order[np.unique(original[order], return_index=True)[1]]
