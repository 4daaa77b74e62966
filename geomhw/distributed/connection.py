"""Tangent frames and connection Laplacians on the part of a mesh that a rank has."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, pieces
from geomhw.distributed.local_mesh import LocalMesh
from geomhw.distributed.shared_faces import SharedFaces
from geomhw.errors import MeshError
from geomhw.mesh.cut import cut_at_pinched_vertices
from geomhw.mesh.geometry import corner_sum, mean_directions, vector_sum
from geomhw.mesh.tangent_frames import vertex_frames
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.vertex_angles import corner_directions
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


def without_normal(frames: Floats) -> NDArray[np.bool_]:
    """Whether the second vectors of `tangent_frames`, (k, 2, 3), are zero, (k,)."""
    return np.asarray(~frames[:, 1].any(axis=1))


def require_normals(mesh: LocalMesh, areas: Floats, frames: Floats) -> None:
    """Raise MeshError for a vertex with faces but no normal, where frames, (k + g, 2, 3), fix no direction."""
    bare = np.flatnonzero((areas > 0) & without_normal(frames[: mesh.n_own]))
    with mesh.ranks.agreeing():
        if len(bare):
            raise MeshError(
                f"vertex {mesh.part.in_file[bare[0]]} has no normal, because its faces cancel, so the intrinsic "
                "connection has no frame there; use the connection of normals"
            )


def connection_stiffness(mesh: LocalMesh, S: sp.csr_array, frames: Floats) -> sp.csr_array:
    """Assemble K of the connection of normals in the rows of a rank, (k, k + g), complex, from those of S.

    frames : (k + g, 2, 3) array, as `tangent_frames`. K_ij = S_ij r_ij.
    """
    rows, data = np.repeat(np.arange(S.shape[0]), np.diff(S.indptr)), S.data.astype(complex)
    for piece in pieces(S.nnz):
        pairs = np.stack([rows[piece], S.indices[piece]], axis=1)
        data[piece] *= transport_between(mesh.vertices, frames, pairs)
    return sp.csr_array((data, S.indices, S.indptr), shape=S.shape)


def intrinsic_stiffness(mesh: LocalMesh, S: sp.csr_array, frames: Floats) -> sp.csr_array:
    """Assemble K of the intrinsic connection, otherwise as `connection_stiffness`.

    Raises
    ------
    MeshError
        If the mesh is not an oriented manifold.
    """
    k, n = mesh.n_own, len(mesh.vertices)
    # Faces at a ghost that are here may form several fans.
    with mesh.ranks.agreeing():
        angles = np.zeros((0, 3), dtype=complex)
        if len(mesh.faces):
            cut, original = cut_at_pinched_vertices(TriangleMesh(mesh.vertices, mesh.faces))
            ahead, behind = corner_directions(cut, frames[original])
            angles = ahead + 1j * behind
    angles = SharedFaces(mesh, mesh.faces)(angles)
    i, j = mesh.faces.ravel().astype(np.int64), np.roll(mesh.faces, -1, axis=1).ravel().astype(np.int64)
    r = np.exp(1j * (angles.real + np.pi - np.roll(angles.imag, -1, axis=1)).ravel())
    diagonal = np.arange(k)
    keys, first = np.unique(np.concatenate([i * n + j, j * n + i, diagonal * (n + 1)]), return_index=True)
    r = np.concatenate([r, r.conj(), np.ones(k)])[first]
    rows = np.repeat(diagonal, np.diff(S.indptr))
    return sp.csr_array((S.data * r[np.searchsorted(keys, rows * n + S.indices)], S.indices, S.indptr), shape=S.shape)
