"""A frame in the tangent plane of each vertex."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.geometry import unit


def vertex_frames(vertices: Floats, faces: Ints, normals: Floats) -> Floats:
    """Right-handed orthonormal frames (e1, e2) with e1 x e2 = normal, (n, 2, 3).

    e1 is the edge from the vertex to the next corner of its lowest-numbered face, projected to the tangent plane, so
    frames turn with the mesh. Where that edge is normal to the plane, or there is none, an axis takes its place.
    """
    flat = faces.ravel()
    first = np.full(len(vertices), -1)
    # Later writes win, so from the back: the corner that stays is the first one in the file.
    first[flat[::-1]] = np.arange(flat.size)[::-1]
    ahead = np.roll(faces, -1, axis=1).ravel()[first]
    edge = vertices[ahead] - vertices
    length = np.linalg.norm(edge, axis=1)
    flat_edge = _project(edge, normals)
    steep = (first < 0) | (np.linalg.norm(flat_edge, axis=1) <= 1e-6 * length)
    flat_edge[steep] = _project(np.eye(3)[np.abs(normals[steep]).argmin(axis=1)], normals[steep])
    e1 = unit(flat_edge)
    e1 = unit(_project(e1, normals))  # once more, for what the first projection lost to rounding
    return np.stack([e1, np.cross(normals, e1)], axis=1)


def _project(vectors: Floats, normals: Floats) -> Floats:
    return np.asarray(vectors - np.einsum("vx,vx->v", vectors, normals)[:, None] * normals)
