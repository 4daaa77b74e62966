"""Distances between all vertices at most a limit apart, as a sparse symmetric matrix."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from math import inf
from os import cpu_count
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled_in_place
from geomhw.geodesic.front import TOUCHED, Extent, Front, empty_front, extent_above, reset, start, with_more_room
from geomhw.geodesic.unfolded_faces import Surface
from geomhw.geodesic.window_propagation import propagate
from geomhw.mesh.triangle_mesh import TriangleMesh

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: Sources of a task of a thread.
TASK = 64


class RowFiller(NamedTuple):
    """How rows of distances are computed. empty: returns a new front. fill: as `fill_rows`, without the surface."""

    empty: Callable[[], Any]
    fill: Callable[..., tuple[int, int]]


def exact_rows(surface: Surface) -> RowFiller:
    """Rows of exact distances."""
    return RowFiller(partial(empty_front, surface), partial(fill_rows, surface))


def distance_pairs(
    mesh: TriangleMesh, surface: Surface, rows: RowFiller, limit: float, part: slice = slice(None)
) -> tuple[Ints, Ints, Floats]:
    """Return rows, columns and distances of all pairs of vertices within a limit, one of each two equal entries.

    Each pair is computed once, from the end at which a distance function is smaller. Paths from there need not reach
    places from which the way back up to the height of their source exceeds the limit. part: selects tasks.
    """
    n, used = mesh.n_vertices, np.setdiff1d(np.arange(mesh.n_vertices), mesh.unreferenced_vertices)
    heights = _heights(mesh, surface) if limit < inf else np.zeros(n)
    ranks = np.empty(n, dtype=np.int64)
    ranks[np.argsort(heights, kind="stable")] = np.arange(n)
    fronts: SimpleQueue[Any] = SimpleQueue()
    for _ in range(cpu_count() or 1):
        fronts.put(rows.empty())

    def compute(sources: Ints) -> tuple[Ints, Ints, Floats]:
        front = fronts.get()
        found = _sparse_rows(rows, front, sources, Extent(limit, 0.0, heights), ranks)
        fronts.put(found[0])
        return found[1:]

    with ThreadPoolExecutor(cpu_count()) as threads:
        tasks = [used[i : i + TASK] for i in range(0, len(used), TASK)][part]
        none = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int32), np.empty(0)
        found = [none, *threads.map(compute, tasks)]
    counts, columns, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return np.repeat(np.concatenate([used[:0], *tasks]), counts), columns, values


def _heights(mesh: TriangleMesh, surface: Surface) -> Floats:
    """Distance from one vertex of each connected component."""
    front = empty_front(surface)
    start(front, np.unique(mesh.components, return_index=True)[1], 0)
    extent = Extent(inf, 0.0, np.zeros(mesh.n_vertices))
    while propagate(surface, front, np.empty((0, 3)), np.empty(0, dtype=np.int64), extent, np.empty(0, np.int64)) < 0:
        front = with_more_room(front)
    return np.where(front.distance < inf, front.distance, 0.0)


def _sparse_rows(
    rows: RowFiller, front: Any, sources: Ints, extent: Extent, ranks: Ints
) -> tuple[Any, Ints, Ints, Floats]:
    """Return the front with all its room, and for each source a count, and the vertices of higher rank in reach with
    their distances.
    """
    counts, done, end = np.zeros(len(sources), dtype=np.int64), 0, 0
    columns, values = np.empty(1 << 14, dtype=np.int32), np.empty(1 << 14)
    while True:
        done, end = rows.fill(front, sources, extent, ranks, counts, columns, values, done, end)
        if done == len(sources):
            return front, counts, columns[:end], values[:end]
        if front.counts[TOUCHED]:
            front = with_more_room(front)
        else:
            columns, values = np.append(columns, columns), np.append(values, values)


@compiled_in_place
def fill_rows(
    surface: Surface,
    front: Front,
    sources: Ints,
    extent: Extent,
    ranks: Ints,
    counts: Ints,
    columns: Ints,
    values: Floats,
    done: int,
    end: int,
) -> tuple[int, int]:
    """Append rows of distances until all sources are done or room is lacking, in the front or for the next row."""
    none, no_places = sources[:0], surface.points[:0]
    while done < len(sources):
        v = sources[done]
        if front.counts[TOUCHED] == 0:
            start(front, sources[done : done + 1], 0)
        if propagate(surface, front, no_places, none, extent_above(extent, v), none) < 0:
            return done, end
        added = append_row(front, len(front.waiting), extent.limit, ranks, ranks[v], columns, values, end)
        reset(front)
        if end + added > len(columns):
            return done, end
        counts[done] = added
        done, end = done + 1, end + added
    return done, end


@compiled_in_place
def append_row(
    front: Any, first: int, limit: float, ranks: Ints, rank: int, columns: Ints, values: Floats, end: int
) -> int:
    """Append distances within a limit at vertices of at least some rank, as far as there is room; return their number.

    first: the number of items of a front that come before the vertices.
    """
    added = 0
    for item in front.touched[: front.counts[TOUCHED]]:
        v = item - first
        if v >= 0 and ranks[v] >= rank and front.distance[v] <= limit:
            if end + added < len(columns):
                columns[end + added], values[end + added] = v, front.distance[v]
            added += 1
    return added


def symmetric_matrix(rows: Ints, columns: Ints, values: Floats, n: int) -> "csr_array":
    """Return a symmetric matrix from one of each two equal entries; stored zeros stay."""
    from scipy.sparse import csr_array

    starts = np.append(
        0, np.cumsum(np.bincount(rows, minlength=n) + np.bincount(columns[rows != columns], minlength=n))
    )
    indices, data = np.empty(starts[-1], dtype=np.int32), np.empty(starts[-1])
    place_entries(rows, columns, values, starts[:-1].copy(), indices, data)
    # The columns of a symmetric matrix are its rows; conversion sorts the entries.
    by_column = csr_array((data, indices, starts), shape=(n, n)).tocsc()
    return csr_array((by_column.data, by_column.indices, by_column.indptr), shape=(n, n))


@compiled_in_place
def place_entries(rows: Ints, columns: Ints, values: Floats, places: Ints, indices: Ints, data: Floats) -> None:
    """Write each entry to the next places of its row and of its column."""
    for k in range(len(rows)):
        row, column = rows[k], columns[k]
        indices[places[row]], data[places[row]] = column, values[k]
        places[row] += 1
        if column != row:
            indices[places[column]], data[places[column]] = row, values[k]
            places[column] += 1
