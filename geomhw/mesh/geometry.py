"""Triangle geometry on plain arrays: edge vectors, cross products, areas, corner sums, degenerate faces.

Corner k of a face is its k-th vertex. Edge k is opposite corner k and runs from corner k+1 to corner k+2.

Arrays of vectors have the shapes (k, 3) and (m, 3, 3), but each coordinate is contiguous in memory: numpy is several
times faster on long columns than on rows of three.
"""

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints, pieces, scatter_add

#: A sum of vectors is zero if it is shorter than this share of the sum of their lengths.
CANCELED = 1e-12
#: Assumed rounding error of a coordinate, in units in the last place.
ROUNDING_UNITS = 8


def opposite_edges(vertices: Floats, faces: Ints) -> Floats:
    """Return the edge vectors, (m, 3, 3): ``[f, k]`` runs from corner k+1 to corner k+2 of face f."""
    edges, columns = np.empty((3, 3, len(faces))), np.ascontiguousarray(vertices.T)
    for piece in pieces(len(faces)):
        corners = np.ascontiguousarray(faces[piece].T, dtype=np.intp)
        for x, column in enumerate(columns):
            places = _taken(column, corners)
            for k in range(3):
                np.subtract(places[k - 1], places[k - 2], out=edges[k, x, piece])
    return edges.transpose(2, 0, 1)


def rows(points: Floats, index: Ints) -> Floats:
    """Return ``points[index]``, (..., 3), with contiguous coordinates."""
    places = np.ascontiguousarray(index, dtype=np.intp)
    found = np.empty((points.shape[1], *index.shape))
    for column, out in zip(np.ascontiguousarray(points.T), found, strict=True):
        _taken(column, places, out)
    return np.moveaxis(found, 0, -1)


def _taken(column: Floats, places: NDArray[np.intp], out: Floats | None = None) -> Floats:
    """Return ``column[places]``; the places must be in range."""
    return np.take(column, places, out=np.empty(places.shape) if out is None else out, mode="clip")


def at_corners(values: NDArray[Any], faces: Ints) -> NDArray[Any]:
    """Return values per vertex, (n,), at the corners of faces, (m, 3)."""
    return np.take(values, np.ascontiguousarray(faces.T)).T


def cross(left: Floats, right: Floats) -> Floats:
    """Return the cross products of rows, (k, 3)."""
    product = np.empty((3, len(left)))
    for k, component in enumerate(product):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(left[:, i], right[:, j], out=component)
        component -= left[:, j] * right[:, i]
    return product.T


def distances(points: Floats, pairs: Ints) -> Floats:
    """Return the distances, (k,), between pairs, (k, 2), of the points, (n, 3)."""
    found, columns = np.zeros(len(pairs)), np.ascontiguousarray(points.T)
    for piece in pieces(len(pairs)):
        start, end = np.ascontiguousarray(pairs[piece].T, dtype=np.intp)
        for column in columns:
            gap = _taken(column, end)
            gap -= _taken(column, start)
            found[piece] += np.square(gap, out=gap)
    return np.asarray(np.sqrt(found, out=found))


def lengths(vectors: Floats) -> Floats:
    """Return the Euclidean lengths of rows, (k,)."""
    return np.asarray(np.sqrt(np.einsum("kx,kx->k", vectors, vectors)))


def corner_dots(edges: Floats) -> Floats:
    """Return the dot product of the two edge vectors that leave each corner, (m, 3): 2 area x cotangent."""
    dots = np.empty((3, len(edges)))
    for k, out in enumerate(dots):
        np.negative(np.einsum("fx,fx->f", edges[:, k - 2], edges[:, k - 1], out=out), out=out)
    return dots.T


def corner_sum(values: Floats, faces: Ints, size: int) -> Floats:
    """Sum values per corner, (m, 3), or per face, (m,) or (m, 1), at each vertex, (size,)."""
    columns = values.reshape(len(faces), -1)
    if columns.shape[1] == 1:
        return np.asarray(sum(scatter_add(columns[:, 0], corner, size) for corner in faces.T))
    return scatter_add(columns.ravel(), faces.ravel(), size)


def vector_sum(vectors: Floats, faces: Ints, size: int, signs: Ints | int = 1) -> Floats:
    """Sum vectors per face, (m, 3), times signs per corner, (m, 3), at each vertex, (size, 3)."""
    return np.stack([corner_sum(signs * column[:, None], faces, size) for column in vectors.T]).T


def mean_directions(sums: Floats, total: Floats) -> Floats:
    """Normalize sums of vectors, (k, 3), in place; zero where they cancel. total: (k,) sums of their lengths."""
    sums[np.linalg.norm(sums, axis=1) <= CANCELED * total] = 0.0
    return unit(sums)


def degenerate_faces(vertices: Floats, faces: Ints, edges: Floats, doubled_areas: Floats) -> Ints:
    """Return the faces, ascending, whose height is below the rounding error of the coordinates."""
    rounding = ROUNDING_UNITS * np.finfo(float).eps
    size = _largest(np.abs(vertices))
    # Two bounds that avoid a test per face on most meshes: no edge is longer than the mesh,
    if doubled_areas.min() > rounding * 4 * size.max() ** 2:
        return np.empty(0, dtype=np.int64)
    # or than the longest edge.
    square = max(float(_squares(edges[piece]).max()) for piece in pieces(len(faces)))
    if doubled_areas.min() > rounding * np.sqrt(square) * size.max():
        return np.empty(0, dtype=np.int64)
    # The largest corner is known to eps * size; a height below that may be zero or negative.
    longest = np.sqrt(_largest(_squares(edges)))
    return np.flatnonzero(doubled_areas <= rounding * longest * _largest(size[faces]))


def _squares(edges: Floats) -> Floats:
    """Return the squared lengths, (m, 3), of edge vectors, (m, 3, 3)."""
    return np.asarray(np.einsum("fkx,fkx->fk", edges, edges))


def _largest(rows: Floats) -> Floats:
    """Return the maximum of each short row, (k,); by columns, which is many times faster than ``max(axis=1)``."""
    return np.asarray(reduce(np.maximum, rows.T))


def unit(vectors: Floats) -> Floats:
    """Normalize vectors, (..., d), without underflow or overflow; zero stays zero."""
    rows = vectors.reshape(-1, vectors.shape[-1])
    largest = _largest(np.abs(rows))
    scaled = rows / np.where(largest > 0, largest, 1.0)[:, None]
    length = lengths(scaled)
    scaled /= np.where(length > 0, length, 1.0)[:, None]
    return scaled.reshape(vectors.shape)


def heron_areas(lengths: Floats) -> Floats:
    """Return the areas, (k,), of triangles with the side lengths (k, 3); 0 where the triangle inequality fails.

    The order of operations keeps needles accurate [Kahan, Miscalculating Area and Angles of a Needle-like Triangle,
    2014, sec. 2].
    """
    x, y, z = lengths.T
    low, high = np.minimum(x, y), np.maximum(x, y)
    c, b, a = np.minimum(low, z), np.maximum(low, np.minimum(high, z)), np.maximum(high, z)
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return np.asarray(np.sqrt(np.maximum(product, 0.0)) / 4)


def apex(base: Floats, left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Return the apex (x, y ≥ 0), (k,) each, of triangles with the base from 0 along x and the left side at 0."""
    x = base / 2 + (left - right) * (left + right) / (2 * base)
    y = 2 * heron_areas(np.stack([base, left, right], axis=1)) / base
    return x, y
