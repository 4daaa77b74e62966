"""The cotan Laplacian."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.operators.edge_matrix import edge_matrix, weight_sums


def stiffness(mesh: PolyhedralSurface, coefficients: Floats | None = None) -> sp.csr_array:
    """Assemble the cotan stiffness S.

    Parameters
    ----------
    coefficients : (m,) array, c of the integral of c ∇φ_i · ∇φ_j on each face; 1 by default.

    Returns
    -------
    (n, n) sparse array, dimensionless, weak, symmetric positive semidefinite. S_ij = -½(cot α_ij + cot β_ij) and rows
    sum to zero: uᵀSu is the Dirichlet energy, the integral of |∇u|². S approximates the integrated -Δ; its null space
    is the constants on each component.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    [GIH, sec. 3.2.1]

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> S = stiffness(icosphere(2))
    >>> float(abs(S.sum(axis=0)).max()) < 1e-13
    True
    """
    if coefficients is None:
        weights = mesh.edge_cotan_weights
    else:
        halves = mesh.cotangents * (coefficients / (2 * mesh.sheets))[:, None]
        weights = corner_sum(halves, mesh.edge_table.of_faces, mesh.n_edges)
    return edge_matrix(mesh.edges, -weights, weight_sums(mesh.edges, weights, mesh.n_vertices))


def backward_euler(areas: Floats, S: sp.csr_array, t: float) -> sp.csr_array:
    """Assemble M + tS, the operator of one backward Euler step of the heat equation.

    Parameters
    ----------
    areas : (n,) array, the diagonal of the lumped mass M.
    S : (n, n) sparse array with all entries of its diagonal, real symmetric or complex Hermitian.
    t : diffusion time, units length².

    Returns
    -------
    (n, n) sparse array, units length², with the pattern of S; positive definite where S is semidefinite and areas are
    positive.

    References
    ----------
    [GIH, eq. 3; TVHM, algorithm 1]
    """
    A: Any = sp.csr_array((t * S.data, S.indices, S.indptr), shape=S.shape)
    A.setdiag(A.diagonal() + np.asarray(areas))
    return A
