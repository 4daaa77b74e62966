"""Connectivity of triangle meshes: edges, boundary loops, connected components, duplicate faces, pinched vertices."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints, frozen


@dataclass(frozen=True)
class Edges:
    """The unique edges of a mesh and their incidence to faces.

    Attributes
    ----------
    vertices : (e, 2) vertex indices, the lower one first, in lexicographic order.
    of_faces : (m, 3) index of the edge opposite each corner.
    face_counts : (e,) number of faces at the edge: 1 on the boundary, 2 inside, more where the mesh is not manifold.
    orientation_sums : (e,) number of faces that run along the edge from its lower to its higher vertex, less the number
        of faces that run the other way; 0 where two faces are consistently oriented.
    """

    vertices: Ints
    of_faces: Ints
    face_counts: Ints
    orientation_sums: Ints

    def between(self, ends: Ints) -> Ints:
        """Return the edges with these ends, (k, 2), in either order, as indices, (k,)."""
        size = int(self.vertices.max(initial=-1)) + 1
        keys = self.vertices[:, 0].astype(np.int64) * size + self.vertices[:, 1]
        return np.searchsorted(keys, ends.min(axis=1).astype(np.int64) * size + ends.max(axis=1))


def halfedges(faces: Ints) -> Ints:
    """Return the directed edges, (m, 3, 2): ``[f, k]`` runs from corner k+1 to corner k+2, opposite corner k."""
    return np.stack([np.roll(faces, -1, axis=1), np.roll(faces, -2, axis=1)], axis=2)


def unique_edges(faces: Ints) -> Edges:
    """Find the edges of a triangle mesh by a counting sort of its halfedges, in linear time."""
    from scipy.sparse import csr_array

    a, b, c = faces.T
    low, marked = np.empty_like(faces, order="C"), np.empty_like(faces, order="C")
    for k, (start, end) in enumerate(((b, c), (c, a), (a, b))):
        np.minimum(start, end, out=low[:, k])
        # Twice the higher vertex, plus one if the halfedge starts at the lower vertex.
        marked[:, k] = 2 * np.maximum(start, end) + (start < end)
    order, marked, begins = _by_key(low.ravel(), marked.ravel())
    # The halfedges of each lower vertex are the entries of one row, sorted by the higher vertex.
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
    """Return the stable ``argsort`` of nonnegative integers in time linear in their number and maximum."""
    return _by_key(keys, np.ones(len(keys), dtype=np.int8))[0]


def _by_key(keys: Ints, values: Ints) -> tuple[Ints, Ints, Ints]:
    """Sort values by keys; return the order, the sorted values, and the start of each key."""
    from scipy.sparse import csr_array

    # Transposing a matrix with one entry a row is a counting sort by column.
    size = len(keys)
    starts = np.arange(size + 1, dtype=np.int32 if size < 2**31 - 1 else np.int64)
    table = csr_array((values, keys, starts), shape=(size, int(keys.max(initial=-1)) + 1)).tocsc()
    return table.indices, table.data, table.indptr


def edge_graph(edges: Ints, values: NDArray[Any], size: int) -> Any:
    """Assemble a sparse matrix, (size, size), with one entry (i, j) per edge; parallel edges stay separate entries."""
    from scipy.sparse import csr_array

    i, j = edges.T
    starts = np.append(0, np.cumsum(np.bincount(i, minlength=size)))
    if (i[1:] < i[:-1]).any():
        order = counting_order(i)
        j, values = j[order], values[order]
    return csr_array((values, j, starts), shape=(size, size))


def vertex_components(edges: Ints, size: int) -> Ints:
    """Label the connected component of each vertex, (size,), in the order of their lowest vertices."""
    return linked_components(edges[:, 0], edges[:, 1], size)


def linked_components(one: Ints, other: Ints, size: int) -> Ints:
    """Label the connected component of each of ``size`` nodes in the graph with the links (one[i], other[i])."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(size, size))
    labels: Ints = connected_components(graph, directed=False)[1]
    return labels


def boundary_loops(faces: Ints, edges: Edges) -> list[Ints]:
    """Trace the closed chains of boundary vertices, each from its lowest vertex, in the direction of its faces.

    At a pinched vertex a loop stays within the fan by which it arrives, so it may pass a vertex several times. At faces
    of opposite orientation a loop continues against them. At edges of more than two faces it is an open chain.
    """
    outer = edges.face_counts[edges.of_faces] == 1
    if not outer.any():
        return []
    fans, vertex_of = corner_fans(faces, edges, most=2)
    border = halfedges(fans)[outer].tolist()
    onward: dict[int, list[int]] = {}
    for way in (0, 1):
        for number, edge in enumerate(border):
            onward.setdefault(edge[way], []).append(number)
    unused = set(range(len(border)))
    loops = []
    # Open chains start at their ends.
    for first in sorted(onward, key=lambda fan: (len(onward[fan]) != 1, fan)):
        for start in onward[first]:
            if start in unused and (border[start][0] == first or len(onward[first]) == 1):
                loops.append(frozen(vertex_of[_walk(border, onward, unused, first, start)]))
    return loops


