"""Tangent vectors at edge midpoints, on Crouzeix-Raviart elements: complex numbers relative to the edges.

The vector at an edge, z (e + i n x e) with e its unit vector from the lower to the higher vertex and n the normal of a
face at it, is the same in both faces: they are unfolded about the edge.

Feng, Crane: A Heat Method for Generalized Signed Distance. ACM Trans. Graph. 43(4), 2024.
"""

import numpy as np
import scipy.sparse as sp

from geomhw.arrays import Complexes, Floats, scatter_add
from geomhw.mesh.geometry import corner_dots
from geomhw.mesh.triangle_mesh import TriangleMesh


def edge_directions(mesh: TriangleMesh) -> Complexes:
    """Return the direction of the edge opposite each corner, (m, 3), in the plane of the face.

    Complex units; 1 is the first of ``mesh.opposite_edges`` of the face, i its left side. Edges point from the lower to
    the higher vertex.
    """
    # exp(iθ) at the corners 2 and 0; from side to side, the direction turns by π - θ.
    corners = corner_dots(mesh.opposite_edges)[:, [2, 0]] + 2j * mesh.face_areas[:, None]
    turns = -corners.conj() / np.hypot(corners.real, corners.imag)
    upward = np.roll(mesh.faces, -1, axis=1) < np.roll(mesh.faces, -2, axis=1)
    ones = np.ones(mesh.n_faces)
    return np.stack([ones, turns[:, 0], turns[:, 0] * turns[:, 1]], axis=1) * np.where(upward, 1, -1)


def edge_areas(mesh: TriangleMesh) -> Floats:
    """Return the lumped mass of each edge, (e,): a third of the areas of its faces."""
    return scatter_add(np.repeat(mesh.face_areas / 3, 3), mesh.edge_table.of_faces.ravel(), mesh.n_edges)


def edge_connection_stiffness(
    mesh: TriangleMesh, directions: Complexes | None = None, factors: Floats | None = None
) -> sp.csr_array:
    """Assemble the connection Laplacian of tangent vectors at edges.

    The entry of edges k and l of a face with the angle θ between them is -2 cot θ times the rotation from l to k.

    Parameters
    ----------
    mesh : an oriented manifold mesh.
    directions : those of `edge_directions`, if they are known.
    factors : (m,) array, of the share of each face; by default 1.

    Returns
    -------
    (e, e) sparse complex array, Hermitian, positive semidefinite, integrated, without unit. Zero on fields that are
    parallel in each face and continuous at edges.

    Raises
    ------
    MeshError
        If a face has zero area.

    Examples
    --------
    >>> from geomhw.mesh import grid
    >>> mesh = grid(3, 3)
    >>> along = mesh.vertices[mesh.edges[:, 1]] - mesh.vertices[mesh.edges[:, 0]]
    >>> parallel = 1 / (along @ [1, 1j, 0])  # the vector (1, 0, 0), up to lengths of edges
    >>> parallel /= abs(parallel)
    >>> bool(abs(edge_connection_stiffness(mesh) @ parallel).max() < 1e-12)
    True
    """
    to_face = edge_directions(mesh) if directions is None else directions
    cotangents, of = mesh.cotangents, mesh.edge_table.of_faces
    if factors is not None:
        cotangents = cotangents * factors[:, None]
    after, before = [1, 2, 0], [2, 0, 1]
    diagonal = scatter_add((2 * (cotangents[:, after] + cotangents[:, before])).ravel(), of.ravel(), mesh.n_edges)
    values = (-2 * cotangents * to_face[:, after].conj() * to_face[:, before]).ravel()
    i, j, k = of[:, after].ravel(), of[:, before].ravel(), np.arange(mesh.n_edges, dtype=of.dtype)
    rows, columns = np.concatenate([i, j, k]), np.concatenate([j, i, k])
    entries = np.concatenate([values, values.conj(), diagonal])
    return sp.csr_array(sp.coo_array((entries, (rows, columns)), shape=(mesh.n_edges, mesh.n_edges)))


def edge_vectors_at_faces(mesh: TriangleMesh, values: Complexes, directions: Complexes) -> Floats:
    """Return vectors in the planes of faces, (m, 3), from complex numbers at their edges, (m, 3): 3 times the mean.

    directions : those of `edge_directions`.
    """
    z = np.einsum("fk,fk->f", values, directions)
    first = mesh.opposite_edges[:, 0]
    x = first / np.linalg.norm(first, axis=1)[:, None]
    return np.asarray(z.real[:, None] * x + z.imag[:, None] * np.cross(mesh.face_normals, x))
