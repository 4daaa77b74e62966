"""Parallel transport along edges, and the connection Laplacian that it makes [TVHM]."""

from typing import Any, Literal, get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.errors import FieldError, MeshError
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.geometry import lengths, rows, unit
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.vertex_angles import edge_directions
from geomhw.operators.edge_matrix import edge_matrix, weight_sums

Connection = Literal["normals", "intrinsic"]
Complexes = NDArray[np.complex128]


def edge_rotations(mesh: TriangleMesh, edges: Ints | None = None) -> Floats:
    """Smallest rotation R_ij from the unit normal at i to that at j, for each edge (i, j), i < j, (e, 3, 3).

    edges: (e, 2) pairs of vertices, by default the edges of the mesh. On a one-sided surface the normal at j is turned
    to the side of that at i, over the mesh's own edges; others do not tell.

    It is two half turns, about n_i and about the normal half-way; between opposite normals, where every half-way is as
    near, the one along the edge. MeshError where a vertex of a face has no normal.
    """
    ni, nj, along = _edge_normals(mesh, edges)
    return _half_turn(unit(_half_way(ni, nj, along))) @ _half_turn(ni)


def _edge_normals(mesh: TriangleMesh, edges: Ints | None) -> tuple[Floats, Floats, Floats]:
    """Normals at both ends of each edge, and the edge itself, (e, 3) each; as in `edge_rotations`."""
    i, j = (mesh.edges if edges is None else edges).T
    ni, nj = rows(mesh.vertex_normals, i), rows(mesh.vertex_normals, j)
    if edges is None and not mesh.is_orientable:
        nj *= mesh.edge_signs[:, None]
    bare = np.asarray(~mesh.vertex_normals.any(axis=1))
    if (missing := np.flatnonzero(bare[i] | bare[j])).size:
        first = missing[0]
        bad = int(i[first] if bare[i[first]] else j[first])
        raise MeshError(f"vertex {bad} has no normal: the faces round it cancel; move it, or cut the mesh there")
    return ni, nj, rows(mesh.vertices, j) - rows(mesh.vertices, i)


def _half_way(ni: Floats, nj: Floats, along: Floats) -> Floats:
    """A vector half-way between unit normals, (e, 3); between opposite ones, the edge's part across them."""
    half = ni + nj
    opposite = lengths(half) < 1e-8
    if opposite.any():
        half[opposite] = _any_normal(along[opposite], ni[opposite])
    return half


def connection_stiffness(mesh: TriangleMesh) -> sp.csr_array:
    """Connection stiffness C of the normals' connection, (3n, 3n), dimensionless, weak, symmetric.

    C_ii = Σ_j w_ij I and C_ij = -w_ij R_ji with cotan weights w: VᵀCV = Σ_edges w_ij |V_j - R_ij V_i|² [TVHM, eq. 4
    with the ½ in w]; positive semidefinite where the weights are not negative (a Delaunay mesh).
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
    return (off + sp.diags_array(np.repeat(_weight_sums(mesh), 3))).tocsr()


def edge_transport(
    mesh: TriangleMesh, connection: Connection = "normals", surface: IntrinsicMesh | None = None
) -> Complexes:
    """Unit complex number r_ij that brings a tangent vector from j to i, in ``tangent_frames``, for each edge, (e,).

    normals: the smallest rotation between vertex normals. intrinsic: Levi-Civita with angles stretched to a full turn
    [TVHM, sec. 5.2]. The way back is the conjugate. surface: another triangulation of the mesh, whose edges are meant
    instead; it does not know at which angles they leave, so only ``normals`` will do. FieldError for another name.
    """
    if connection == "intrinsic" and surface:
        raise FieldError("a robust triangulation has no intrinsic connection; use the connection of normals")
    if connection == "intrinsic":
        low, high = edge_directions(mesh)
        return np.asarray(np.exp(1j * (low + np.pi - high)))
    if connection != "normals":
        raise FieldError(f"there is no connection '{connection}'; choose from {', '.join(get_args(Connection))}")
    i, j = (surface or mesh).edges.T
    e1, e2 = mesh.tangent_frames.transpose(1, 0, 2)
    half = _half_way(*_edge_normals(mesh, surface.edges if surface else None))
    # Half turns about n_j, which sends e1 to -e1, and about the normal half-way make the smallest rotation from j to i.
    brought = rows(e1, j)
    brought -= (2 * _dots(brought, half) / _dots(half, half))[:, None] * half
    r = _dots(brought, rows(e1, i)) + 1j * _dots(brought, rows(e2, i))
    return np.asarray(r / np.abs(r))


def complex_connection_stiffness(
    mesh: TriangleMesh, connection: Connection = "normals", surface: IntrinsicMesh | None = None
) -> sp.csr_array:
    """Connection stiffness on tangent vectors as complex numbers in ``tangent_frames``, (n, n), Hermitian, weak.

    K_ii = Σ_j w_ij, K_ij = -w_ij r_ij. For the connection of normals it acts on tangent fields as
    `connection_stiffness` does, with a ninth of the entries. surface: as in `edge_transport`. MeshError where the mesh
    is one-sided: what goes round there comes back mirrored, which no complex number does.
    """
    if not mesh.is_orientable:
        raise MeshError(
            "the surface is one-sided, where tangent vectors are no complex numbers; "
            "take the 3n x 3n connection, or the two-sided cover"
        )
    domain = surface or mesh
    r = -domain.edge_cotan_weights * edge_transport(mesh, connection, surface)
    return edge_matrix(domain.edges, r, _weight_sums(domain))


def to_complex(mesh: TriangleMesh, vectors: Floats) -> Complexes:
    """Tangential parts of vectors at vertices, (n, 3), as complex numbers in ``tangent_frames``, (n,)."""
    parts = np.einsum("vkx,vx->kv", mesh.tangent_frames, vectors)
    return np.asarray(parts[0] + 1j * parts[1])


def from_complex(mesh: TriangleMesh, z: Complexes) -> Floats:
    """Tangent vectors, (n, 3), of complex numbers in ``tangent_frames``."""
    frames = mesh.tangent_frames
    return np.asarray(z.real[:, None] * frames[:, 0] + z.imag[:, None] * frames[:, 1])


def _weight_sums(mesh: PolyhedralSurface) -> Floats:
    return weight_sums(mesh.edges, mesh.edge_cotan_weights, mesh.n_vertices)


def _dots(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.einsum("ex,ex->e", left, right))


def _half_turn(axis: Floats) -> Floats:
    """Rotation by π about unit axes: 2 a aᵀ - I."""
    turn: Any = 2 * axis[:, :, None] * axis[:, None, :]
    return np.asarray(turn - np.eye(3))


def _any_normal(vectors: Floats, normals: Floats) -> Floats:
    """Vectors less their part along the normals, or, where nothing is left, some direction across the normal."""
    across = vectors - np.einsum("ex,ex->e", vectors, normals)[:, None] * normals
    lost = np.linalg.norm(across, axis=1) <= 1e-6 * np.linalg.norm(vectors, axis=1)
    axis = np.eye(3)[np.abs(normals[lost]).argmin(axis=1)]
    across[lost] = np.cross(normals[lost], axis)
    return np.asarray(across)
