"""The connection Laplacian: differences of tangent vectors along edges, measured after parallel transport."""

import numpy as np
import scipy.sparse as sp

from geomhw.errors import MeshError
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.edge_matrix import edge_matrix, weight_sums
from geomhw.operators.parallel_transport import edge_rotations, edge_transport
from geomhw.options import Connection


def connection_stiffness(mesh: TriangleMesh) -> sp.csr_array:
    """Assemble the connection stiffness C of the connection of normals, on vectors in world axes.

    C_ii = Σ_j w_ij I and C_ij = -w_ij R_ji with cotan weights w_ij = ½(cot α + cot β), so that
    VᵀCV = Σ_edges w_ij |V_j - R_ij V_i|². A vertex without a normal stands alone: R_ij is zero there.

    Returns
    -------
    (3n, 3n) sparse array, dimensionless, weak, symmetric; positive semidefinite where no weight is negative. Row
    3i+k is component k at vertex i.

    Raises
    ------
    MeshError
        If a face has zero area.

    References
    ----------
    [TVHM, eq. 4], with the ½ in w.
    """
    i, j = mesh.edges.T
    w = mesh.edge_cotan_weights
    R = edge_rotations(mesh)
    # R takes i to j: it stands, with a minus, at (j, i), and its transpose at (i, j).
    blocks = np.concatenate([-w[:, None, None] * R, -w[:, None, None] * R.transpose(0, 2, 1)])
    axis = np.arange(3)
    down = np.concatenate([j, i])[:, None, None] * 3 + axis[:, None]
    across = np.concatenate([i, j])[:, None, None] * 3 + axis[None, :]
    places = tuple(np.broadcast_to(x, blocks.shape).ravel() for x in (down, across))
    off = sp.coo_array((blocks.ravel(), places), shape=(3 * mesh.n_vertices, 3 * mesh.n_vertices))
    return (
        off + sp.diags_array(np.repeat(weight_sums(mesh.edges, mesh.edge_cotan_weights, mesh.n_vertices), 3))
    ).tocsr()


def complex_connection_stiffness(
    mesh: TriangleMesh, connection: Connection = "normals", surface: IntrinsicMesh | None = None
) -> sp.csr_array:
    """Assemble the connection stiffness on tangent vectors as complex numbers in ``mesh.tangent_frames``.

    K_ii = Σ_j w_ij and K_ij = -w_ij r_ij. For the connection of normals it acts on tangent fields as
    `connection_stiffness` does, with a ninth of the entries.

    Parameters
    ----------
    connection, surface : as in `edge_transport`.

    Returns
    -------
    (n, n) complex sparse array, dimensionless, weak, Hermitian; positive semidefinite where no weight is negative.

    Raises
    ------
    MeshError
        If a face has zero area, or the surface is one-sided: a tangent vector carried round comes back mirrored there,
        which no complex number expresses.

    References
    ----------
    [TVHM, sec. 5]
    """
    if not mesh.is_orientable:
        raise MeshError(
            "the surface is one-sided, where complex numbers cannot stand for tangent vectors; "
            "take the 3n x 3n connection, or the orientation cover"
        )
    domain = surface or mesh
    r = -domain.edge_cotan_weights * edge_transport(mesh, connection, surface)
    return edge_matrix(domain.edges, r, weight_sums(domain.edges, domain.edge_cotan_weights, domain.n_vertices))
