"""Parallel transport of tangent vectors along edges, R_ij, and tangent vectors as complex numbers."""

from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Complexes, Floats, Ints
from geomhw.errors import ArgumentError
from geomhw.intrinsic.intrinsic_mesh import IntrinsicMesh
from geomhw.mesh.geometry import cross, lengths, rows, unit
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.vertex_angles import edge_directions
from geomhw.options import Connection


def edge_rotations(mesh: TriangleMesh, edges: Ints | None = None) -> Floats:
    """Return R_ij, the smallest rotation from the unit normal at i to that at j, for each edge (i, j), i < j.

    It is the product of two half turns, about n_i and about the normal half-way. Between opposite normals every
    half-way normal is as near; the one along the edge is taken. On a one-sided surface the normal at j is first turned
    to the side of that at i, for the edges of the mesh only.

    Parameters
    ----------
    edges : (e, 2) array of vertex pairs; by default the edges of the mesh.

    Returns
    -------
    (e, 3, 3) array of rotation matrices; zero where an end has no normal, because the faces round it cancel.

    References
    ----------
    [TVHM, sec. 3.2]
    """
    ni, nj, along = _edge_normals(mesh, edges)
    turns = _half_turn(unit(_half_way(ni, nj, along))) @ _half_turn(ni)
    turns[_bare(ni, nj)] = 0.0
    return turns


def edge_transport(
    mesh: TriangleMesh, connection: Connection = "normals", surface: IntrinsicMesh | None = None
) -> Complexes:
    """Return the unit complex number r_ij that brings a tangent vector from j to i, for each edge (i, j), i < j.

    The way back is the conjugate. With the connection of normals r_ij is zero where an end has no normal, because the
    faces round it cancel: there is no tangent plane.

    Parameters
    ----------
    connection : ``normals``, the smallest rotation between vertex normals, or ``intrinsic``, Levi-Civita with the
        angles round each vertex scaled to a full turn.
    surface : another triangulation of the mesh, whose edges are used instead. It does not know the angles at which its
        edges leave, so it goes with ``normals`` only.

    Returns
    -------
    (e,) complex array, in the frames ``mesh.tangent_frames``.

    Raises
    ------
    ArgumentError
        If the connection is unknown, or ``intrinsic`` with a surface.
    MeshError
        For ``intrinsic``, if the mesh is not an oriented manifold.

    References
    ----------
    [TVHM, sec. 5.2]
    """
    if connection == "intrinsic" and surface:
        raise ArgumentError("a robust triangulation has no intrinsic connection; use the connection of normals")
    if connection == "intrinsic":
        low, high = edge_directions(mesh)
        return np.asarray(np.exp(1j * (low + np.pi - high)))
    if connection != "normals":
        raise ArgumentError(f"there is no connection '{connection}'; choose from {', '.join(get_args(Connection))}")
    edges = surface.edges if surface else None
    return _carried(mesh.tangent_frames, mesh.edges if edges is None else edges, *_edge_normals(mesh, edges))


def transport_between(points: Floats, frames: Floats, pairs: Ints) -> Complexes:
    """Return r_ij of the connection of normals, as `edge_transport`, for pairs (i, j) with consistent normals.

    Parameters
    ----------
    points : (n, 3) array.
    frames : (n, 2, 3) array of tangent frames, whose cross products are the normals.
    pairs : (e, 2) array, in any order; r_ii = 1.
    """
    normals = cross(frames[:, 0], frames[:, 1])
    i, j = pairs.T
    return _carried(frames, pairs, rows(normals, i), rows(normals, j), rows(points, j) - rows(points, i))


def _carried(frames: Floats, pairs: Ints, ni: Floats, nj: Floats, along: Floats) -> Complexes:
    """r_ij for pairs (i, j), (e,), from the normals at both ends and the vectors between them, (e, 3)."""
    (i, j), half, bare = pairs.T, _half_way(ni, nj, along), _bare(ni, nj)
    e1, e2 = frames.transpose(1, 0, 2)
    # Half turns about n_j, which sends e1 to -e1, and about the normal half-way make the smallest rotation from j to i.
    brought = rows(e1, j)
    half[bare] = 1.0
    brought -= (2 * _dots(brought, half) / _dots(half, half))[:, None] * half
    r = _dots(brought, rows(e1, i)) + 1j * _dots(brought, rows(e2, i))
    r[bare] = 0.0
    return np.asarray(r / np.where(bare, 1.0, np.abs(r)))


def to_complex(mesh: TriangleMesh, vectors: Floats) -> Complexes:
    """Return the tangential parts of vectors at vertices, (n, 3), as complex numbers in ``tangent_frames``, (n,)."""
    return in_frames(mesh.tangent_frames, vectors)


def from_complex(mesh: TriangleMesh, z: Complexes) -> Floats:
    """Return the tangent vectors, (n, 3), of complex numbers in ``tangent_frames``, (n,)."""
    return from_frames(mesh.tangent_frames, z)


def in_frames(frames: Floats, vectors: Floats) -> Complexes:
    """Return the tangential parts of vectors, (k, 3), as complex numbers in frames, (k, 2, 3)."""
    parts = np.einsum("vkx,vx->kv", frames, vectors)
    return np.asarray(parts[0] + 1j * parts[1])


def from_frames(frames: Floats, z: Complexes) -> Floats:
    """Return the tangent vectors, (k, 3), of complex numbers in frames, (k, 2, 3)."""
    return np.asarray(z.real[:, None] * frames[:, 0] + z.imag[:, None] * frames[:, 1])


def _edge_normals(mesh: TriangleMesh, edges: Ints | None) -> tuple[Floats, Floats, Floats]:
    """Normals at both ends of each edge, and the edge itself, (e, 3) each; as in `edge_rotations`."""
    i, j = (mesh.edges if edges is None else edges).T
    ni, nj = rows(mesh.vertex_normals, i), rows(mesh.vertex_normals, j)
    if edges is None and not mesh.is_orientable:
        nj *= mesh.edge_signs[:, None]
    return ni, nj, rows(mesh.vertices, j) - rows(mesh.vertices, i)


def _bare(ni: Floats, nj: Floats) -> NDArray[np.bool_]:
    """Whether an end of each edge has no normal, (e,)."""
    return np.asarray(_dots(ni, ni) * _dots(nj, nj) == 0)


def _half_way(ni: Floats, nj: Floats, along: Floats) -> Floats:
    """A vector half-way between unit normals, (e, 3); between opposite ones, the edge's part across them."""
    half = ni + nj
    opposite = lengths(half) < 1e-8
    if opposite.any():
        half[opposite] = _any_normal(along[opposite], ni[opposite])
    return half


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


def _dots(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.einsum("ex,ex->e", left, right))
