"""Divergence of piecewise-constant vector fields."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, pieces
from geomhw.mesh.geometry import corner_sum, cross
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.operators.gradient import gradient


def divergence(mesh: PolyhedralSurface) -> sp.csr_array:
    """Assemble the integrated divergence of face fields, Div = -GᵀA.

    Returns
    -------
    (n, 3m) sparse array, units of length, weak. Row i is minus the integral of ∇φ_i · X: positive where the field
    spreads, with no flux through a boundary. ``Div @ G == -stiffness`` up to rounding. Divide by
    ``mesh.vertex_areas`` for the pointwise divergence.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    [GIH, sec. 3.2.1]
    """
    return (gradient(mesh).T * -np.repeat(mesh.face_areas / mesh.sheets, 3)).tocsr()


def divergence_of(mesh: PolyhedralSurface, field: Floats) -> Floats:
    """Apply `divergence` to one face field without assembling the matrix.

    Parameters
    ----------
    field : (m, 3) array, one vector per face. A face of zero area contributes nothing.

    Returns
    -------
    (n,) array, units of the field times length.
    """
    # A ∇φ_k · X = (N x e_k) · X / 4A = (X x N) · e_k / 4A
    fluxes = np.empty((mesh.n_faces, 3))
    for faces in pieces(mesh.n_faces):
        areas = mesh.face_areas[faces]
        turned = cross(field[faces], mesh.area_vectors[faces])
        turned *= np.divide(-0.25 / mesh.sheets, areas, out=np.zeros_like(areas), where=areas > 0)[:, None]
        np.einsum("fkx,fx->fk", mesh.opposite_edges[faces], turned, out=fluxes[faces])
    return corner_sum(fluxes, mesh.faces, mesh.n_vertices)
