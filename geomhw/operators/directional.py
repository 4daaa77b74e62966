"""Tangent fields as operators on functions: the directional derivative [OATVF]."""

import numpy as np
import scipy.sparse as sp

from geomhw.mesh.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.averaging import faces_to_vertices
from geomhw.operators.gradient import hat_gradients


def face_derivative(mesh: TriangleMesh, field: Floats) -> sp.csr_array:
    """D_V^F, (m, n), units of V/length, strong: f on vertices to V·∇f on faces [OATVF, eq. 5].

    field: V, (m, 3), any normal part has no effect. D_V^F of a constant is zero.
    """
    m = mesh.n_faces
    values = np.einsum("fx,fkx->fk", field, hat_gradients(mesh))
    return sp.csr_array((values.ravel(), mesh.faces.ravel(), np.arange(0, 3 * m + 1, 3)), shape=(m, mesh.n_vertices))


def directional_derivative(mesh: TriangleMesh, field: Floats) -> sp.csr_array:
    """D_V = P D_V^F, (n, n), units of V/length, strong: f to V·∇f, on vertices [OATVF, eq. 7]."""
    return faces_to_vertices(mesh) @ face_derivative(mesh, field)
