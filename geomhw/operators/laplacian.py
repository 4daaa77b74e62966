"""Cotan stiffness and mass matrices."""

import scipy.sparse as sp

from geomhw.mesh.geometry import corner_sum
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.operators.edge_matrix import edge_matrix, weight_sums


def stiffness(mesh: PolyhedralSurface) -> sp.csr_array:
    """Cotan stiffness S, (n, n), dimensionless, weak, symmetric positive semidefinite [GIH, sec. 3.2.1].

    S_ij = -½(cot α + cot β), rows sum to zero: uᵀSu is the Dirichlet energy, the integral of |∇u|². S approximates -Δ
    (integrated); constants on each component are its null space. MeshError if a face has no area.
    """
    weights = mesh.edge_cotan_weights
    return edge_matrix(mesh.edges, -weights, weight_sums(mesh.edges, weights, mesh.n_vertices))


def lumped_mass(mesh: PolyhedralSurface) -> sp.csr_array:
    """Lumped mass M, (n, n) diagonal, units length²: the barycentric area of each vertex."""
    return sp.diags_array(mesh.vertex_areas, format="csr")


def consistent_mass(mesh: PolyhedralSurface) -> sp.csr_array:
    """Galerkin mass, (n, n), units length², symmetric positive definite: entries are the integrals of φ_i φ_j."""
    off_diagonal = corner_sum(mesh.face_areas / (12 * mesh.sheets), mesh.edge_table.of_faces, mesh.n_edges)
    return edge_matrix(mesh.edges, off_diagonal, mesh.vertex_areas / 2)
