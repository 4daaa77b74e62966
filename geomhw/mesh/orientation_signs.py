"""Orientation signs of faces, corners and edges: which faces to reverse for a consistent orientation.

A patch is a set of faces connected across edges with exactly two faces. Other edges do not constrain orientation.
"""

import numpy as np

from geomhw.arrays import Ints
from geomhw.mesh.topology import Edges, inner_pairs, linked_components


def orientation_labels(edges: Edges) -> tuple[Ints, Ints]:
    """Label each face, (m,), as given and reversed, by component of the orientation double cover.

    Equal labels mean consistent orientation. A face whose two labels are equal lies in a one-sided patch.
    """
    m = len(edges.of_faces)
    one, other, against = inner_pairs(edges)
    left, right = one // 3, other // 3
    # Node f is face f as given, node f + m the reversed face.
    here = np.concatenate([left, left + m])
    there = np.concatenate([np.where(against, right + m, right), np.where(against, right, right + m)])
    labels = linked_components(here, there, 2 * m)
    return labels[:m], labels[m:]


def one_sided_faces(edges: Edges) -> Ints:
    """Return the faces, ascending, of non-orientable patches (a Möbius band, a Klein bottle)."""
    given, reverse = orientation_labels(edges)
    return np.flatnonzero(given == reverse)


def face_signs(edges: Edges) -> Ints:
    """Return -1 for faces to reverse for a consistent orientation, else 1, (m,); all 1 in a one-sided patch.

    The smaller part of each patch is reversed; of two equal parts, the one without the lowest face.
    """
    given, reverse = orientation_labels(edges)
    size = np.bincount(given, minlength=int(max(given.max(initial=0), reverse.max(initial=0))) + 1)
    turn = (size[given] < size[reverse]) | ((size[given] == size[reverse]) & (given > reverse))
    return np.where(turn, -1, 1)


def corner_signs(faces: Ints, edges: Edges) -> Ints:
    """Return the sign of each face's normal at its corners, (m, 3), for consistent vertex normals.

    In an orientable patch it is `face_signs`. In a one-sided patch the signs are consistent around each vertex only.
    """
    signs = np.repeat(face_signs(edges)[:, None], 3, axis=1)
    if len(one_sided := one_sided_faces(edges)):
        signs[one_sided] = _fan_signs(faces, edges)[one_sided]
    return signs


def edge_signs(signs: Ints, edges: Edges) -> Ints:
    """Return -1 for edges whose endpoint normals, by `corner_signs`, disagree in orientation, else 1, (e,)."""
    at_edge = np.roll(signs, -1, axis=1) * np.roll(signs, -2, axis=1)
    result = np.ones(len(edges.vertices), dtype=signs.dtype)
    result[edges.of_faces.ravel()[::-1]] = at_edge.ravel()[::-1]  # the first face at an edge is written last
    return result


def double_cover_faces(faces: Ints, signs: Ints, n: int) -> Ints:
    """Return the faces, (2m, 3), of the orientation double cover: a front and a back of each face.

    Vertex v of the mesh becomes v and v + n. The cover is consistently oriented. An orientable patch gives two
    components, a one-sided patch one component.
    """
    shift = n * (signs <= 0)
    return np.concatenate([faces + shift, (faces + n - shift)[:, [0, 2, 1]]])


def _fan_signs(faces: Ints, edges: Edges) -> Ints:
    """Return signs, (m, 3), consistent among the corners of each fan, +1 at the lowest corner of the fan."""
    one, other, against = inner_pairs(edges)
    count = faces.size
    # The corners at the start and end of each halfedge. Consistent faces run along an edge in opposite senses.
    starts, ends = (np.roll(np.arange(count).reshape(-1, 3), -step, axis=1).ravel() for step in (1, 2))
    here = np.concatenate([starts[one], ends[one]])
    first, last = starts[other], ends[other]
    there = np.concatenate([np.where(against, first, last), np.where(against, last, first)])
    flip = np.tile(against, 2) * count
    links = np.concatenate([here, here + count]), np.concatenate([there + flip, there + count - flip])
    labels = linked_components(*links, 2 * count)
    return np.where(labels[:count] < labels[count:], 1, -1).reshape(-1, 3)
