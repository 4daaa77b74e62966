"""The directional derivative of functions along a tangent field, as an operator [OATVF].

On faces D_V^F = diag(V) G (eq. 5), (D_V^F f)_F = V_F · (∇f)_F; at vertices D_V = P D_V^F (eq. 7), where P takes the
area-weighted mean over the faces at a vertex.
"""

from copy import copy

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import hat_gradients


def face_derivative(mesh: TriangleMesh, field: Floats) -> sp.csr_array:
    """Assemble D_V^F, from functions at vertices to V · ∇f on faces.

    Parameters
    ----------
    field : V, (m, 3), one vector per face in world axes; a normal part has no effect.

    Returns
    -------
    (m, n) sparse array, units of V/length, strong. Rows sum to zero.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    [OATVF, eq. 5]
    """
    m = mesh.n_faces
    values = np.einsum("fx,fkx->fk", field, hat_gradients(mesh))
    return sp.csr_array((values.ravel(), mesh.faces.ravel(), np.arange(0, 3 * m + 1, 3)), shape=(m, mesh.n_vertices))


def directional_derivative(mesh: TriangleMesh, field: Floats) -> sp.csr_array:
    """Assemble D_V = P D_V^F, from functions at vertices to V · ∇f at vertices.

    For many fields on one mesh keep a `DirectionalDerivative`.

    Parameters
    ----------
    field : V, (m, 3), as in `face_derivative`.

    Returns
    -------
    (n, n) sparse array, units of V/length, strong. Rows sum to zero.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    [OATVF, eq. 7]

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(4, 4)
    >>> D = directional_derivative(mesh, np.tile([2.0, 0.0, 0.0], (mesh.n_faces, 1)))
    >>> (D @ mesh.vertices[:, 0])[:3].round(12)
    array([2., 2., 2.])
    """
    return DirectionalDerivative(mesh)(field)


class DirectionalDerivative:
    """D_V on one mesh for many fields: finds the sparsity pattern once, and computes only values in a call.

    All matrices share their index arrays.

    Raises
    ------
    MeshError
        If a face has zero area.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._hats = hat_gradients(mesh)
        self._thirds = mesh.face_areas / 3
        areas = mesh.vertex_areas
        self._inverse_mass = np.divide(1.0, areas, out=np.zeros_like(areas), where=areas > 0)
        n, faces = mesh.n_vertices, mesh.faces.astype(np.int64)
        keys = faces[:, :, None] * n + faces[:, None, :]
        pattern, slots = np.unique(keys, return_inverse=True)
        self._rows = pattern // n
        starts = np.searchsorted(self._rows, np.arange(n + 1)).astype(np.int32)
        columns = (pattern % n).astype(np.int32)
        self._pattern = sp.csr_array((np.zeros(len(pattern)), columns, starts), shape=(n, n))
        # Adds the flux of each corner to the entries in its column and the rows of all corners of its face.
        corners = np.broadcast_to(np.arange(faces.size).reshape(-1, 1, 3), keys.shape).ravel()
        parts = (np.ones(corners.size), (slots.ravel(), corners))
        self._entries = sp.coo_array(parts, shape=(len(pattern), faces.size)).tocsr()

    def weak(self, field: Floats) -> sp.csr_array:
        """Return M D_V for a field V, (m, 3).

        Returns
        -------
        (n, n) sparse array, units of V times length, integrated: entry (i, j) is the sum of A/3 V · ∇φ_j over the faces
        at vertex i, with areas A.
        """
        flux = self._thirds[:, None] * np.einsum("fx,fkx->fk", field, self._hats)
        return filled(self._pattern, self._entries @ flux.ravel())

    def __call__(self, field: Floats) -> sp.csr_array:
        """Return D_V, (n, n), strong, for a field V, (m, 3); rows of vertices without faces are zero."""
        D = self.weak(field)
        D.data *= self._inverse_mass[self._rows]
        return D


def filled(pattern: sp.csr_array, values: Floats) -> sp.csr_array:
    """Return a matrix with the index arrays of another, shared and not checked again, and other values."""
    matrix = copy(pattern)
    matrix.data = values
    return matrix