def _walk(border: list[list[int]], onward: dict[int, list[int]], unused: set[int], first: int, start: int) -> list[int]:
    """Follow unused boundary edges from a fan by the edge ``start`` until the walk closes or ends; return its fans."""
    step: int | None = start
    loop = [first]
    while step is not None:
        unused.remove(step)
        loop.append(sum(border[step]) - loop[-1])
        closed = loop[-1] == loop[0]
        step = None if closed else next((number for number in onward[loop[-1]] if number in unused), None)
    return loop[:-1] if closed else loop


def inner_pairs(edges: Edges) -> tuple[Ints, Ints, Ints]:
    """Return the two halfedges 3f+k of each edge with exactly two faces, and whether both run in the same direction."""
    order = counting_order(edges.of_faces.ravel())
    inner = edges.face_counts == 2
    starts = (np.cumsum(edges.face_counts) - edges.face_counts)[inner]
    return order[starts], order[starts + 1], edges.orientation_sums[inner] != 0


def duplicate_faces(edges: Edges) -> Ints:
    """Return faces with the vertices of an earlier face in any order, and the first such face, (k, 2), ascending."""
    a, b, c = edges.of_faces.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    if edges.face_counts.max(initial=0) <= 2:
        # Duplicates share their lowest edge, and that edge has no other face. Most meshes have none.
        last, every = np.empty(len(edges.vertices), dtype=low.dtype), np.arange(len(low), dtype=low.dtype)
        last[low] = every
        latest = last[low]
        if not ((high == high[latest]) & (latest != every)).any():
            return np.empty((0, 2), dtype=np.int64)
    # Two of its edges determine a triangle.
    keys = low * np.int64(len(edges.vertices)) + high
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    firsts = first[same.ravel()]
    copies = np.flatnonzero(firsts != np.arange(len(low)))
    return np.stack([copies, firsts[copies]], axis=1)


def fan_labels(faces: Ints, edges: Edges, most: int | None = None) -> Ints:
    """Label the fan of each corner, (3m,): faces at a vertex that are connected across edges at this vertex.

    most: of faces at an edge that connects; by default any number.
    """
    flat, of_halfedge = faces.ravel(), edges.of_faces.ravel()
    corners = np.arange(flat.size, dtype=np.int32).reshape(-1, 3)
    # The corners at the start and end of each halfedge; consecutive halfedges of one edge are linked.
    ends = [np.roll(corners, -step, axis=1).ravel() for step in (1, 2)]
    upward = flat[ends[0]] < flat[ends[1]]
    order = counting_order(of_halfedge)
    sorted_edges = of_halfedge[order]
    joined = np.diff(sorted_edges) == 0
    if most:
        joined &= edges.face_counts[sorted_edges[1:]] <= most
    meets = np.flatnonzero(joined)
    one, other = (
        np.concatenate([np.where(upward[side], end[side], far[side]) for end, far in (ends, ends[::-1])])
        for side in (order[meets], order[meets + 1])
    )
    return linked_components(one, other, flat.size)


def corner_fans(faces: Ints, edges: Edges, most: int | None = None) -> tuple[Ints, Ints]:
    """Label the fan of each corner, (m, 3), as in `fan_labels`, and return the vertex of each fan, (k,), ascending."""
    labels, flat = fan_labels(faces, edges, most), faces.ravel()
    vertex_of = np.empty(labels.max(initial=-1) + 1, dtype=flat.dtype)
    vertex_of[labels] = flat
    by_vertex = counting_order(vertex_of)
    rank = np.empty_like(by_vertex)
    rank[by_vertex] = np.arange(len(by_vertex), dtype=rank.dtype)
    return rank[labels].reshape(-1, 3), vertex_of[by_vertex]


def pinched_vertices(faces: Ints, edges: Edges, most: int | None = None) -> Ints:
    """Return the vertices, ascending, whose faces form several fans: groups that share no edge at the vertex.

    most : of faces at an edge that connects, as in `fan_labels`.
    """
    vertex_of = corner_fans(faces, edges, most)[1]
    return np.unique(vertex_of[1:][vertex_of[1:] == vertex_of[:-1]])
