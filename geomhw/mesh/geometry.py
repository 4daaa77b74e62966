"""Measures of triangles: areas, normals, angles, cotangents. Plain arrays in, plain arrays out.

Corner k of a face is its k-th vertex; edge k is the one opposite corner k, from corner k+1 to corner k+2.

Large arrays of vectors are stored coordinate by coordinate behind their shapes, (k, 3) and (m, 3, 3): numpy runs over
whole coordinates several times as fast as over short rows.
"""

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, pieces, scatter_add

#: Coordinates are trusted to this many units in their last place.
ROUNDING_UNITS = 8


def opposite_edges(vertices: Floats, faces: Ints) -> Floats:
    """Edge vectors, (m, 3, 3): ``[f, k]`` runs along the edge opposite corner k, counterclockwise."""
    edges, columns = np.empty((3, 3, len(faces))), np.ascontiguousarray(vertices.T)
    for piece in pieces(len(faces)):
        corners = np.ascontiguousarray(faces[piece].T, dtype=np.intp)
        for x, column in enumerate(columns):
            _between(_taken(column, corners), edges[:, x, piece])
    return edges.transpose(2, 0, 1)


def rows(points: Floats, index: Ints) -> Floats:
    """``points[index]``, (..., 3)."""
    places = np.ascontiguousarray(index, dtype=np.intp)
    found = np.empty((points.shape[1], *index.shape))
    for column, out in zip(np.ascontiguousarray(points.T), found, strict=True):
        _taken(column, places, out)
    return np.moveaxis(found, 0, -1)


def _taken(column: Floats, places: NDArray[np.intp], out: Floats | None = None) -> Floats:
    """``column[places]`` for places that are there, (...)."""
    return np.take(column, places, out=np.empty(places.shape) if out is None else out, mode="clip")


def at_corners(values: NDArray[Any], faces: Ints) -> NDArray[Any]:
    """Values of vertices, (n,), at the corners of faces, (m, 3)."""
    return np.take(values, np.ascontiguousarray(faces.T)).T


def between_corners(corners: Floats) -> Floats:
    """Edge vectors, (m, 3, 3), from corners k+1 to k+2 of those places, (m, 3, 3)."""
    edges = np.empty((3, 3, len(corners)))
    for x in range(3):
        _between(corners[:, :, x].T, edges[:, x])
    return edges.transpose(2, 0, 1)


def _between(corners: Floats, out: Floats) -> None:
    """One coordinate, (3, m), from corners k+1 to k+2, from that of the corners, (3, m)."""
    for k in range(3):
        np.subtract(corners[k - 1], corners[k - 2], out=out[k])


def area_vectors(edges: Floats) -> Floats:
    """Face normals times twice the face areas, (m, 3), right-handed, from the opposite edges."""
    return cross(edges[:, 0], edges[:, 1])


def cross(left: Floats, right: Floats) -> Floats:
    """Cross products of rows, (k, 3)."""
    product = np.empty((3, len(left)))
    for k, component in enumerate(product):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(left[:, i], right[:, j], out=component)
        component -= left[:, j] * right[:, i]
    return product.T


def distances(points: Floats, pairs: Ints) -> Floats:
    """Distances between points, (n, 3), by their pairs, (k, 2)."""
    found, columns = np.zeros(len(pairs)), np.ascontiguousarray(points.T)
    for piece in pieces(len(pairs)):
        start, end = np.ascontiguousarray(pairs[piece].T, dtype=np.intp)
        for column in columns:
            gap = _taken(column, end)
            gap -= _taken(column, start)
            found[piece] += np.square(gap, out=gap)
    return np.asarray(np.sqrt(found, out=found))


def lengths(vectors: Floats) -> Floats:
    """Lengths of rows, (k,)."""
    return np.asarray(np.sqrt(np.einsum("kx,kx->k", vectors, vectors)))


def face_centers(vertices: Floats, faces: Ints) -> Floats:
    """Barycenters, (m, 3)."""
    return vertices[faces].mean(axis=1)


def corner_dots(edges: Floats) -> Floats:
    """Dot product of the two edge vectors that leave each corner, (m, 3): 2 area x cotangent."""
    dots = np.empty((3, len(edges)))
    for k, out in enumerate(dots):
        np.negative(np.einsum("fx,fx->f", edges[:, k - 2], edges[:, k - 1], out=out), out=out)
    return dots.T


def corner_sum(values: Floats, faces: Ints, size: int) -> Floats:
    """Sum at each vertex of values given per corner, (m, 3) or, the same at all three corners, (m,)."""
    columns = values.reshape(len(faces), -1)
    if columns.shape[1] == 1:
        return np.asarray(sum(scatter_add(columns[:, 0], corner, size) for corner in faces.T))
    return scatter_add(columns.ravel(), faces.ravel(), size)


def vector_sum(vectors: Floats, faces: Ints, size: int, signs: Ints | int = 1) -> Floats:
    """Sums at the vertices, (size, 3), of vectors of their faces, (m, 3), times the signs at the corners, (m, 3)."""
    return np.stack([corner_sum(signs * column[:, None], faces, size) for column in vectors.T]).T


def degenerate_faces(vertices: Floats, faces: Ints, edges: Floats, doubled_areas: Floats) -> Ints:
    """Faces whose height is lost in the rounding of the coordinates: their normal is noise."""
    rounding = ROUNDING_UNITS * np.finfo(float).eps
    size = _largest(np.abs(vertices))
    # Mostly, no single face need be looked at, for no edge is longer than the mesh,
    if doubled_areas.min() > rounding * 4 * size.max() ** 2:
        return np.empty(0, dtype=np.int64)
    # nor than the longest one.
    square = max(float(_squares(edges[piece]).max()) for piece in pieces(len(faces)))
    if doubled_areas.min() > rounding * np.sqrt(square) * size.max():
        return np.empty(0, dtype=np.int64)
    # The coordinates of the largest corner are known to eps * size; a height below that may be zero or negative.
    longest = np.sqrt(_largest(_squares(edges)))
    return np.flatnonzero(doubled_areas <= rounding * longest * _largest(size[faces]))


def _squares(edges: Floats) -> Floats:
    """Squared lengths, (m, 3), of edge vectors, (m, 3, 3)."""
    return np.asarray(np.einsum("fkx,fkx->fk", edges, edges))


def _largest(rows: Floats) -> Floats:
    """The largest of each row of a few, (k,): by columns, which is many times as fast."""
    return np.asarray(reduce(np.maximum, rows.T))


def unit(vectors: Floats) -> Floats:
    """Vectors, (..., d), scaled to length one; zero stays zero. No square under- or overflows."""
    rows = vectors.reshape(-1, vectors.shape[-1])
    largest = _largest(np.abs(rows))
    scaled = rows / np.where(largest > 0, largest, 1.0)[:, None]
    length = lengths(scaled)
    scaled /= np.where(length > 0, length, 1.0)[:, None]
    return scaled.reshape(vectors.shape)


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
