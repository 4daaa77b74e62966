"""Distance along edges: an upper bound on geodesic distance, and the order in which heat arrives."""

import numpy as np

from geomhw.mesh.arrays import Floats, Ints
from geomhw.mesh.polyhedral import PolyhedralSurface


def edge_path_distance(mesh: PolyhedralSurface, sources: Ints, start: Floats | None = None) -> Floats:
    """Length of the shortest path along edges from the nearest source vertex, (n,); inf where there is none.

    start: (n,), how long paths are already at the sources; by default 0.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    # Of several edges between the same vertices the shortest counts; a sparse matrix would add them up.
    order = np.lexsort((mesh.edge_lengths, *mesh.edges.T))
    ends = mesh.edges[order]
    shortest = np.any(np.diff(ends, axis=0, prepend=-1), axis=1)
    i, j = ends[shortest].T
    n = mesh.n_vertices
    lengths = mesh.edge_lengths[order][shortest]
    first = np.asarray(sources)
    if start is not None and start[first].any():
        # One more vertex, from which all paths start.
        i, j, lengths = np.append(i, np.full(len(first), n)), np.append(j, first), np.append(lengths, start[first])
        first = np.array([n])
    graph = coo_array((lengths, (i, j)), shape=(n + 1, n + 1)).tocsr()
    distances: Floats = dijkstra(graph, directed=False, indices=first, min_only=True)
    return distances[:n]
