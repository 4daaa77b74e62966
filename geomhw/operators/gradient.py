"""Gradient of piecewise-linear functions."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, pieces
from geomhw.mesh.geometry import at_corners, cross
from geomhw.mesh.polyhedral import PolyhedralSurface


def hat_gradients(mesh: PolyhedralSurface) -> Floats:
    """Return the gradient of each corner's hat function, n x e_k / 2A.

    Returns
    -------
    (m, 3, 3) array, units 1/length. ``[f, k]`` is the gradient on face f of the hat function of its corner k, in the
    axes of ``opposite_edges``: world axes for a `TriangleMesh`, axes of the face for an `IntrinsicMesh`.

    Raises
    ------
    MeshError
        If a face has zero area.
    """
    mesh.require_area()
    turned = np.cross(mesh.face_normals[:, None, :], mesh.opposite_edges)
    return np.asarray(turned / (2 * mesh.face_areas)[:, None, None])


def gradient(mesh: PolyhedralSurface) -> sp.csr_array:
    """Assemble the piecewise-linear gradient G.

    Returns
    -------
    (3m, n) sparse array, units 1/length, strong. Row 3f+k is component k, in the axes of `hat_gradients`, on face f:
    ``(G @ u).reshape(-1, 3)`` is one vector per face.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    [GIH, sec. 3.2.1]

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(4, 4)
    >>> (gradient(mesh) @ mesh.vertices[:, 0]).reshape(-1, 3)[0].round(12) + 0.0
    array([1., 0., 0.])
    """
    m = mesh.n_faces
    values = hat_gradients(mesh).transpose(0, 2, 1)
    columns = np.broadcast_to(mesh.faces[:, None, :], (m, 3, 3))
    starts = np.arange(0, 9 * m + 1, 3)
    return sp.csr_array((values.ravel(), columns.ravel(), starts), shape=(3 * m, mesh.n_vertices))


def gradient_of(mesh: PolyhedralSurface, u: Floats) -> Floats:
    """Apply `gradient` to one function without assembling the matrix.

    Parameters
    ----------
    u : (n,) array, values at vertices.

    Returns
    -------
    (m, 3) array, units of u per length: one vector per face.

    Raises
    ------
    MeshError
        If a face has zero area.
    """
    mesh.require_area()
    gradients = np.empty((3, mesh.n_faces)).T
    for faces in pieces(mesh.n_faces):
        gradients[faces] = corner_gradients(mesh, faces, at_corners(u, mesh.faces[faces]))
    return gradients


def corner_gradients(mesh: PolyhedralSurface, faces: slice, corners: Floats) -> Floats:
    """Gradient on the faces of a slice, (k, 3), from values at their corners, (k, 3); zero on a face of zero area.

    Values of one vertex may differ from face to face.
    """
    # With N = 2A n: n x e_k / 2A = N x e_k / N²
    normals, flat = mesh.area_vectors[faces], mesh.degenerate_faces
    squares = np.einsum("fx,fx->f", normals, normals)
    squares[flat[slice(*np.searchsorted(flat, [faces.start, faces.stop]))] - faces.start] = np.inf
    gradients = cross(normals, np.einsum("fk,fkx->fx", corners, mesh.opposite_edges[faces]))
    gradients /= squares[:, None]
    return gradients
