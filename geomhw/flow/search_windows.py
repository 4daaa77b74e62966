"""Windows of the search for the nearest polyline: parts of edges that straight lines from a point reach.

Where shortest paths turn at a vertex, it is a source of windows of its own.
"""

from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place, compiled_inline
from geomhw.flow.flat_faces import BOUNDARY, FlatFaces
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Shortest paths turn at inner vertices whose angle exceeds 2π by more, in radians.
SADDLE = 0.01
#: Distances are equal within this share.
EQUAL = 1e-12
#: Most windows that wait; later ones replace the first.
MOST_WAITING = 1 << 17


class Search(NamedTuple):
    """Windows that wait, with the edge 3f + k that each enters a face f by: edges, (w,); planes, (w, 9).

    A row of planes holds the ends of the edge, from corner k + 1 to k + 2, the ends of its visible part, relative to
    the source, and the distance of the source from the point. Where shortest paths turn at corner k of a face, it is
    -1 - (3f + k), with the places of corners k, k + 1 and k + 2, and the distance. reached, stamps: (n,), the shortest
    distance at which a vertex was reached, and the number of that search. number: (1,), of searches.
    """

    edges: Ints
    planes: Floats
    reached: Floats
    stamps: Ints
    number: Ints


def search_room(mesh: TriangleMesh) -> Search:
    """Return room for the windows of searches."""
    stamps, number = np.zeros(mesh.n_vertices, dtype=np.int64), np.zeros(1, dtype=np.int64)
    windows = np.empty(MOST_WAITING, dtype=np.int64), np.empty((MOST_WAITING, 9))
    return Search(*windows, np.empty(mesh.n_vertices), stamps, number)


@compiled_in_place
def push(
    flat: FlatFaces,
    search: Search,
    count: int,
    edge: int,
    px: float,
    py: float,
    qx: float,
    qy: float,
    ux: float,
    uy: float,
    wx: float,
    wy: float,
    offset: float,
) -> int:
    """Add the window from u to w on the edge from p to q, if a face is behind it; the number of windows."""
    other = flat.across[edge]
    if other < 0:
        return count
    row = search.planes[count % MOST_WAITING]
    search.edges[count % MOST_WAITING] = other
    if flat.corners[edge // 3, (edge % 3 + 1) % 3] == flat.corners[other // 3, (other % 3 + 1) % 3]:
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7] = px, py, qx, qy, ux, uy, wx, wy
    else:
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7] = qx, qy, px, py, wx, wy, ux, uy
    row[8] = offset
    return count + 1


@compiled_in_place
def push_vertex(
    flat: FlatFaces,
    search: Search,
    count: int,
    face: int,
    k: int,
    ax: float,
    ay: float,
    px: float,
    py: float,
    qx: float,
    qy: float,
    offset: float,
) -> int:
    """Add corner k of a face, at a, with the next ones at p and q, if shortest paths turn there."""
    total = flat.totals[flat.corners[face, k]]
    if total <= 2 * pi + SADDLE and total != BOUNDARY:
        return count
    row = search.planes[count % MOST_WAITING]
    search.edges[count % MOST_WAITING] = -1 - (3 * face + k)
    row[0], row[1], row[2], row[3], row[4], row[5], row[8] = ax, ay, px, py, qx, qy, offset
    return count + 1


@compiled_in_place
def reach(search: Search, vertex: int, distance: float) -> None:
    """Keep the shortest distance at which a vertex was reached."""
    if search.stamps[vertex] != search.number[0] or distance < search.reached[vertex]:
        search.stamps[vertex], search.reached[vertex] = search.number[0], distance


@compiled_in_place
def is_nearer(search: Search, vertex: int, dx: float, dy: float, offset: float, x: float, y: float) -> bool:
    """Whether the far end of a window, at (x, y), is reached over a vertex sooner; then all of the window is."""
    if search.stamps[vertex] != search.number[0]:
        return False
    return search.reached[vertex] + sqrt(dx * dx + dy * dy) < (offset + sqrt(x * x + y * y)) * (1 - EQUAL)


@compiled_inline
def hit(ux: float, uy: float, px: float, py: float, qx: float, qy: float) -> tuple[float, float]:
    """Return the point of the segment from p to q in the direction u from the origin."""
    one, two = ux * py - uy * px, ux * qy - uy * qx
    t = min(max(one / (one - two), 0.0), 1.0) if one != two else 0.0
    return px + t * (qx - px), py + t * (qy - py)
