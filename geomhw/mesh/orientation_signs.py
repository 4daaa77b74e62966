"""Which way up: signs that make the normals of neighboring faces agree, over whole pieces where that can be.

A patch is a set of faces joined over edges that have exactly two; other edges do not tell what is up across them.
"""

import numpy as np

from geomhw.arrays import Ints
from geomhw.mesh.topology import Edges, inner_pairs, side_labels


def one_sided_faces(edges: Edges) -> Ints:
    """Faces of patches that no turning of faces makes agree (a Möbius band, a Klein bottle), ascending."""
    kept, turned = side_labels(edges)
    return np.flatnonzero(kept == turned)


def face_signs(edges: Edges) -> Ints:
    """-1 for faces to be turned so that neighbors agree, else 1, (m,): of each patch the lesser part, and of two equal
    ones that without the lowest face. All 1 in a one-sided patch."""
    kept, turned = side_labels(edges)
    size = np.bincount(kept, minlength=int(max(kept.max(initial=0), turned.max(initial=0))) + 1)
    turn = (size[kept] < size[turned]) | ((size[kept] == size[turned]) & (kept > turned))
    return np.where(turn, -1, 1)


def corner_signs(faces: Ints, edges: Edges) -> Ints:
    """Signs, (m, 3), by which a face's normal counts at its corners so that neighbors agree: `face_signs`, and in a
    one-sided patch such that they agree round each vertex, for no more can be had there."""
    signs = np.repeat(face_signs(edges)[:, None], 3, axis=1)
    if len(one_sided := one_sided_faces(edges)):
        signs[one_sided] = _fan_signs(faces, edges)[one_sided]
    return signs


def edge_signs(signs: Ints, edges: Edges) -> Ints:
    """-1 for edges whose ends are of two minds about what is up, else 1, (e,), from `corner_signs`."""
    at_edge = np.roll(signs, -1, axis=1) * np.roll(signs, -2, axis=1)
    result = np.ones(len(edges.vertices), dtype=signs.dtype)
    result[edges.of_faces.ravel()[::-1]] = at_edge.ravel()[::-1]  # the first face at an edge has the last word
    return result


def cover_faces(faces: Ints, signs: Ints, n: int) -> Ints:
    """Faces, (2m, 3), of the two-sided cover: a front and a back of each, over vertices v and their others, v + n.

    Joined wherever fronts and backs meet, they agree on what is up. A two-sided patch comes out twice; a one-sided one
    once, with two of each vertex.
    """
    back = np.where(signs > 0, 0, 1)
    front_faces = faces.astype(np.int64) + n * back
    back_faces = faces.astype(np.int64) + n * (1 - back)
    return np.concatenate([front_faces, back_faces[:, [0, 2, 1]]])


def _fan_signs(faces: Ints, edges: Edges) -> Ints:
    """Signs that agree among the corners of each fan, (m, 3); the lowest corner of a fan keeps its own."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, other, against = inner_pairs(edges)
    count = faces.size
    # The corners where each halfedge starts and ends; faces that agree run along their edge in opposite senses.
    starts, ends = (np.roll(np.arange(count).reshape(-1, 3), -step, axis=1).ravel() for step in (1, 2))
    here = np.concatenate([starts[one], ends[one]])
    first, last = starts[other], ends[other]
    there = np.concatenate([np.where(against, first, last), np.where(against, last, first)])
    flip = np.tile(against, 2) * count
    rows, columns = np.concatenate([here, here + count]), np.concatenate([there + flip, there + count - flip])
    links = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    labels = connected_components(links, directed=False)[1]
    return np.where(labels[:count] < labels[count:], 1, -1).reshape(-1, 3)
