"""Farthest-point sampling: each next vertex is the one farthest from those before, by exact distance.

Gonzalez: Clustering to Minimize the Maximum Intercluster Distance. Theor. Comput. Sci. 38, 1985.
"""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.geodesic.exact import ExactDistance
from geomhw.geodesic.growing_sources import GrowingSources
from geomhw.mesh.named_points import default_source, vertex_points
from geomhw.mesh.surface_points import SurfacePoints
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Distances that agree up to this share are equal.
EQUAL = 1e-10


@dataclass(frozen=True, eq=False)
class Samples:
    """Sample points on a surface.

    Attributes
    ----------
    points : SurfacePoints
        In the order in which they were chosen.
    gaps : (k,) array
        Distance of each point from the nearest of those before; inf on a component without any, and at the first.
    radius : float
        Largest distance of a vertex from the nearest point; inf if a component has none.
    """

    points: SurfacePoints
    gaps: Floats
    radius: float

    @property
    def spacing(self) -> float:
        """Least distance between two points; inf if no two are connected."""
        return float(self.gaps.min(initial=np.inf))


def farthest_points(
    mesh: TriangleMesh, count: int | None = None, spacing: float = 0.0, first: int | None = None
) -> Samples:
    """Choose vertices, each the farthest from all before it; of equally far ones, that of the lowest index.

    A component without a sample is infinitely far.

    Parameters
    ----------
    mesh : any triangle mesh.
    count : number of points; by default as many as the spacing needs.
    spacing : length. No point is chosen that is nearer to another one; without ``count``, all vertices are nearer than
        this to a point at the end.
    first : the first vertex; by default that of largest y.

    Raises
    ------
    ArgumentError
        If neither a count nor a spacing above 0 is given, or there are fewer distinct places than points.

    References
    ----------
    Gonzalez: Clustering to Minimize the Maximum Intercluster Distance. Theor. Comput. Sci. 38, 1985.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> farthest_points(grid(2, 2), 4, first=0).points.vertices.tolist()
    [0, 8, 2, 6]
    """
    if (count is None and not spacing > 0) or (count is not None and count < 1):
        raise ArgumentError("samples need a count of at least 1 or a spacing above 0")
    v = default_source(mesh) if first is None else int(vertex_points(mesh, [first]).vertices[0])
    used = np.setdiff1d(np.arange(mesh.n_vertices), mesh.unreferenced_vertices)
    grown = GrowingSources(ExactDistance(mesh), all_vertices(mesh))
    chosen, gaps, far = list[int](), list[float](), np.inf
    while len(chosen) < (count or len(used)) and far >= spacing and far > 0:
        chosen.append(v)
        gaps.append(float(far))
        grown.add(v)
        left = grown.distance[used]
        far = left.max()
        v = int(used[np.argmax(left >= far * (1 - EQUAL))])
    if count and len(chosen) < count and not spacing > 0:
        raise ArgumentError(f"the mesh has only {len(chosen)} distinct vertices, fewer than {count} points")
    return Samples(vertex_points(mesh, chosen), np.array(gaps), float(far))


def all_vertices(mesh: TriangleMesh) -> SurfacePoints:
    """All vertices as points, also those without faces."""
    n: int = mesh.n_vertices
    corners: Ints = np.repeat(np.arange(n)[:, None], 3, axis=1)
    return SurfacePoints(np.full(n, -1), corners, np.tile([1.0, 0.0, 0.0], (n, 1)))
