"""Orthonormal frames in the tangent planes of vertices and faces."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import unit


def vertex_frames(vertices: Floats, faces: Ints, normals: Floats) -> Floats:
    """Return right-handed orthonormal frames (e1, e2), e1 x e2 = normal, of the vertices, (n, 2, 3).

    e1 is the projected edge from the vertex to the next corner of its lowest-numbered face, so frames rotate with the
    mesh. A coordinate axis replaces an edge that is parallel to the normal or missing.
    """
    flat = faces.ravel()
    first = np.full(len(vertices), -1)
    # Later writes win: in reverse order the first corner of each vertex remains.
    first[flat[::-1]] = np.arange(flat.size)[::-1]
    ahead = np.roll(faces, -1, axis=1).ravel()[first]
    edge = vertices[ahead] - vertices
    length = np.linalg.norm(edge, axis=1)
    flat_edge = _project(edge, normals)
    steep = (first < 0) | (np.linalg.norm(flat_edge, axis=1) <= 1e-6 * length)
    flat_edge[steep] = _project(np.eye(3)[np.abs(normals[steep]).argmin(axis=1)], normals[steep])
    e1 = unit(flat_edge)
    e1 = unit(_project(e1, normals))  # a second projection removes the rounding error of the first
    return np.stack([e1, np.cross(normals, e1)], axis=1)


def face_frames(edges: Floats, normals: Floats) -> Floats:
    """Return right-handed orthonormal frames (e1, e2) of faces, (m, 2, 3), e1 along the edge from corner 0 to corner 1.

    edges: (m, 3, 3) opposite edges. normals: (m, 3) unit normals.
    """
    e1 = unit(edges[:, 2])
    return np.stack([e1, np.cross(normals, e1)], axis=1)


def _project(vectors: Floats, normals: Floats) -> Floats:
    """Project vectors, (n, 3), to the planes with the unit normals, (n, 3)."""
    return np.asarray(vectors - np.einsum("vx,vx->v", vectors, normals)[:, None] * normals)
