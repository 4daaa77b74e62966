"""Distances from many vertices, in blocks of them: the steps of `HeatDistance` on all columns of a block at once.

Systems are solved for whole blocks of right-hand sides. Between them, faces are taken in pieces that fit into a cache:
on each, two sparse products with the columns at its vertices, ∇u in the plane of each face, and back to vertices.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.geodesic.edge_path_bound import EdgePathBound
from geomhw.geodesic.heat_step import LEVEL, HeatStep
from geomhw.mesh.geometry import unit
from geomhw.mesh.hilbert_curve import hilbert_keys
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.solvers.auto import LaplaceSolver

#: Sources at once, at most, and numbers in an array of a block: 128 MB.
BLOCK, LARGEST = 64, 1 << 24
#: Faces in a piece.
PIECE = 4096
#: Squares beyond have lost digits, or will.
LEAST_SQUARE = 1e-280


def block_size(n: int) -> int:
    """How many sources are answered at once on n vertices."""
    return max(1, min(BLOCK, LARGEST // n))


class ManySources:
    """Solves for blocks of source vertices on one surface.

    mesh: in space. surface: what heat flows on, the mesh or a triangulation of it. flow, poisson: both factored.
    """

    def __init__(self, mesh: TriangleMesh, surface: PolyhedralSurface, flow: HeatStep, poisson: LaplaceSolver) -> None:
        assert poisson.factored
        self._mesh, self._flow, self._poisson = mesh, flow, poisson.factored
        self._pieces = _pieces(mesh, surface)
        self._bound = EdgePathBound(surface)
        n = mesh.n_vertices
        ones = np.ones(n)
        self._sums = sp.csr_array((ones, (mesh.components, np.arange(n))))
        self._counts = self._sums @ ones

    def __call__(self, vertices: Ints) -> tuple[Floats, NDArray[np.bool_]]:
        """Distances from k vertices, a column each, inf where none can be reached, and for which of these, (k,), there
        are some: the others need scaling, or are refused, and are left to `HeatDistance.from_sources`."""
        heat, sound = self._flow.from_vertices(vertices)
        if not sound.all():
            heat = np.ascontiguousarray(heat[:, sound])
        if not sound.any():
            return heat, sound
        spread = np.zeros_like(heat)
        for piece in self._pieces:
            piece.spread(heat, spread)
        return self._distance(spread, vertices[sound]), sound

    def _distance(self, spread: Floats, vertices: Ints) -> Floats:
        """φ with Sφ = -Div X, zero at the source, at most the distance along edges, and positive elsewhere."""
        mesh, columns = self._mesh, np.arange(len(vertices))
        np.negative(spread, out=spread)
        means = (self._sums @ spread) / self._counts[:, None]
        spread -= means if len(means) == 1 else means[mesh.components]
        phi = self._poisson(spread)
        phi -= phi[vertices, columns]
        phi[vertices, columns] = 0.0
        if len(self._counts) > 1:
            phi[mesh.components[:, None] != mesh.components[vertices]] = 0.0
        self._bound(phi, vertices)
        low = phi <= 0
        low[vertices, columns] = False
        if low.any():
            vertex, column = np.nonzero(low)
            phi[low] = np.linalg.norm(mesh.vertices[vertex] - mesh.vertices[vertices[column]], axis=1)
        if len(self._counts) > 1:
            phi[mesh.components[:, None] != mesh.components[vertices]] = np.inf
        return phi


@dataclass(frozen=True)
class _Piece:
    """Some faces, (p,), of a surface, and the vertices that they touch, (q,).

    corners: (p, 3), by places among these. gradient: (2p, q), both components in the plane of each face, first those
    along the first axis. divergence: (q, 2p), integrated. roots: (p,), square roots of areas.
    """

    vertices: Ints
    corners: Ints
    gradient: sp.csr_array
    divergence: sp.csr_array
    roots: Floats

    def spread(self, heat: Floats, total: Floats) -> None:
        """Add to the integrated divergence, (n, k), that of -∇u/|∇u| on these faces, zero where u is level."""
        u = heat[self.vertices]
        slopes = self.gradient @ u
        x, y = slopes.reshape(2, len(self.corners), -1)
        with np.errstate(invalid="ignore", divide="ignore", under="ignore"):
            square = x * x + y * y
            size = np.sqrt(square)
            if not LEAST_SQUARE < square.min() <= square.max() < 1 / LEAST_SQUARE:  # heat fades to 1e-260
                largest = np.maximum(np.abs(x), np.abs(y))
                largest[largest == 0] = 1.0
                x /= largest
                y /= largest
                length = np.sqrt(x * x + y * y)
                weight, size = -1.0 / length, length * largest
            else:
                weight = np.divide(-1.0, size, out=square)
        self._level_out(weight, size, u)
        x *= weight
        y *= weight
        total[self.vertices] += self.divergence @ slopes

    def _level_out(self, weight: Floats, size: Floats, u: Floats) -> None:
        """Zero the weights of faces on which u is level, or zero; mostly none."""
        # Where the first corner is not far below the largest, this finds all that are, and few others.
        corner = np.abs(u[self.corners[:, 0]])
        face, column = np.nonzero(~(size * self.roots[:, None] >= 2 * LEVEL * corner) | ~np.isfinite(weight))
        if len(face):
            largest = np.abs(u[self.corners[face], column[:, None]]).max(axis=1)
            level = ~(size[face, column] * self.roots[face] >= LEVEL * largest) | (largest == 0)
            weight[face[level], column[level]] = 0.0


def _pieces(mesh: TriangleMesh, surface: PolyhedralSurface) -> list[_Piece]:
    """All faces of a surface with the vertices of a mesh, near ones together."""
    order = np.argsort(hilbert_keys(mesh.vertices)[surface.faces[:, 0]], kind="stable")
    first = unit(surface.opposite_edges[:, 0])
    second = np.cross(surface.face_normals, first)
    # n x e_k / 2A, in the plane: a quarter turn.
    quarter = [
        -np.einsum("fkx,fx->fk", surface.opposite_edges, second),
        np.einsum("fkx,fx->fk", surface.opposite_edges, first),
    ]
    hats = np.stack(quarter) / (2 * surface.face_areas[:, None])
    pieces = []
    for start in range(0, len(order), PIECE):
        faces = order[start : start + PIECE]
        p = len(faces)
        vertices, corners = np.unique(surface.faces[faces], return_inverse=True)
        corners = corners.reshape(p, 3)
        places = np.concatenate([corners, corners]).ravel()
        gradient = sp.csr_array(
            (hats[:, faces].ravel(), places, np.arange(0, 6 * p + 1, 3)), shape=(2 * p, len(vertices))
        )
        areas = surface.face_areas[faces]
        divergence = sp.csr_array(gradient.T * -np.tile(areas / surface.sheets, 2))
        pieces.append(_Piece(vertices, corners, gradient, divergence, np.sqrt(areas)))
    return pieces
