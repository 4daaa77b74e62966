"""Points that are nearly in one place: which they are, and the first of each group."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from geomhw.arrays import Floats, Ints

#: Odd factors that mix the bits of three coordinates [xxHash64].
_PRIMES = np.array([0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
#: Points of a cube that are compared with those of other cubes.
_CROWD = 8
#: A direction in which few points of a mesh have equal positions.
_DIRECTION = np.array([0.5411961, 0.7653669, 0.3490659]) / 0.9999


def distinct_points(points: Floats) -> tuple[Ints, Ints]:
    """Find the distinct points; -0.0 equals 0.0.

    Returns
    -------
    first : (k,) array
        Index of the first point at each position, ascending.
    inverse : (n,) array
        Row of ``first`` for each point.

    Examples
    --------
    >>> first, inverse = distinct_points(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0]]))
    >>> first.tolist(), inverse.tolist()
    ([0, 1], [0, 1, 0])
    """
    order, new = _by_position(points)
    first = order[new]  # lexsort is stable: the first of a group is its first occurrence
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    inverse = np.empty(len(points), dtype=np.int64)
    inverse[order] = rank[np.cumsum(new) - 1]
    return np.sort(first), inverse


def _by_position(points: Floats) -> tuple[Ints, NDArray[np.bool_]]:
    """An order of points, stable, in which equal ones follow each other, and whether each differs from the one before.

    The order is by a hash of the coordinates, which takes half the time of one by coordinates.
    """
    columns = np.ascontiguousarray(points.T) + 0.0  # -0.0 becomes 0.0
    bits = columns.view(f"u{columns.itemsize}").astype(np.uint64)
    keys = bits[0] * _PRIMES[0] ^ bits[1] * _PRIMES[1] ^ bits[2] * _PRIMES[2]
    order = np.argsort(keys, kind="stable")
    new = np.ones(len(points), dtype=bool)
    for attempt in range(2):
        ranked = columns[:, order]
        new[1:] = (ranked[:, 1:] != ranked[:, :-1]).any(axis=0)
        if attempt or not (new[1:] & (np.diff(keys[order]) == 0)).any():
            break
        order = np.lexsort(columns)  # different points have one hash
    return order, new


def first_nearby(points: Floats, tolerance: float) -> Ints:
    """Return for each point the first one of its group, (n,), where groups are chains of near points.

    Parameters
    ----------
    points : (n, 3) array of finite coordinates, few of which are equal.
    tolerance
        Distance from a point to the next in a chain, at most.

    Examples
    --------
    >>> first_nearby(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1e-9, 0]]), 1e-8).tolist()
    [0, 1, 1]
    """
    group = np.arange(len(points))
    near = _may_be_near(points, tolerance)
    if len(near) < 2:
        return group
    links, few = _crowds(points[near], tolerance)
    pairs = few[cKDTree(points[near][few]).query_pairs(tolerance, output_type="ndarray")]
    links = np.concatenate([links, pairs])
    graph = coo_array((np.ones(len(links)), links.T), shape=(len(near), len(near)))
    labels = connected_components(graph, directed=False)[1]
    lowest = np.full(len(near), len(points))
    np.minimum.at(lowest, labels, near)
    group[near] = lowest[labels]
    return group


def _crowds(points: Floats, tolerance: float) -> tuple[Ints, Ints]:
    """Links from points to the first in their cube of this diagonal, and the first points of each cube.

    The pairs among these are a bounded number for each point, however many lie in one place.
    """
    cubes = np.floor(points / (tolerance / np.sqrt(3)))
    inverse = distinct_points(cubes)[1]
    order = np.argsort(inverse, kind="stable")
    begins = np.flatnonzero(np.diff(inverse[order], prepend=-1))
    rank = np.arange(len(order)) - np.repeat(begins, np.diff(begins, append=len(order)))
    first = order[np.repeat(begins, np.diff(begins, append=len(order)))]
    return np.stack([order, first], axis=1)[rank > 0], np.sort(order[rank < _CROWD])


def _may_be_near(points: Floats, tolerance: float) -> Ints:
    """Positions of the points that have another one within a tolerance, and of some more."""
    along = points @ _DIRECTION
    order = np.argsort(along)
    close = np.diff(along[order]) <= 2 * tolerance + 1e-15 * float(np.abs(along).max(initial=0))
    return order[np.append(close, False) | np.insert(close, 0, False)]
