"""Directions of edges in the tangent planes at their ends, as complex numbers, and vectors carried to the faces."""

from typing import get_args

import numpy as np

from geomhw.arrays import Complexes, Floats
from geomhw.errors import ArgumentError
from geomhw.mesh.geometry import unit
from geomhw.mesh.polyhedral import PolyhedralSurface
from geomhw.mesh.tangent_frames import face_frames
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.vertex_angles import edge_directions, intrinsic_edge_directions
from geomhw.options import Connection


def edge_ends(surface: PolyhedralSurface, connection: Connection, normals: Floats | None = None) -> Complexes:
    """Return the direction of each edge at its lower and its higher vertex, (e, 2), toward the other end.

    Parameters
    ----------
    surface : an oriented manifold with or without coordinates.
    connection : ``normals``, projections of unit vectors along the edges to the planes across the normals, in the
        frames `plane_frames`; ``intrinsic``, unit vectors at angles scaled to a full turn, the only ones
        of an `IntrinsicMesh`.
    normals : (n, 3), for ``normals``; by default those of the vertices.

    Raises
    ------
    ArgumentError
        If the connection is unknown, or not ``intrinsic`` for a surface without coordinates.
    MeshError
        If the surface is not an oriented manifold, for ``intrinsic``.
    """
    if connection not in get_args(Connection):
        raise ArgumentError(f"there is no connection '{connection}'; choose from {', '.join(get_args(Connection))}")
    if connection == "intrinsic":
        if isinstance(surface, TriangleMesh):
            angles = np.stack(edge_directions(surface), axis=1)
        else:
            angles = np.stack(intrinsic_edge_directions(surface), axis=1)
        return np.asarray(np.exp(1j * angles))
    if not isinstance(surface, TriangleMesh):
        raise ArgumentError("a surface that is given by edge lengths has no normals; use the intrinsic connection")
    frames = plane_frames(surface, surface.vertex_normals if normals is None else normals)
    along = surface.vertices[surface.edges[:, 1]] - surface.vertices[surface.edges[:, 0]]
    ends = np.einsum("eiax,ex->eia", frames[surface.edges], along) * np.array([[1.0], [-1.0]])
    return np.asarray((ends[..., 0] + 1j * ends[..., 1]) / surface.edge_lengths[:, None])


def plane_frames(mesh: TriangleMesh, normals: Floats) -> Floats:
    """Return orthonormal frames, (n, 2, 3), of the planes across unit normals, (n, 3): ``tangent_frames`` projected."""
    e1 = mesh.tangent_frames[:, 0]
    e1 = unit(e1 - np.einsum("ix,ix->i", e1, normals)[:, None] * normals)
    return np.stack([e1, np.cross(normals, e1)], axis=1)


def carried_to_faces(surface: PolyhedralSurface, ends: Complexes, z: Complexes) -> Floats:
    """Return one vector per face, (m, 3), the mean of the vectors at its corners.

    A vector keeps its angles with the two edges of the face, or the mean of the two results.

    Parameters
    ----------
    ends : (e, 2) array of `edge_ends`.
    z : (n,) array, tangent vectors at vertices as complex numbers.

    Returns
    -------
    (m, 3) array, in world axes, or in the layout of the faces of an `IntrinsicMesh`.
    """
    frames = face_frames(surface.opposite_edges, surface.face_normals)
    total = np.zeros(surface.n_faces, dtype=complex)
    for k in range(3):
        for third, sign in (((k + 2) % 3, 1.0), ((k + 1) % 3, -1.0)):
            start, end = surface.faces[:, k], surface.faces[:, 3 - k - third]
            edge = surface.edge_table.of_faces[:, third]
            inside = np.einsum("fx,fax->fa", sign * surface.opposite_edges[:, third], frames) @ np.array([1.0, 1j])
            turn = np.conj(ends[edge, (start > end).astype(int)]) * inside
            total += z[start] * turn / np.maximum(np.abs(turn), np.finfo(float).tiny)
    total /= 6
    return np.asarray(total.real[:, None] * frames[:, 0] + total.imag[:, None] * frames[:, 1])
