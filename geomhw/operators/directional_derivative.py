"""Tangent fields as operators on functions: the directional derivative [OATVF]."""

from copy import copy

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.gradient import hat_gradients


def face_derivative(mesh: TriangleMesh, field: Floats) -> sp.csr_array:
    """D_V^F, (m, n), units of V/length, strong: f on vertices to V·∇f on faces [OATVF, eq. 5].

    field: V, (m, 3), any normal part has no effect. D_V^F of a constant is zero.
    """
    m = mesh.n_faces
    values = np.einsum("fx,fkx->fk", field, hat_gradients(mesh))
    return sp.csr_array((values.ravel(), mesh.faces.ravel(), np.arange(0, 3 * m + 1, 3)), shape=(m, mesh.n_vertices))


def directional_derivative(mesh: TriangleMesh, field: Floats) -> sp.csr_array:
    """D_V = P D_V^F, (n, n), units of V/length, strong: f to V·∇f, on vertices [OATVF, eq. 7].

    For many fields on one mesh keep a `DirectionalDerivative`.
    """
    return DirectionalDerivative(mesh)(field)


class DirectionalDerivative:
    """D_V on one mesh for many fields: the pattern is found once, and a call makes nothing but values.

    Every matrix that a call returns shares its index arrays with the others.
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
        # From the flux of each corner to the entries that it is part of, in the rows of all corners of its face.
        corners = np.broadcast_to(np.arange(faces.size).reshape(-1, 1, 3), keys.shape).ravel()
        parts = (np.ones(corners.size), (slots.ravel(), corners))
        self._entries = sp.coo_array(parts, shape=(len(pattern), faces.size)).tocsr()

    def weak(self, field: Floats) -> sp.csr_array:
        """M D_V, (n, n), units of V times length: entry ij is the integral of φ_i V·∇φ_j with φ_i averaged per face."""
        flux = self._thirds[:, None] * np.einsum("fx,fkx->fk", field, self._hats)
        return filled(self._pattern, self._entries @ flux.ravel())

    def __call__(self, field: Floats) -> sp.csr_array:
        """D_V, (n, n), strong, for a face field (m, 3); rows of vertices without faces are zero."""
        D = self.weak(field)
        D.data *= self._inverse_mass[self._rows]
        return D


def filled(pattern: sp.csr_array, values: Floats) -> sp.csr_array:
    """A matrix with the entries of another and other values: index arrays are shared and not looked at again."""
    matrix = copy(pattern)
    matrix.data = values
    return matrix
