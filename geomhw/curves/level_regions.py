"""Regions into which level sets divide a surface: their areas, and the area on each side of a line that separates."""

import numpy as np

from geomhw.arrays import Floats, Ints, ranges
from geomhw.mesh.topology import linked_components
from geomhw.mesh.triangle_mesh import TriangleMesh


def link_regions(
    mesh: TriangleMesh,
    kept: Ints,
    values: Floats,
    levels: Floats,
    place: Ints,
    of: Ints,
    f: Ints,
    j: Ints,
    along: tuple[Ints, Ints, Ints, Ints, Ints, Ints],
) -> tuple[Ints, Floats]:
    """Return the regions below and above each link, (L, 2), and the areas of the regions.

    Each face has one piece between consecutive levels, or one if it is flat. Pieces of neighboring faces form one
    region where they share a part of an edge.

    f, j: faces, of those kept, and levels of the links within faces. along: the halfedges at links along edges, by edge
    and side: edge, face, corner, side, first and last halfedge of each edge.
    """
    P, (a, b) = place[mesh.faces[kept]], mesh.edges.T
    low, high = P.min(axis=1), P.max(axis=1)
    flat, first = (low == high) & (low % 2 == 1), (low + 1) // 2
    count = np.where(flat, 1, high // 2 - first + 1)
    begins = np.append(0, np.cumsum(count))
    # Areas: the shares of a face below its levels.
    share = _share_below(values[mesh.faces[kept[f]]], levels[j])
    area = np.zeros(begins[-1])
    area[begins[1:] - 1] = 1.0
    below = begins[f] + j - first[f]
    np.add.at(area, below, share)
    np.add.at(area, below + 1, -share)
    area *= np.repeat(mesh.face_areas[kept], count)
    # Each part of an edge is a key that joins the pieces beside it; at an edge at a level, each side.
    edge_low, edge_high = np.minimum(place[a], place[b]), np.maximum(place[a], place[b])
    at_level, edge_first = (edge_low == edge_high) & (edge_low % 2 == 1), (edge_low + 1) // 2
    keys = np.append(0, np.cumsum(np.where(at_level, 3, edge_high // 2 - edge_first + 1)))
    e, g = of.ravel(), np.repeat(np.arange(len(kept)), 3)
    bounded = at_level[e]
    side = np.sign(P.ravel() - edge_low[e])
    one = _piece_beside(begins, first, flat, g[bounded], edge_low[e[bounded]], side[bounded])
    counts = edge_high[e[~bounded]] // 2 + 1 - edge_first[e[~bounded]]
    h, i = (np.repeat(each[~bounded], counts) for each in (g, e))
    band = ranges(edge_first[e[~bounded]], counts)
    pieces = np.concatenate([one, begins[h] + band - first[h]])
    parts = np.concatenate([keys[e[bounded]] + side[bounded] + 1, keys[i] + band - edge_first[i]])
    region = linked_components(pieces, parts + len(area), len(area) + keys[-1])[: len(area)]
    # The sides of links.
    named, g, _, side, start, last = along
    ends = [_piece_beside(begins, first, flat, g[at], edge_low[named[at]], side[at]) for at in (start, last)]
    sides = region[np.concatenate([np.stack([below, below + 1], axis=1), np.stack(ends, axis=1)])]
    border = len(f) + np.flatnonzero(start == last)
    sides[border, (side[start[start == last]] < 0).astype(int)] = -1
    return sides, np.asarray(np.bincount(region, area), dtype=float)


def _piece_beside(begins: Ints, first: Ints, flat: Ints, g: Ints, at: Ints, side: Ints) -> Ints:
    """Return the piece of faces g beside an edge with both ends at a place, on the side of the sign."""
    return np.asarray(begins[g] + np.where(flat[g], 0, (at + side) // 2 - first[g]))


def _share_below(values: Floats, levels: Floats) -> Floats:
    """Return the share of the area of faces with these values, (m, 3), below a level between them, (m,)."""
    a, b, c = np.sort(values, axis=1).T / 2
    L = np.clip(levels / 2, a, c)
    with np.errstate(invalid="ignore", divide="ignore"):
        corner = (L - a) / (b - a) * ((L - a) / (c - a))
        rest = 1 - (c - L) / (c - b) * ((c - L) / (c - a))
    return np.asarray(np.nan_to_num(np.where(b >= L, corner, rest)))


def separated_areas(areas: Floats, lines: Ints) -> Floats:
    """Return the areas on both sides of lines, (p, 2), that separate regions, (p, 2); NaN where a line does not.

    A line separates if it is a bridge of the graph of regions that lines join: a tree edge that no cycle contains. Each
    edge outside of the tree adds a random number at one end, and subtracts it at the other. Sums over the subtree below
    a bridge are zero.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    size, found = len(areas), np.full(lines.shape, np.nan)
    usable = np.flatnonzero((lines[:, 0] != lines[:, 1]) & (lines >= 0).all(axis=1))
    if not len(usable):
        return found
    u, v = lines[usable].T
    component = linked_components(u, v, size)
    roots = np.unique(component, return_index=True)[1]
    pairs = np.sort(lines[usable], axis=1)
    i, j = np.append(pairs[:, 0], roots), np.append(pairs[:, 1], np.full(len(roots), size))
    graph = coo_array((np.ones(len(i)), (i, j)), shape=(size + 1, size + 1)).tocsr()
    order, before = breadth_first_order(graph, size, directed=False)
    # The tree edge of each region is the first line between it and its predecessor.
    key = pairs[:, 0] * np.int64(size + 1) + pairs[:, 1]
    names, first = np.unique(key, return_index=True)
    own = np.setdiff1d(order[1:], roots)
    parent = before[own]
    tree = first[np.searchsorted(names, np.minimum(own, parent) * np.int64(size + 1) + np.maximum(own, parent))]
    other = np.setdiff1d(np.arange(len(usable)), tree)
    tokens = np.random.default_rng(0).integers(1, 2**62, len(other)).tolist()
    sums, area = [0] * (size + 1), [*areas.tolist(), 0.0]
    for token, one, two in zip(tokens, u[other].tolist(), v[other].tolist(), strict=True):
        sums[one] += token
        sums[two] -= token
    for node in order[:0:-1].tolist():
        sums[before[node]] += sums[node]
        area[before[node]] += area[node]
    total = np.bincount(component, areas)[component[own]]
    inside = np.array(area)[own]
    bridges = np.array([sums[node] == 0 for node in own.tolist()], dtype=bool)
    child = (lines[usable[tree], 1] == own).astype(int)
    rows = usable[tree]
    found[rows, child], found[rows, 1 - child] = inside, np.maximum(total - inside, 0.0)
    found[rows[~bridges]] = np.nan
    return found
