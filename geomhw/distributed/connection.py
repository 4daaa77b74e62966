"""Tangent frames and the connection Laplacian on the part of a mesh that a rank has."""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Floats, pieces
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.mesh.geometry import corner_sum, mean_directions, vector_sum
from geomhw.mesh.tangent_frames import vertex_frames
from geomhw.operators.parallel_transport import transport_between


def tangent_frames(mesh: LocalMesh) -> Floats:
    """Return right-handed frames of the tangent planes of a rank's vertices and ghosts, (k + g, 2, 3).

    They are those of `TriangleMesh.tangent_frames` for faces in the order of the curve, on any number of ranks. At
    a vertex without a normal, because the faces round it cancel, the second vector is zero.
    """
    n, k = len(mesh.vertices), mesh.n_own
    sums, total = np.zeros((n, 3)), np.zeros(n)
    for used, block in mesh.blocks():
        sums[used] += vector_sum(block.area_vectors, block.faces, block.n_vertices)
        total[used] += corner_sum(2 * block.face_areas, block.faces, block.n_vertices)
    normals = mean_directions(sums, total)
    frames = vertex_frames(mesh.vertices, mesh.faces, normals) if len(mesh.faces) else np.zeros((n, 2, 3))
    return mesh.with_ghosts(frames[:k])


def connection_stiffness(mesh: LocalMesh, S: sp.csr_array, frames: Floats) -> sp.csr_array:
    """Assemble K of the connection of normals in the rows of a rank, (k, k + g), complex, from those of S.

    frames : (k + g, 2, 3) array, as `tangent_frames`. K_ij = S_ij r_ij.
    """
    rows, data = np.repeat(np.arange(S.shape[0]), np.diff(S.indptr)), S.data.astype(complex)
    for piece in pieces(S.nnz):
        pairs = np.stack([rows[piece], S.indices[piece]], axis=1)
        data[piece] *= transport_between(mesh.vertices, frames, pairs)
    return sp.csr_array((data, S.indices, S.indptr), shape=S.shape)
