"""Measures of triangles: areas, normals, angles, cotangents. Plain arrays in, plain arrays out.

Corner k of a face is its k-th vertex; edge k is the one opposite corner k, from corner k+1 to corner k+2.
"""

import numpy as np

from geomhw.mesh.arrays import Floats, Ints

#: Coordinates are trusted to this many units in their last place.
ROUNDING_UNITS = 8


def opposite_edges(vertices: Floats, faces: Ints) -> Floats:
    """Edge vectors, (m, 3, 3): ``[f, k]`` runs along the edge opposite corner k, counterclockwise."""
    corners = vertices[faces]
    return np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)


def area_vectors(edges: Floats) -> Floats:
    """Face normals times twice the face areas, (m, 3), right-handed, from the opposite edges."""
    return np.cross(edges[:, 0], edges[:, 1])


def face_centers(vertices: Floats, faces: Ints) -> Floats:
    """Barycenters, (m, 3)."""
    return vertices[faces].mean(axis=1)


def corner_dots(edges: Floats) -> Floats:
    """Dot product of the two edge vectors that leave each corner, (m, 3): 2 area x cotangent."""
    return -np.einsum("fkx,fkx->fk", np.roll(edges, -1, axis=1), np.roll(edges, -2, axis=1))


def corner_sum(values: Floats, faces: Ints, size: int) -> Floats:
    """Sum at each vertex of values given per corner, (m, 3) or, the same at all three corners, (m,)."""
    weights = np.broadcast_to(values.reshape(len(faces), -1), faces.shape)
    return np.asarray(np.bincount(faces.ravel(), weights=weights.ravel(), minlength=size), dtype=float)


def degenerate_faces(vertices: Floats, faces: Ints, edges: Floats) -> Ints:
    """Faces whose height is lost in the rounding of the coordinates: their normal is noise."""
    longest = np.sqrt(np.einsum("fkx,fkx->fk", edges, edges).max(axis=1, initial=0.0))
    size = np.abs(vertices[faces]).max(axis=(1, 2), initial=0.0)
    # The coordinates of the largest corner are known to eps * size; a height below that may be zero or negative.
    doubled_area = np.linalg.norm(area_vectors(edges), axis=1)
    return np.flatnonzero(doubled_area <= ROUNDING_UNITS * np.finfo(float).eps * longest * size)


def unit(vectors: Floats) -> Floats:
    """Rows scaled to length one; a zero row stays zero. No square under- or overflows."""
    largest = np.abs(vectors).max(axis=-1, keepdims=True)
    scaled = np.divide(vectors, largest, out=np.zeros_like(vectors), where=largest > 0)
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    return np.divide(scaled, length, out=scaled, where=length > 0)


def heron_areas(lengths: Floats) -> Floats:
    """Areas, (k,), of triangles of those side lengths, (k, 3), right for needles too; 0 where they do not close.

    The order of the operations is what makes it accurate [Kahan, Miscalculating Area and Angles of a Needle-like
    Triangle, 2014, sec. 2].
    """
    x, y, z = lengths.T
    low, high = np.minimum(x, y), np.maximum(x, y)
    c, b, a = np.minimum(low, z), np.maximum(low, np.minimum(high, z)), np.maximum(high, z)
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return np.asarray(np.sqrt(np.maximum(product, 0.0)) / 4)


def apex(base: Floats, left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Where two sides meet above a base on the x axis from 0, the left one ending at 0: x and y ≥ 0, (k,) each."""
    x = base / 2 + (left - right) * (left + right) / (2 * base)
    y = 2 * heron_areas(np.stack([base, left, right], axis=1)) / base
    return x, y
