"""Averages between faces and vertices: P takes faces to vertices, Q vertices to faces."""

import numpy as np
import scipy.sparse as sp

from geomhw.mesh.triangle_mesh import TriangleMesh


def faces_to_vertices(mesh: TriangleMesh) -> sp.csr_array:
    """Assemble P: the area-weighted mean over the faces round each vertex.

    Returns
    -------
    (n, m) sparse array, dimensionless. Rows sum to one; the row of a vertex without faces, or with faces of zero area
    only, is empty.

    References
    ----------
    [OATVF, eq. 6]
    """
    m = mesh.n_faces
    third = np.repeat(mesh.face_areas / 3, 3)
    corners = mesh.faces.ravel()
    total = mesh.vertex_areas[corners]
    weights = np.divide(third, total, out=np.zeros_like(third), where=total > 0)
    return sp.coo_array((weights, (corners, np.repeat(np.arange(m), 3))), shape=(mesh.n_vertices, m)).tocsr()


def vertices_to_faces(mesh: TriangleMesh) -> sp.csr_array:
    """Assemble Q: the mean of the three corners of each face.

    Returns
    -------
    (m, n) sparse array, dimensionless. Rows sum to one.
    """
    m = mesh.n_faces
    thirds = np.full(3 * m, 1 / 3)
    return sp.csr_array((thirds, mesh.faces.ravel(), np.arange(0, 3 * m + 1, 3)), shape=(m, mesh.n_vertices))
