"""How triangles hang together: edges, boundary loops, components, Euler characteristic."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints, frozen


@dataclass(frozen=True)
class Edges:
    """The unique edges of a mesh and how faces meet in them.

    vertices: (e, 2), the lower index first, in lexicographic order.
    of_faces: (m, 3), the edge opposite each corner.
    face_counts: (e,), how many faces meet in the edge: 1 on the boundary, 2 inside, more where not manifold.
    orientation_sums: (e,), faces that run along it upward less those that run downward; 0 where two agree.
    """

    vertices: Ints
    of_faces: Ints
    face_counts: Ints
    orientation_sums: Ints


def halfedges(faces: Ints) -> Ints:
    """Directed edges, (m, 3, 2): ``[f, k]`` runs from corner k+1 to corner k+2, opposite corner k."""
    return np.stack([np.roll(faces, -1, axis=1), np.roll(faces, -2, axis=1)], axis=2)


def unique_edges(faces: Ints) -> Edges:
    """Edges of a triangle mesh by sorting its halfedges, in time proportional to their number."""
    from scipy.sparse import csr_array

    a, b, c = faces.T
    low, marked = np.empty_like(faces, order="C"), np.empty_like(faces, order="C")
    for k, (start, end) in enumerate(((b, c), (c, a), (a, b))):
        np.minimum(start, end, out=low[:, k])
        # Twice the higher vertex, and one more where the halfedge runs upward.
        marked[:, k] = 2 * np.maximum(start, end) + (start < end)
    order, marked, begins = _by_key(low.ravel(), marked.ravel())
    # As the rows of a matrix: the few halfedges of each lower vertex are sorted by the higher one.
    table = csr_array((order, marked, begins), shape=(len(begins) - 1, int(marked.max()) + 1))
    table.sort_indices()
    order, j = table.data, table.indices >> 1
    i = np.repeat(np.arange(len(begins) - 1, dtype=faces.dtype), np.diff(begins))
    new = np.ones(len(order), dtype=bool)
    new[1:] = (i[1:] != i[:-1]) | (j[1:] != j[:-1])
    first = np.flatnonzero(new).astype(order.dtype)
    counts = np.diff(first, append=first.dtype.type(len(order)))
    upward = np.cumsum(table.indices & 1, dtype=first.dtype)[first + counts - 1]
    sums = 2 * np.diff(upward, prepend=upward.dtype.type(0)) - counts
    new[0] = False
    of_faces = np.empty_like(order)
    of_faces[order] = np.cumsum(new, dtype=first.dtype)
    vertices = np.stack([i[first], j[first]]).T
    return Edges(frozen(vertices), frozen(of_faces.reshape(-1, 3)), frozen(counts), frozen(sums))


def counting_order(keys: Ints) -> Ints:
    """Stable ``argsort`` of whole numbers from 0 that are not much larger than there are keys, in linear time."""
    return _by_key(keys, np.ones(len(keys), dtype=np.int8))[0]


def _by_key(keys: Ints, values: Ints) -> tuple[Ints, Ints, Ints]:
    """A counting sort: the places of the keys in order, the values, one a key, in that order, and where keys begin."""
    from scipy.sparse import csr_array

    # Transposing a matrix with one entry a row sorts their columns.
    size = len(keys)
    starts = np.arange(size + 1, dtype=np.int32 if size < 2**31 - 1 else np.int64)
    table = csr_array((values, keys, starts), shape=(size, int(keys.max(initial=-1)) + 1)).tocsc()
    return table.indices, table.data, table.indptr


def edge_graph(edges: Ints, values: NDArray[Any], size: int) -> Any:
    """Sparse matrix, (size, size), with the values, (e,), of edges (i, j) in rows i; several edges between two vertices
    stay several entries."""
    from scipy.sparse import csr_array

    i, j = edges.T
    starts = np.append(0, np.cumsum(np.bincount(i, minlength=size)))
    if (i[1:] < i[:-1]).any():
        order = counting_order(i)
        j, values = j[order], values[order]
    return csr_array((values, j, starts), shape=(size, size))


def vertex_components(edges: Ints, size: int) -> Ints:
    """Label of the edge-connected component of each vertex, (n,); an isolated vertex is one of its own."""
    from scipy.sparse.csgraph import connected_components

    links = edge_graph(edges, np.ones(len(edges)), size)
    labels: Ints = connected_components(links, directed=False)[1]
    return labels


def boundary_loops(faces: Ints, edges: Edges) -> list[Ints]:
    """Closed chains of boundary vertices, each from its lowest vertex on, in the direction of its faces there.

    Loops that touch in a vertex are cut apart there. Where faces disagree on orientation, a loop goes on against them.
    """
    border = halfedges(faces)[edges.face_counts[edges.of_faces] == 1].tolist()
    onward: dict[int, list[int]] = {}
    for way in (0, 1):
        for number, edge in enumerate(border):
            onward.setdefault(edge[way], []).append(number)
    unused = [True] * len(border)
    loops = []
    # A walk is sequential by nature; it visits boundary edges only.
    for first in sorted(onward):
        for start in onward[first]:
            if unused[start] and border[start][0] == first:
                loops.append(frozen(np.array(_walk(border, onward, unused, start), dtype=faces.dtype)))
    return loops


def _walk(border: list[list[int]], onward: dict[int, list[int]], unused: list[bool], start: int) -> list[int]:
    """Vertices from the start of that edge until the walk comes back or finds no unused edge."""
    first, here = border[start]
    unused[start] = False
    loop = [first]
    while here != first:
        loop.append(here)
        step = next((number for number in onward[here] if unused[number]), None)
        if step is None:
            break
        unused[step] = False
        ahead, behind = border[step]
        here = behind if ahead == here else ahead
    return loop


def inner_pairs(edges: Edges) -> tuple[Ints, Ints, Ints]:
    """The two sides 3f+k of each edge that has exactly two, (i,) each, and whether these run along it the same way."""
    order = counting_order(edges.of_faces.ravel())
    inner = edges.face_counts == 2
    starts = (np.cumsum(edges.face_counts) - edges.face_counts)[inner]
    return order[starts], order[starts + 1], edges.orientation_sums[inner] != 0


def side_labels(edges: Edges) -> tuple[Ints, Ints]:
    """Labels, (m,) each, of faces as they are and of faces turned, equal where neighbors agree on what is up.

    Where a face has the same label both ways its surface is one-sided. Only edges with exactly two faces constrain.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    m = len(edges.of_faces)
    one, other, against = inner_pairs(edges)
    left, right = one // 3, other // 3
    # Double cover: copy 0 keeps a face, copy 1 turns it; a face joined to its own turned copy is one-sided.
    rows = np.concatenate([left, left + m])
    columns = np.concatenate([np.where(against, right + m, right), np.where(against, right, right + m)])
    links = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(2 * m, 2 * m))
    labels = connected_components(links, directed=False)[1]
    return labels[:m], labels[m:]


