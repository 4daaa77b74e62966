"""Level sets of a piecewise-linear function as a graph: points on edges and vertices, linked in faces and along edges.

Each vertex has a place among the k ascending levels: 2i between levels i-1 and i, 2i+1 at level i. Comparisons of
places decide all ties, so that neighboring faces agree. A link is counted once:

- within each face that a level crosses,
- along each edge whose ends are at one level, unless all faces at the edge are flat, at that level.
"""

from dataclasses import dataclass

import numpy as np

from geomhw.arrays import Floats, Ints, ranges
from geomhw.compiled import compiled
from geomhw.curves.level_regions import link_regions
from geomhw.mesh.topology import linked_components
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Kinds of links: between lower values and others, between a flat face and higher values, along a boundary, and along
#: an edge whose faces are all on one side of the level.
LOWER, HIGHER, BORDER, RIDGE = range(4)
#: A level crosses an edge at its end if it differs from the value there by less than this share of the values at the
#: ends of the edge, or of their difference if that is larger.
ROUNDING = 4 * float(np.finfo(float).eps)
#: Largest distance from the end of an edge, as a share of the edge, at which that happens.
NEAR = 1e-9
#: Times that vertices move to levels that cross their edges nearby.
ROUNDS = 4


@dataclass(frozen=True, eq=False)
class LevelGraph:
    """The graph of N nodes and L links of the level sets of k levels.

    Attributes
    ----------
    ends : (N, 2) vertices of the edge of each node, equal at a vertex. The first n nodes are the vertices.
    shares : (N,) position of each node on its edge, from 0 at the first end to 1.
    links : (L, 2) nodes.
    faces : (L,) a face that contains the link.
    levels : (L,) index of the level.
    kinds : (L,) `LOWER`, `HIGHER`, `BORDER` or `RIDGE`.
    turns : (L,) 1 if higher values are on the left of the link, -1 on the right, seen against the normal of its face.
    regions : (L, 2) regions at the side of lower and of higher values; -1 outside of the mesh.
    areas : (R,) areas of the regions into which the level sets divide the surface.
    partners : (2L,) the link end that continues end 2l or 2l+1 of link l, or -1.
    """

    ends: Ints
    shares: Floats
    links: Ints
    faces: Ints
    levels: Ints
    kinds: Ints
    turns: Ints
    regions: Ints
    areas: Floats
    partners: Ints


