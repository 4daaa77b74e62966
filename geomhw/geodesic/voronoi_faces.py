"""Faces divided between the Voronoi cells of their corners, with distances interpolated from the corners."""

from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh


class Split(NamedTuple):
    """Faces divided between cells.

    areas: (k,), of the cells. pairs, segments: (s, 2) and (s, 2, 3), sites and the border between their cells. pieces,
    owners: (p, 3, 3) and (p,), triangles that make up the divided faces, and their sites.
    """

    areas: Floats
    pairs: Ints
    segments: Floats
    pieces: Floats
    owners: Ints


def split_faces(mesh: TriangleMesh, label: Ints, distance: Floats, k: int) -> Split:
    """Divide faces between the cells of their corners.

    label: (n,). distance: (m, 3, 3), entry [f, i, j] the distance of corner j of face f from the site of its corner i.
    k: number of cells.
    """
    labels = label[mesh.faces]
    whole = (labels == labels[:, :1]).all(axis=1)
    inside = whole & (labels[:, 0] >= 0)
    areas = np.asarray(np.bincount(labels[inside, 0], mesh.face_areas[inside], k), dtype=float)
    (mixed,) = np.nonzero(~whole & (labels >= 0).all(axis=1))
    owner, d, corners, size = labels[mixed], distance[mixed], mesh.vertices[mesh.faces[mixed]], mesh.face_areas[mixed]
    # Barycentric coordinates: of the border on the edge from each corner to the next, and of the meeting point.
    rows = np.arange(len(mixed))
    edge_points = [_edge_point(d, i, (i + 1) % 3) for i in range(3)]
    meeting = _meeting_point(d)
    for i in range(3):  # where two corners are of one cell, its border is straight between two edges
        j, o = (i + 1) % 3, (i + 2) % 3
        same = owner[:, i] == owner[:, j]
        edge_points[i][same] = np.eye(3)[i] / 2 + np.eye(3)[j] / 2
        meeting[same] = (edge_points[j][same] + edge_points[o][same]) / 2
    pairs, segments, pieces = [], [], []
    for i in range(3):
        j = (i + 1) % 3
        corner = np.broadcast_to(np.eye(3)[i], meeting.shape)
        for triangle in ((corner, edge_points[i], meeting), (corner, meeting, edge_points[i - 1])):
            weights = np.stack(triangle, axis=1)
            areas += np.bincount(owner[:, i], np.linalg.det(weights) * size, k)
            pieces.append(np.einsum("fwc,fcx->fwx", weights, corners))
        between = rows[owner[:, i] != owner[:, j]]
        pairs.append(np.sort(owner[between][:, [i, j]], axis=1))
        ends = np.stack([edge_points[i][between], meeting[between]], axis=1)
        segments.append(np.einsum("sec,scx->sex", ends, corners[between]))
    owners = np.asarray(np.repeat(owner.T, 2, axis=0).ravel())
    return Split(areas, np.concatenate(pairs), np.concatenate(segments), np.concatenate(pieces), owners)


def _edge_point(d: Floats, i: int, j: int) -> Floats:
    """Barycentric coordinates of the place between corners i and j at which both of their sites are equally far."""
    at_i, at_j = np.maximum(d[:, j, i] - d[:, i, i], 0), np.maximum(d[:, i, j] - d[:, j, j], 0)
    total = at_i + at_j
    share = np.divide(at_i, total, out=np.full(len(d), 0.5), where=total > 0)
    return np.asarray((1 - share)[:, None] * np.eye(3)[i] + share[:, None] * np.eye(3)[j])


def _meeting_point(d: Floats) -> Floats:
    """Barycentric coordinates of the place in the face that is equally far, or nearly, from the sites of all corners.

    A place outside is moved to the boundary of the face.
    """
    b = np.cross(d[:, 0] - d[:, 1], d[:, 0] - d[:, 2])
    total = b.sum(axis=1, keepdims=True)
    b = np.divide(b, total, out=np.full(b.shape, 1 / 3), where=total != 0)
    b = np.clip(b, 0, 1)
    return np.asarray(b / b.sum(axis=1, keepdims=True))