def is_orientable(edges: Edges) -> bool:
    """Whether faces can be turned so that neighbors agree, as far as edges with exactly two faces tell."""
    kept, turned = side_labels(edges)
    return bool(np.all(kept != turned))


def duplicate_faces(edges: Edges) -> Ints:
    """Faces with the vertices of an earlier one, in whatever order, and the first such, (k, 2), ascending."""
    a, b, c = edges.of_faces.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    if edges.face_counts.max(initial=0) <= 2:
        # Copies share their lowest edge, which has these two faces only; mostly, there are none.
        last, every = np.empty(len(edges.vertices), dtype=low.dtype), np.arange(len(low), dtype=low.dtype)
        last[low] = every
        latest = last[low]
        if not ((high == high[latest]) & (latest != every)).any():
            return np.empty((0, 2), dtype=np.int64)
    # Two edges make a triangle.
    keys = low * np.int64(len(edges.vertices)) + high
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    firsts = first[same.ravel()]
    copies = np.flatnonzero(firsts != np.arange(len(low)))
    return np.stack([copies, firsts[copies]], axis=1)


def pinched_vertices(faces: Ints, edges: Edges, n: int) -> Ints:
    """Vertices, ascending, whose faces fall apart if only those belong together that share an edge there."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    flat, of_halfedge = faces.ravel(), edges.of_faces.ravel()
    corners = np.arange(flat.size, dtype=np.int32).reshape(-1, 3)
    # Corners at the lower and at the higher end of each halfedge, and halfedges of one edge, two and two.
    ends = [np.roll(corners, -step, axis=1).ravel() for step in (1, 2)]
    upward = flat[ends[0]] < flat[ends[1]]
    order = counting_order(of_halfedge)
    meets = np.flatnonzero(np.diff(of_halfedge[order]) == 0)
    rows, columns = (
        np.concatenate([np.where(upward[side], end[side], other[side]) for end, other in (ends, ends[::-1])])
        for side in (order[meets], order[meets + 1])
    )
    links = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(flat.size, flat.size))
    labels = connected_components(links, directed=False)[1]
    first = np.empty(labels.max(initial=-1) + 1, dtype=np.int64)
    first[labels] = flat
    return np.flatnonzero(np.bincount(first, minlength=n) > 1)