def level_graph(mesh: TriangleMesh, values: Floats, levels: Floats) -> LevelGraph:
    """Return the level sets of a function, (n,), for ascending levels, on faces with finite values.

    Copies of other faces are left out.
    """
    has_values = np.asarray(np.isfinite(values)[mesh.faces].all(axis=1))
    has_values[mesh.duplicate_faces[:, 0]] = False
    kept = np.flatnonzero(has_values)
    faces, of = mesh.faces[kept], mesh.edge_table.of_faces[kept]
    counts = np.bincount(of.ravel(), minlength=mesh.n_edges)
    a, b = mesh.edges.T
    place, edge, share = _crossings(mesh, values, levels, counts > 0)
    first, after = _crossed(place[a], place[b])
    begins = mesh.n_vertices + np.cumsum(np.append(0, np.where(counts > 0, after - first, 0)))
    vertices = np.arange(mesh.n_vertices)
    ends = np.stack([np.append(vertices, a[edge]), np.append(vertices, b[edge])], axis=1)
    shares = np.append(np.zeros(mesh.n_vertices), share)

    # Links within faces: each crossed face has two nodes among its edges and corners.
    P = place[faces]
    lowest, beyond = _crossed(P.min(axis=1), P.max(axis=1))
    f, j = np.repeat(np.arange(len(P)), beyond - lowest), ranges(lowest, beyond - lowest)
    e, corner = of[f], faces[f]
    crossed = (first[e] <= j[:, None]) & (j[:, None] < after[e])
    on_edge = np.where(crossed, begins[e] + j[:, None] - first[e], -1)
    nodes = np.concatenate([on_edge, np.where(P[f] == 2 * j[:, None] + 1, corner, -1)], axis=1)
    inner = nodes[nodes >= 0].reshape(-1, 2)
    above = (P[f] > 2 * j[:, None] + 1).argmax(axis=1)

    # Links along edges.
    flat = P.min(axis=1) == P.max(axis=1)
    level_edge = (counts > 0) & (place[a] == place[b]) & (place[a] % 2 == 1)
    level_edge &= np.bincount(of[flat].ravel(), minlength=mesh.n_edges) < counts
    g, k = np.nonzero(level_edge[of])
    side = np.sign(P[g, k] - place[a[of[g, k]]])
    order = np.lexsort((g, side, of[g, k]))
    g, k, side, named = g[order], k[order], side[order], of[g, k][order]
    start = np.flatnonzero(np.diff(named, prepend=-1))
    last = np.append(start, len(named))[1:] - 1
    kinds = np.where(
        side[start] < side[last],
        np.where(side[start] < 0, LOWER, HIGHER),
        np.where(counts[named[start]] == 1, BORDER, RIDGE),
    )
    face = np.where(kinds == HIGHER, last, start)  # one that is not flat

    links = np.concatenate([inner, mesh.edges[named[start]]])
    rows, apex = np.concatenate([f, g[face]]), np.concatenate([above, k[face]])
    signs = np.concatenate([np.ones(len(f), dtype=np.int64), side[face]])
    kinds = np.concatenate([np.full(len(f), LOWER), kinds])
    levels_of = np.concatenate([j, (place[a[named[start]]] - 1) // 2])
    turns = _turn(faces[rows], ends[links], shares[links], apex) * signs
    regions, areas = link_regions(mesh, kept, values, levels, place, of, f, j, (named, g, k, side, start, last))
    partners = _partners(mesh, place, faces, of, links, rows, kinds)
    return LevelGraph(ends, shares, links, kept[rows], levels_of, kinds, turns, regions, areas, partners)


def _crossings(mesh: TriangleMesh, values: Floats, levels: Floats, used: Ints) -> tuple[Ints, Ints, Floats]:
    """Return the place of each vertex, and edge and share of each crossing of an edge, edge by edge.

    A vertex moves to a level that crosses one of its edges within rounding.
    """
    at = np.searchsorted(levels, values)
    place = 2 * at + (levels[np.minimum(at, len(levels) - 1)] == values)
    a, b = mesh.edges.T
    for last in range(ROUNDS + 1):
        first, after = _crossed(place[a], place[b])
        counts = np.where(used, after - first, 0)
        edge, level = np.repeat(np.arange(len(first)), counts), ranges(first, counts)
        start, end = values[a[edge]] / 2, values[b[edge]] / 2  # halves: differences do not overflow
        share = (levels[level] / 2 - start) / (end - start)
        size = np.maximum(np.abs(start), np.abs(end))
        near = np.minimum(ROUNDING * np.maximum(size / np.abs(end - start), 1.0), NEAR)
        at_start, at_end = share <= near, 1 - share <= near
        if last == ROUNDS or not (at_start.any() or at_end.any()):
            break
        place[a[edge[at_start]]] = 2 * level[at_start] + 1
        place[b[edge[at_end]]] = 2 * level[at_end] + 1
    return place, edge, share


def _crossed(one: Ints, other: Ints) -> tuple[Ints, Ints]:
    """Return the first level strictly between two places, and the one after the last."""
    low, high = np.minimum(one, other), np.maximum(one, other)
    first = (low + 1) // 2
    return first, np.maximum(high // 2, first)


def barycentric(corners: Ints, ends: Ints, shares: Floats) -> Floats:
    """Return barycentric coordinates, (..., 3), of points on edges, (..., 2), of faces with these corners, (..., 3)."""
    low, high = (corners == ends[..., k, None] for k in (0, 1))
    return np.asarray(low * (1 - shares)[..., None] + (high & ~low) * shares[..., None])


def _turn(corners: Ints, ends: Ints, shares: Floats, apex: Ints) -> Ints:
    """Return 1 if a corner of a face is on the left of a segment in it, else -1."""
    start, end = (barycentric(corners, ends[:, k], shares[:, k]) for k in (0, 1))
    following, before = (apex + 1) % 3, (apex + 2) % 3
    rows = np.arange(len(apex))
    cross = start[rows, following] * end[rows, before] - start[rows, before] * end[rows, following]
    return np.where(cross >= 0, 1, -1)


def _partners(mesh: TriangleMesh, place: Ints, faces: Ints, of: Ints, links: Ints, rows: Ints, kinds: Ints) -> Ints:
    """Return the link end that continues each link end: of the same kind, where two meet.

    Where more meet in a vertex, links round lower values continue round the sector of these at the vertex.
    """
    nodes, kind = links.ravel(), np.repeat(kinds, 2)
    key = nodes * 4 + kind
    _, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
    many = (count[inverse] > 2) & (kind == LOWER) & (nodes < mesh.n_vertices)
    if many.any():
        at = np.isin(faces, nodes[many])
        f, k = np.nonzero(at & (np.minimum(place[np.roll(faces, -1, 1)], place[np.roll(faces, -2, 1)]) < place[faces]))
        corner, ways = [], []
        for step in (1, 2):  # edges from corner k to corner k+step, opposite the third
            end, third = faces[f, (k + step) % 3], faces[f, (k + 3 - step) % 3]
            here = place[faces[f, k]]
            joins = (place[end] < here) | ((place[end] == here) & (place[third] < here))
            e = of[f, (k + 3 - step) % 3]
            corner.append((3 * f + k)[joins])
            ways.append((2 * e + (mesh.edges[e, 0] == end))[joins])
        size = faces.size
        sector = linked_components(np.concatenate(corner), np.concatenate(ways) + size, size + 2 * mesh.n_edges)
        face = np.repeat(rows, 2)[many]
        own = 3 * face + (faces[face] == nodes[many][:, None]).argmax(axis=1)
        key[many] = 4 * len(place) * 4 + 4 * links.max() + sector[own]
        _, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
    pairs = np.argsort(inverse, kind="stable")
    pairs = pairs[count[inverse[pairs]] == 2].reshape(-1, 2)
    partners = np.full(len(nodes), -1)
    partners[pairs[:, 0]], partners[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    return partners


@compiled
def chains(partners: Ints) -> tuple[Ints, Ints, int]:
    """Return the entry ends of links chain by chain, (L,), the start of each chain, (c + 1,), the number of open ones.

    Link l has the ends 2l and 2l+1. partners: (2L,), the end that continues each end, or -1.
    """
    size = len(partners) // 2
    order, starts, used = np.empty(size, np.int64), np.zeros(size + 1, np.int64), np.zeros(size, np.bool_)
    count = at = opened = 0
    for closed in range(2):
        for first in range(2 * size):
            if used[first // 2] or (closed == 0 and partners[first] >= 0):
                continue
            end = first
            while end >= 0 and not used[end // 2]:
                order[at], used[end // 2] = end, True
                at += 1
                end = partners[end ^ 1]
            count += 1
            starts[count] = at
        if closed == 0:
            opened = count
    return order, starts[: count + 1], opened
