"""Cotan stiffness and mass matrices."""

import numpy as np
import scipy.sparse as sp

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.polyhedral import PolyhedralSurface


def stiffness(mesh: PolyhedralSurface) -> sp.csr_array:
    """Cotan stiffness S, (n, n), dimensionless, weak, symmetric positive semidefinite [GIH, sec. 3.2.1].

    S_ij = -½(cot α + cot β), rows sum to zero: uᵀSu is the Dirichlet energy, the integral of |∇u|². S approximates -Δ
    (integrated); constants on each component are its null space. MeshError if a face has no area.
    """
    i, j = mesh.edges.T
    return _symmetric(-mesh.edge_cotan_weights, i, j, mesh.n_vertices, zero_row_sums=True)


def lumped_mass(mesh: PolyhedralSurface) -> sp.csr_array:
    """Lumped mass M, (n, n) diagonal, units length²: the barycentric area of each vertex."""
    return sp.diags_array(mesh.vertex_areas, format="csr")


def consistent_mass(mesh: PolyhedralSurface) -> sp.csr_array:
    """Galerkin mass, (n, n), units length², symmetric positive definite: entries are the integrals of φ_i φ_j."""
    i, j = mesh.edges.T
    off_diagonal = corner_sum(mesh.face_areas / (12 * mesh.sheets), mesh.edge_table.of_faces, mesh.n_edges)
    diagonal = mesh.vertex_areas / 2
    return _symmetric(off_diagonal, i, j, mesh.n_vertices) + sp.diags_array(diagonal, format="csr")


def _symmetric(values: Floats, i: Ints, j: Ints, size: int, zero_row_sums: bool = False) -> sp.csr_array:
    """Matrix with the values at (i, j) and (j, i), and, if asked, the diagonal that makes rows sum to zero."""
    rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
    entries = np.concatenate([values, values])
    if zero_row_sums:
        diagonal = -np.bincount(rows, weights=entries, minlength=size)
        every = np.arange(size, dtype=i.dtype)
        rows, columns = np.concatenate([rows, every]), np.concatenate([columns, every])
        entries = np.concatenate([entries, diagonal])
    return sp.coo_array((entries, (rows, columns)), shape=(size, size)).tocsr()
