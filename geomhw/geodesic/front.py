"""State of an exact distance query: arrivals at vertices, windows, and the queue of events, a binary heap."""

from math import inf
from typing import Any, NamedTuple, Protocol

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.unfolded_faces import Surface
from geomhw.geodesic.windows import LAST, WINDOW

#: List of the windows that wait at a halfedge: its first record, their number, and how often it has been propagated.
WINDOWS = np.dtype([(name, np.int32) for name in ("first", "count", "events")])
#: Places in ``counts``, after those of `windows`: number of events in the queue, and of items in ``touched``.
WAITING, TOUCHED = 3, 4
#: Initial number of window records.
ROOM = 1 << 15


class Front(NamedTuple):
    """State of one query: arrivals at vertices, windows, and the queue of events.

    distance, origin, halfedge, entry: (n,), as in `Arrivals`. waiting: (3m,), the windows at each halfedge. keys,
    items: the queue, a binary heap; places: (3m+n+k,), one more than the place of each item there. Item h < 3m is a
    halfedge, 3m+v a vertex, 3m+n+i source point i. touched: (3m+n,), halfedges and vertices whose state has changed,
    as items.
    """

    distance: Floats
    origin: Ints
    halfedge: Ints
    entry: Floats
    waiting: Any
    windows: Any
    counts: Ints
    keys: Floats
    items: Ints
    places: Ints
    touched: Ints


class Queue(Protocol):
    """What a state has of a queue and of a list of items whose state has changed, as in `Front`."""

    @property
    def counts(self) -> Ints: ...
    @property
    def keys(self) -> Floats: ...
    @property
    def items(self) -> Ints: ...
    @property
    def places(self) -> Ints: ...
    @property
    def touched(self) -> Ints: ...


class Extent(NamedTuple):
    """Where distances are wanted: at most a limit, and at vertices of at least some height.

    heights: (n,), of a function that differs between two points of the surface by at most their distance.
    """

    limit: float
    height: float
    heights: Floats


@compiled_in_place
def limit_at(extent: Extent, v: int) -> float:
    """Largest length at a vertex of paths that may continue to a wanted place."""
    return extent.limit - max(extent.height - extent.heights[v], 0.0)


@compiled_in_place
def limit_on_edge(extent: Extent, low: int, high: int, base: float) -> float:
    """Largest length at an edge of paths that may continue to a wanted place."""
    highest = (extent.heights[low] + extent.heights[high] + base) / 2
    return extent.limit - max(extent.height - highest, 0.0)


@compiled_in_place
def extent_above(extent: Extent, v: int) -> Extent:
    """The extent in which distances are wanted at vertices of at least the height of v, up to rounding."""
    height = extent.heights[v] * (1 - 1e-12) - 1e-9 * extent.limit
    return Extent(extent.limit, height, extent.heights)


def empty_front(surface: Surface, k: int = 0) -> Front:
    """Return a front without sources, with room for k source points. Most memory is used only once it is written to."""
    n, h = len(surface.points), surface.faces.size
    return Front(
        np.full(n, inf),
        np.empty(n, dtype=np.int32),
        np.empty(n, dtype=np.int32),
        np.empty(n),
        np.zeros(h, dtype=WINDOWS),
        np.zeros(ROOM, dtype=WINDOW),
        np.zeros(5, dtype=np.int64),
        np.empty(h + n + k),
        np.empty(h + n + k, dtype=np.int32),
        np.zeros(h + n + k, dtype=np.int32),
        np.empty(h + n, dtype=np.int32),
    )


def with_more_room(front: Front) -> Front:
    """Return the front with twice as many window records."""
    windows = np.empty(2 * len(front.windows), dtype=WINDOW)
    used = front.counts[LAST] + 1
    windows[:used] = front.windows[:used]
    return front._replace(windows=windows)


def reached(front: Front) -> Ints:
    """Return the vertices with a distance, in the order in which they were first reached."""
    items = front.touched[: front.counts[TOUCHED]]
    vertices: Ints = items[items >= len(front.waiting)] - len(front.waiting)
    return vertices


@compiled_in_place
def start(front: Front, vertices: Ints, k: int) -> None:
    """Add sources to a front: vertices, and source points 0 to k-1."""
    h, n = len(front.waiting), len(front.distance)
    for v in vertices:
        if front.distance[v] > 0:
            touch(front, h + v)
            front.distance[v], front.origin[v], front.halfedge[v], front.entry[v] = 0.0, v, -1, 0.0
            push(front, h + v, 0.0)
    for i in range(k):
        push(front, h + n + i, 0.0)


@compiled_in_place
def reset(front: Front) -> None:
    """Remove sources, arrivals and windows; the time is proportional to their number."""
    h = len(front.waiting)
    for i in front.touched[: front.counts[TOUCHED]]:
        if i < h:
            clear(front.waiting[i])
        else:
            front.distance[i - h] = inf
    for i in front.items[: front.counts[WAITING]]:
        front.places[i] = 0
    front.counts[:] = 0


@compiled_in_place
def clear(waiting: Any) -> None:
    """Remove the windows at a halfedge."""
    waiting.first = waiting.count = waiting.events = 0


@compiled_in_place
def clear_windows(front: Front) -> None:
    """Remove windows and events; arrivals at vertices stay, as upper bounds for further sources."""
    for i in front.touched[: front.counts[TOUCHED]]:
        if i < len(front.waiting):
            clear(front.waiting[i])
    for i in front.items[: front.counts[WAITING]]:
        front.places[i] = 0
    front.counts[:] = 0


@compiled_in_place
def touch(front: Queue, item: int) -> None:
    """Note that the state of an item has changed."""
    front.touched[front.counts[TOUCHED]] = item
    front.counts[TOUCHED] += 1


@compiled_in_place
def push(front: Queue, item: int, key: float) -> None:
    """Put an item into the queue, or move it forward."""
    keys, items, places = front.keys, front.items, front.places
    p = places[item] - 1
    if p < 0:
        p = front.counts[WAITING]
        front.counts[WAITING] += 1
    elif key >= keys[p]:
        return
    while p > 0 and keys[(p - 1) // 2] > key:
        up = (p - 1) // 2
        keys[p], items[p] = keys[up], items[up]
        places[items[p]] = p + 1
        p = up
    keys[p], items[p], places[item] = key, item, p + 1


@compiled_in_place
def pop(front: Queue) -> None:
    """Remove the item of the least key from the queue."""
    keys, items, places = front.keys, front.items, front.places
    places[items[0]] = 0
    front.counts[WAITING] -= 1
    size, p = front.counts[WAITING], 0
    while size > 0:
        down = 2 * p + 1
        if down + 1 < size and keys[down + 1] < keys[down]:
            down += 1
        if down >= size or keys[down] >= keys[size]:
            keys[p], items[p] = keys[size], items[size]
            places[items[p]] = p + 1
            return
        keys[p], items[p] = keys[down], items[down]
        places[items[p]] = p + 1
        p = down
