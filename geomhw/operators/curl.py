"""Curl of piecewise-constant vector fields: minus the divergence of the field after a quarter turn."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.divergence import divergence


def quarter_turn(mesh: TriangleMesh, field: Floats) -> Floats:
    """Return n x V per face, (m, 3): the field turned by a right angle, counterclockwise seen from outside."""
    return np.cross(mesh.face_normals, field)


def curl(mesh: TriangleMesh) -> sp.csr_array:
    """Assemble the integrated curl of face fields, Curl V = -Div(n x V).

    Returns
    -------
    (n, 3m) sparse array, units of length, weak. Row i is the integral of ∇φ_i · (n x V): the circulation round vertex
    i, positive counterclockwise seen from outside.

    Raises
    ------
    MeshError
        If a face has zero area.

    Examples
    --------
    A rigid rotation at one radian per unit of time has the vorticity 2.

    >>> import numpy as np
    >>> from geomhw.mesh import grid
    >>> mesh = grid(4, 4)
    >>> rotation = np.cross([0, 0, 1.0], mesh.face_centers)
    >>> inner = np.setdiff1d(np.arange(mesh.n_vertices), mesh.boundary_vertices)
    >>> ((curl(mesh) @ rotation.ravel()) / mesh.vertex_areas)[inner[0]].round(12)
    np.float64(2.0)
    """
    x, y, z = mesh.face_normals.T
    zero = np.zeros_like(x)
    blocks = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    turns = sp.bsr_array((blocks, np.arange(mesh.n_faces), np.arange(mesh.n_faces + 1)))
    return -(divergence(mesh) @ turns.tocsr())


def curl_of(mesh: TriangleMesh, field: Floats, weak_divergence: sp.csr_array | None = None) -> Floats:
    """Apply the curl to one face field, (m, 3).

    Parameters
    ----------
    weak_divergence : the integrated divergence to use, (k, 3m); by default `divergence` (k = n). With that of
        Crouzeix-Raviart functions the curl is integrated over edges (k = e).

    Returns
    -------
    (k,) array, units of the field times length.
    """
    D = divergence(mesh) if weak_divergence is None else weak_divergence
    return np.asarray(D @ -quarter_turn(mesh, field).ravel())
