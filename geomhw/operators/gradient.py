"""Gradient and divergence of piecewise-linear functions and piecewise-constant fields."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, pieces
from geomhw.mesh.geometry import at_corners, corner_sum, cross
from geomhw.mesh.polyhedral import PolyhedralSurface


def hat_gradients(mesh: PolyhedralSurface) -> Floats:
    """Gradient of each corner's hat function, (m, 3, 3), units 1/length: ``[f, k]`` is n x e_k / 2A on face f.

    In the axes of ``opposite_edges``: the world's for a `TriangleMesh`, the face's own for an `IntrinsicMesh`.
    MeshError if a face has no area.
    """
    mesh.require_area()
    turned = np.cross(mesh.face_normals[:, None, :], mesh.opposite_edges)
    return np.asarray(turned / (2 * mesh.face_areas)[:, None, None])


def gradient(mesh: PolyhedralSurface) -> sp.csr_array:
    """Piecewise-linear gradient, (3m, n), units 1/length [GIH, sec. 3.2.1].

    Row 3f+k is component k, in the axes of `hat_gradients`, on face f: ``(G @ u).reshape(-1, 3)`` is per face.
    """
    m = mesh.n_faces
    values = hat_gradients(mesh).transpose(0, 2, 1)
    columns = np.broadcast_to(mesh.faces[:, None, :], (m, 3, 3))
    starts = np.arange(0, 9 * m + 1, 3)
    return sp.csr_array((values.ravel(), columns.ravel(), starts), shape=(3 * m, mesh.n_vertices))


def divergence(mesh: PolyhedralSurface) -> sp.csr_array:
    """Integrated (weak) divergence of a face field, (n, 3m), units length [GIH, sec. 3.2.1].

    Div = -GᵀA: row i is minus the integral of ∇φ_i · X, positive where the field spreads, with no flux through a
    boundary. ``Div @ G == -stiffness``. Divide by ``mesh.vertex_areas`` for the pointwise divergence.
    """
    return (gradient(mesh).T * -np.repeat(mesh.face_areas / mesh.sheets, 3)).tocsr()


def gradient_of(mesh: PolyhedralSurface, u: Floats) -> Floats:
    """Gradient on each face, (m, 3), of the linear function with these values at vertices, (n,).

    `gradient` without the matrix. MeshError if a face has no area.
    """
    mesh.require_area()
    slopes = np.empty((3, mesh.n_faces)).T
    for faces in pieces(mesh.n_faces):
        slopes[faces] = slopes_on(mesh, faces, at_corners(u, mesh.faces[faces]))
    return slopes


def slopes_on(mesh: PolyhedralSurface, faces: slice, corners: Floats) -> Floats:
    """Gradient on some faces, (k, 3), of linear functions with these values at their corners, (k, 3), where those of
    one vertex may differ; zero on a face without area."""
    # With N = 2A n: n x e_k / 2A = N x e_k / N²
    normals, flat = mesh.area_vectors[faces], mesh.degenerate_faces
    squares = np.einsum("fx,fx->f", normals, normals)
    squares[flat[slice(*np.searchsorted(flat, [faces.start, faces.stop]))] - faces.start] = np.inf
    slopes = cross(normals, np.einsum("fk,fkx->fx", corners, mesh.opposite_edges[faces]))
    slopes /= squares[:, None]
    return slopes


def divergence_of(mesh: PolyhedralSurface, field: Floats) -> Floats:
    """`divergence` applied to one face field, (m, 3), without the matrix: (n,), units of the field times length."""
    # A ∇φ_k · X = (N x e_k) · X / 4A = (X x N) · e_k / 4A
    spread = np.empty((mesh.n_faces, 3))
    for faces in pieces(mesh.n_faces):
        areas = mesh.face_areas[faces]
        turned = cross(field[faces], mesh.area_vectors[faces])
        turned *= np.divide(-0.25 / mesh.sheets, areas, out=np.zeros_like(areas), where=areas > 0)[:, None]
        np.einsum("fkx,fx->fk", mesh.opposite_edges[faces], turned, out=spread[faces])
    return corner_sum(spread, mesh.faces, mesh.n_vertices)
