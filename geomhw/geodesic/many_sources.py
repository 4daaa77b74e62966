"""The heat method for blocks of source vertices [GIH, algorithm 1]: each step on all columns of a block at once.

With A = M + tS and S factored, a block U of heats, (n, k), solves A U = I; one pass over the faces turns it into
Div X, (n, k), of X = -∇u/|∇u|; and the distances solve S Φ = -Div X. The gradient and divergence of a block are a
compiled loop, because arrays of (m, 3, k) would not fit into the cache.
"""

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled
from geomhw.geodesic.edge_path_bound import EdgePathBound
from geomhw.geodesic.heat_step import HeatStep
from geomhw.geodesic.poisson import DistancePoisson
from geomhw.geodesic.unit_field import LEVEL
from geomhw.mesh.geometry import unit
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh


class ManySources:
    """Distances from blocks of source vertices on one surface, by factored systems.

    Parameters
    ----------
    mesh : the mesh in space.
    surface : the mesh, or an intrinsic triangulation of it.
    step, poisson : the systems of the heat method on the surface.
    bound : whether to clamp distances to edge paths and chords.
    """

    def __init__(
        self, mesh: TriangleMesh, surface: PolyhedralSurface, step: HeatStep, poisson: DistancePoisson, bound: bool
    ) -> None:
        self._mesh, self._surface, self._step, self._poisson, self._is_bound = mesh, surface, step, poisson, bound
        self._clamp = EdgePathBound(surface)
        self._hats = _planar_hat_gradients(surface)

    def __call__(self, vertices: Ints) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the distances from k vertices.

        Returns
        -------
        phi : (n, j) array
            Distances, inf on other components.
        accurate : (k,) mask
            The j vertices that have a column. Heat of the others underflows or is zero; `HeatDistance.from_sources`
            scales or refuses them.
        """
        heat, accurate = self._step.from_vertices(vertices)
        if not accurate.all():
            heat, vertices = np.ascontiguousarray(heat[:, accurate]), np.asarray(vertices)[accurate]
        if not len(vertices):
            return heat, accurate
        phi = self._poisson.from_vertices(self._unit_field_divergence(heat), vertices)
        if self._is_bound:
            self._bound(phi, vertices)
        return phi, accurate

    def _unit_field_divergence(self, heat: Floats) -> Floats:
        """Div X of X = -∇u/|∇u|, (n, k), integrated; X is zero on faces where u is constant."""
        surface, div = self._surface, np.zeros_like(heat)
        areas = surface.face_areas
        _add_divergence(surface.faces, self._hats, areas / surface.sheets, np.sqrt(areas), heat, div)
        return div

    def _bound(self, phi: Floats, vertices: Ints) -> None:
        """Clamp φ, (n, k), in place, to edge paths from above and, where not positive, to the chord from below."""
        points = self._mesh.vertices
        reached = np.isfinite(phi)
        phi[~reached] = 0.0
        self._clamp(phi, vertices)
        low = (phi <= 0) & reached
        low[vertices, np.arange(len(vertices))] = False
        vertex, column = np.nonzero(low)
        phi[low] = np.linalg.norm(points[vertex] - points[vertices[column]], axis=1)
        phi[~reached] = np.inf


def _planar_hat_gradients(surface: PolyhedralSurface) -> Floats:
    """Gradients of the corners' hat functions in an orthonormal frame of each face, (m, 3, 2)."""
    first = unit(surface.opposite_edges[:, 0])
    second = np.cross(surface.face_normals, first)
    x = -np.einsum("fkx,fx->fk", surface.opposite_edges, second)
    y = np.einsum("fkx,fx->fk", surface.opposite_edges, first)
    return np.stack([x, y], axis=2) / (2 * surface.face_areas)[:, None, None]


@compiled
def _add_divergence(faces: Ints, hats: Floats, areas: Floats, sizes: Floats, u: Floats, div: Floats) -> None:
    """Add the integrated divergence of -∇u/|∇u| to div, (n, k); u, (n, k), is scaled to order one on each face."""
    for f in range(len(faces)):
        a, b, c = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        ax, bx, cx = hats[f, 0, 0], hats[f, 1, 0], hats[f, 2, 0]
        ay, by, cy = hats[f, 0, 1], hats[f, 1, 1], hats[f, 2, 1]
        for q in range(u.shape[1]):
            ua, ub, uc = u[a, q], u[b, q], u[c, q]
            largest = max(abs(ua), abs(ub), abs(uc))
            inverse = 1.0 / largest if largest > 1e-300 else 0.0
            ua, ub, uc = ua * inverse, ub * inverse, uc * inverse
            x, y = ax * ua + bx * ub + cx * uc, ay * ua + by * ub + cy * uc
            length = np.sqrt(x * x + y * y)
            weight = areas[f] / length if length * sizes[f] >= LEVEL else 0.0
            div[a, q] += weight * (ax * x + ay * y)
            div[b, q] += weight * (bx * x + by * y)
            div[c, q] += weight * (cx * x + cy * y)
